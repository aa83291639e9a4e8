#include "build/builder.hpp"

#include "build/boundary_check.hpp"
#include "build/boundary_surface.hpp"
#include "build/candidates.hpp"
#include "build/certify.hpp"
#include "build/checkpoint.hpp"
#include "build/choose_predictor.hpp"
#include "build/collapse_cost.hpp"
#include "build/cut_conflicts.hpp"
#include "build/describe_options.hpp"
#include "build/error_limits.hpp"
#include "build/field_samples.hpp"
#include "build/memory_need.hpp"
#include "build/mesh_scales.hpp"
#include "build/normalized_fields.hpp"
#include "build/piece_decisions.hpp"
#include "build/process_memory.hpp"
#include "build/removed_vertices.hpp"
#include "build/report.hpp"
#include "build/trial.hpp"
#include "build/working_complex.hpp"
#include "mesh/shape.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace ptet::build {
namespace {

constexpr unsigned kMostThreads = 1024;
/// Collapses made again between two reports of progress.
constexpr std::size_t kReplayBatch = 4096;
/// An evaluation is given up once its error is so many times the round's cost: it would be put back anyway, and the
/// factor keeps it from coming up again at once. Later, at 2, costs a tenth more time and 2% of the mean square.
constexpr double kGiveUpAt = 1.2;
/// So many candidates are measured before who waits is asked whether to go on: some tenths of a second of work.
constexpr std::size_t kMeasuredBetweenLooks = 2048;
/// So many stars are examined at once: enough to share out, and few enough to stay in a cache until they are collapsed.
constexpr std::size_t kClaims = 256;

template <class F>
double seconds_of(F&& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class Builder {
public:
  /// `whole`: the mesh that this is a part of, with `samples` in the part; null: this is all of it.
  Builder(const PreparedMesh& prepared, const BuildOptions& options, BuildReport& report,
          const ProgressCallback& progress, const MeshScales* whole = nullptr, FieldSamples samples = {})
      : prepared_(prepared), options_(options), report_(report), progress_(progress), checkpoints_(options.checkpoint),
        frozen_(prepared.frozen), fields_(prepared, options.fields, whole != nullptr ? &whole->field_range : nullptr),
        scales_(whole != nullptr ? *whole : scales_of(prepared, fields_)), diagonal_(scales_.diagonal),
        limits_(prepared, fields_, options, diagonal_),
        complex_(prepared.used_vertex_count, prepared.mesh.tets, prepared.boundary_faces),
        surface_(complex_, prepared.points, diagonal_, frozen_,
                 bounds_domain_error() ? DomainError::kBound : DomainError::kSampled),
        boundary_(complex_, surface_, limits_.domain()), removed_(prepared.points, fields_, diagonal_),
        predictor_(choose_predictor(options.prediction, complex_, prepared.points, fields_, diagonal_,
                                    limits_.field_weights(), limits_.domain_weight(), whole)),
        cost_(options.objective, limits_.field_weights()), touched_(prepared.used_vertex_count + 1, 0),
        claimed_(prepared.used_vertex_count + 1, 0), alive_count_(prepared.used_vertex_count) {
    if (evaluates_exactly() || (limits_.bound_fields() && options.evaluation == Evaluation::kExact))
      exact_.emplace(prepared, fields_.view());
    if (options.evaluation == Evaluation::kSamples)
      removed_.hold_samples(complex_, whole != nullptr ? std::move(samples)
                                                       : field_samples(prepared.mesh.tets, prepared.points, fields_));
    stream_.volume = scales_.volume;
    squared_scale_ = squared_scales(fields_, stream_.volume);
    vertex_volume_ = stream_.volume / std::max<double>(1, scales_.vertex_count);
    if (evaluates_exactly()) {
      slot_squared_.resize(complex_.slot_count() * fields_.field_count());
      known_.resize(prepared.used_vertex_count);
    }
    // Where errors have limits, what a measurement ends with depends on what it has seen.
    remembers_ = !limits_.bound_fields();
    frozen_.resize(prepared.used_vertex_count);
    candidates_.emplace(
        complex_, surface_, *predictor_.predictor, predictor_.quadrics, cost_, options.prediction,
        options.round_fraction,
        [this] {
          return Trial(complex_, prepared_.points, removed_, exact_ ? &*exact_ : nullptr, options_.min_quality,
                       options_.max_star);
        },
        frozen_);
    report.collapses[static_cast<std::size_t>(CollapseStatus::kFrozenVertex)] =
        static_cast<std::uint64_t>(std::count_if(frozen_.begin(), frozen_.end(), [](char x) { return x != 0; }));
    const double target = options.target_vertices < 1
                              ? options.target_vertices * static_cast<double>(prepared.used_vertex_count)
                              : options.target_vertices;
    target_count_ = static_cast<std::uint32_t>(std::min<double>(std::ceil(target), alive_count_));
  }

  RecordStream run(const Decisions* decided) {
    begin_stream();
    release_freed_memory();
    in_arena([&](oneapi::tbb::task_arena& arena) { build(arena, decided); });
    report_records(prepared_, stream_, report_);
    return std::move(stream_);
  }

  /// The collapses alone.
  RecordStream collapse() {
    begin_stream();
    in_arena([&](oneapi::tbb::task_arena& arena) { arena.execute([&] { collapse_all(); }); });
    report_.simulations = candidates_->simulations();
    return std::move(stream_);
  }

private:
  template <class Work>
  void in_arena(Work&& work) const {
    const int threads = options_.threads == 0 ? oneapi::tbb::info::default_concurrency()
                                              : static_cast<int>(std::min(options_.threads, kMostThreads));
    // More threads than cores are allowed, where they are asked for.
    const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(threads));
    oneapi::tbb::task_arena arena(threads);
    work(arena);
  }

  void build(oneapi::tbb::task_arena& arena, const Decisions* decided) {
    if (checkpoints_.enabled()) identify();
    if (options_.checkpoint.resume) report_.resume_seconds = seconds_of([&] { arena.execute([&] { resume(); }); });
    if (decided != nullptr) report_.follow_seconds = seconds_of([&] { arena.execute([&] { follow(*decided); }); });
    if (!collapsed_) {
      report_.collapse_seconds = seconds_of([&] { arena.execute([&] { collapse_all(); }); });
      report_.simulations += candidates_->simulations();
      collapsed_ = true;
    }
    give_up_collapsing();
    if (options_.evaluation == Evaluation::kExact && !evaluates_exactly())
      report_.certify_seconds = seconds_of([&] {
        arena.execute([&] {
          certify_field_errors(
              prepared_, fields_, stream_, [this](const Progress& p) { return go_on(p); }, &certified_);
        });
      });
    if (checkpoints_.enabled()) save(); // what follows takes little time, and is not kept
    arena.execute([&] { report_.cut_dependencies = add_cut_dependencies(prepared_, stream_, progress_); });
  }

  /// What follows the collapses wants the memory.
  void give_up_collapsing() {
    candidates_.reset();
    predictor_ = {};
    exact_.reset();
    slot_squared_ = std::vector<double>(); // {} would keep its memory
    known_.clear();
    known_.shrink_to_fit();
    complex_ = WorkingComplex(0, {}, {});
    release_freed_memory();
  }

  /// What became of the exact evaluation of a candidate.
  struct Verdict {
    CollapseStatus status = CollapseStatus::kAccepted;
    float cost = 0;
    std::vector<double> errors;    ///< one a field, fractions of the ranges
    std::vector<double> outside;   ///< likewise, at removed vertices that no tet covers
    std::vector<double> integrals; ///< of the squared error: modified slot x field
    double domain_error = 0;       ///< a bound, where the collapse moves the boundary
    BoundarySurface::Handover handover;
  };

  [[nodiscard]] bool bounds_domain_error() const { return options_.evaluation == Evaluation::kExact; }
  [[nodiscard]] bool evaluates_exactly() const { return options_.prediction == Prediction::kExact; }

  void begin_stream() {
    stream_.fields = fields_.fields();
    stream_.diagonal = diagonal_;
    stream_.original_tet_count = static_cast<std::uint32_t>(prepared_.mesh.tets.size());
    stream_.original_ghost_count = static_cast<std::uint32_t>(prepared_.boundary_faces.size());
    // A collapse makes some 17 versions and consumes some 22; where there is room for all of them at first, the lists
    // are never there twice. What is not used takes no memory.
    stream_.versions.reserve(complex_.slot_count() + std::size_t{20} * alive_count_);
    stream_.fine.reserve(std::size_t{26} * alive_count_);
    for (SlotId s = 0; s < complex_.slot_count(); ++s) {
      Slot& slot = complex_.slot(s);
      stream_.versions.push_back(complex_.tet_of(slot));
      if (!complex_.is_ghost(slot))
        slot.quality = static_cast<float>(shape_quality(prepared_.points[slot.v[0]], prepared_.points[slot.v[1]],
                                                        prepared_.points[slot.v[2]], prepared_.points[slot.v[3]]));
    }
  }

  void collapse_all() {
    while (alive_count_ > target_count_) {
      ++round_;
      candidates_->predict(round_, [this] { tell_within_round(); });
      const auto picked = candidates_->pick();
      if (picked.empty()) {
        if (swept_) break;
        // Refusals may have lost their reason by collapses near by: look at everything once more.
        candidates_->forget_all();
        swept_ = true;
        before_sweep_ = refusals();
        continue;
      }
      const std::size_t before = stream_.size();
      if (evaluates_exactly())
        take_measured(picked);
      else
        take_predicted(picked);
      if (stream_.size() != before) {
        swept_ = false;
        ++report_.rounds;
        report_.walk.push_back({vertices_left(), candidates_->round_cost()});
      }
      tell_progress();
    }
    report_.stopped_by = alive_count_ <= target_count_ ? "target" : why_stuck();
    report_.collapses = refusals();
  }

  /// By CollapseStatus: what has become of all half-edges looked at so far.
  [[nodiscard]] StatusCounts refusals() const {
    StatusCounts sum = candidates_->refusals();
    for (std::size_t i = 0; i < sum.size(); ++i)
      sum[i] += report_.collapses[i];
    return sum;
  }

  /// What stands against the half-edges that are left, from the last sweep over all of them.
  [[nodiscard]] std::string why_stuck() const {
    const StatusCounts all = refusals();
    std::string reasons;
    for (std::size_t i = 1; i < kCollapseStatusCount; ++i) {
      const std::uint64_t count = all[i] - before_sweep_[i];
      if (count != 0)
        reasons += (reasons.empty() ? "" : ", ") + std::string(name_of(static_cast<CollapseStatus>(i))) + " " +
                   std::to_string(count);
    }
    const auto frozen = alive_count_ - candidates_->movable_count();
    if (frozen != 0)
      reasons += (reasons.empty() ? "" : ", ") + std::string("frozen vertices ") + std::to_string(frozen);
    return "no candidate left (" + (reasons.empty() ? "no edge may be collapsed" : "refused: " + reasons) + ")";
  }

  [[nodiscard]] std::uint64_t vertices_left() const {
    return alive_count_ + prepared_.mesh.vertex_count() - prepared_.used_vertex_count;
  }

  [[nodiscard]] Progress progress_of_collapses() const {
    const std::uint64_t total = prepared_.used_vertex_count - std::min(target_count_, prepared_.used_vertex_count);
    return {"collapsing", stream_.size(), total};
  }

  void tell_progress() {
    if (!go_on(progress_of_collapses())) throw Error(ErrorCode::kCancelled, "the build was cancelled");
  }

  /// A checkpoint is of whole rounds: where one is wanted, stopping waits for the end of this one.
  void tell_within_round() {
    if (stopping_ || !progress_ || progress_(progress_of_collapses())) return;
    if (!checkpoints_.enabled()) throw Error(ErrorCode::kCancelled, "the build was cancelled");
    stopping_ = true;
  }

  // ---- checkpoints, between rounds and between batches of certified records ----

  /// What the caller says to this progress. Keeps a checkpoint when it is time, and before stopping.
  bool go_on(const Progress& progress) {
    const bool goes_on = !stopping_ && (!progress_ || progress_(progress));
    const bool has_memory = !near_memory_limit(options_);
    if (checkpoints_.due() || (checkpoints_.enabled() && !(goes_on && has_memory))) save();
    if (goes_on && !has_memory)
      throw Error(ErrorCode::kLimit, "the process has come near the memory limit of " +
                                         bytes_text(options_.memory_limit) + " while " + std::string(progress.stage) +
                                         ", " + std::to_string(progress.done) + " of " +
                                         std::to_string(progress.total) +
                                         (checkpoints_.enabled() ? "; what was done is in the checkpoint" : ""));
    return goes_on;
  }

  void identify() { identity_ = identity_of(prepared_.mesh, describe_options(options_, prepared_, fields_.fields())); }

  void save() {
    checkpoints_.write(
        identity_,
        [&](file::OutputArchive& archive) {
          serialize_records(archive, stream_);
          serialize_rest(archive);
        },
        report_);
  }

  void resume() {
    StoredState stored(options_.checkpoint.path, identity_);
    RecordStream decided;
    serialize_records(stored.archive(), decided);
    if (const std::string wrong = replay(decided); !wrong.empty()) stored.refuse(wrong);
    serialize_rest(stored.archive());
    stored.finish();
    report_.resumed_records = stream_.size();
  }

  /// The collapses, and what the records say that making them again does not.
  template <class Archive>
  static void serialize_records(Archive& archive, RecordStream& records) {
    archive& records.removed& records.target& records.round& records.field_error& records.outside_error& records
        .domain_error& records.squared_error;
  }

  /// All else that lasts from one round to the next and does not come back with the collapses.
  template <class Archive>
  void serialize_rest(Archive& archive) {
    archive& round_& swept_& collapsed_& certified_& before_sweep_;
    archive& report_.collapses& report_.rounds& report_.walk& report_.stopped_by& report_.simulations& report_
        .exact_evaluations;
    if (collapsed_) return;
    serialize_sparse(archive, slot_squared_);
    archive&* candidates_;
  }

  /// Makes the collapses of `decided` once more. Returns what does not fit, or nothing.
  [[nodiscard]] std::string replay(const RecordStream& decided) {
    const std::size_t count = decided.removed.size();
    const std::size_t fields = fields_.field_count();
    if (decided.target.size() != count || decided.round.size() != count || decided.domain_error.size() != count ||
        decided.field_error.size() != count * fields ||
        (!decided.outside_error.empty() && decided.outside_error.size() != count * fields) ||
        (!decided.squared_error.empty() && decided.squared_error.size() != count * fields))
      return "its tables differ in length";
    record_errors_.assign(fields, 0.0);
    outside_errors_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      if (i % kReplayBatch == 0 && progress_ && !progress_({"going on from the checkpoint", i, count}))
        throw Error(ErrorCode::kCancelled, "the build was cancelled");
      round_ = decided.round[i];
      if (!collapse_again(decided.removed[i].index(), decided.target[i].index()))
        return "collapse " + std::to_string(i) + " is not possible";
      if (stream_.domain_error.back() != decided.domain_error[i])
        return "collapse " + std::to_string(i) + " has another domain error here";
    }
    stream_.field_error = decided.field_error;
    stream_.outside_error = decided.outside_error;
    stream_.squared_error = decided.squared_error;
    return {};
  }

  // ---- what was decided in pieces of the mesh ----

  /// Makes the collapses of every piece, as far as they are possible.
  void follow(const Decisions& decided) {
    const RecordStream& records = decided.records;
    record_errors_.clear(); // what the pieces measured is appended instead
    outside_errors_.clear();
    std::vector<char> is_over(report_.pieces);
    std::size_t round = 0;
    for (std::size_t i = 0; i < records.removed.size(); ++i) {
      if (i % kReplayBatch == 0 && progress_ && !progress_({"joining the pieces", i, records.removed.size()}))
        throw Error(ErrorCode::kCancelled, "the build was cancelled");
      round_ = records.round[i];
      char& over = is_over[decided.piece[i]];
      if (over == 0 && collapse_again(records.removed[i].index(), records.target[i].index())) {
        stream_.append_errors(records, i, fields_.field_count());
      } else {
        over = 1;
      }
      if (i + 1 < records.removed.size() && records.round[i + 1] == round_) continue;
      ++report_.rounds;
      report_.walk.push_back({vertices_left(), decided.round_cost[round++]});
    }
    report_.piece_records = stream_.size();
    report_.piece_records_dropped = records.removed.size() - stream_.size();
    for (std::size_t i = 0; i < report_.collapses.size(); ++i)
      report_.collapses[i] += decided.collapses[i];
    report_.simulations = decided.simulations;
    report_.exact_evaluations = decided.exact_evaluations;
    if (evaluates_exactly()) measure_slots();
  }

  /// The integrals of the squared error over the versions that are there.
  void measure_slots() {
    const std::size_t fields = fields_.field_count();
    std::vector<SlotId> made;
    for (Vertex v = 0; v < complex_.vertex_count(); ++v)
      for (const SlotId s : complex_.star(v)) {
        const Slot& slot = complex_.slot(s);
        if (slot.version != s && !complex_.is_ghost(slot) && v == *std::min_element(slot.v.begin(), slot.v.end()))
          made.push_back(s);
      }
    oneapi::tbb::enumerable_thread_specific<ExactFieldError::Workspace> workspaces(
        [&] { return ExactFieldError::Workspace(*exact_); });
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, made.size(), 64), [&](const auto& range) {
      std::vector<double> errors(fields);
      for (std::size_t i = range.begin(); i != range.end(); ++i) {
        const std::span<double> squared(slot_squared_.data() + made[i] * fields, fields);
        std::fill(errors.begin(), errors.end(), 0.0);
        exact_->measure(complex_.tet_of(complex_.slot(made[i])), workspaces.local(), errors, squared);
        for (std::size_t f = 0; f < fields; ++f)
          if (certified(errors[f]) == 0) squared[f] = 0; // where there is no error the integral is rounding
      }
    });
  }

  /// A collapse that was accepted before: nothing is asked that only refuses. False when it cannot be.
  bool collapse_again(Vertex vs, Vertex vd) {
    const std::uint32_t vertices = complex_.vertex_count();
    if (vs >= vertices || vd >= vertices || vs == vd || !complex_.alive(vs) || !complex_.alive(vd)) return false;
    Trial& trial = candidates_->trial();
    const CollapseCheck& check = trial.check();
    if (trial.examine(vs, vd) != CollapseStatus::kAccepted || check.deleted().empty()) return false;
    double domain_error = 0;
    if (check.moves_boundary()) {
      if (!surface_.collapse_ok(vs, vd)) return false;
      domain_error = bounds_domain_error() ? boundary_.bound(vs, vd, handover_) : surface_.simulate(vs, vd);
      if (domain_error > limits_.domain()) return false;
    }
    if (options_.evaluation != Evaluation::kNone) trial.simulate();
    commit(vs, vd, trial, domain_error, nullptr, height_of_record(vs));
    return true;
  }

  /// One more than the records below its star.
  [[nodiscard]] std::uint32_t height_of_record(Vertex vs) const {
    std::uint32_t height = 0;
    for (const SlotId s : complex_.star(vs))
      height = std::max(height, complex_.slot(s).height);
    return height + 1;
  }

  /// Takes the collapses of a round by what was predicted of them: again and again the first of those left that do not
  /// depend on one another are examined in parallel, and collapsed one by one.
  void take_predicted(const std::vector<Vertex>& picked) {
    std::vector<Vertex> waiting;
    for (std::size_t next = 0; alive_count_ > target_count_ && (next < picked.size() || !waiting.empty());) {
      next = claim_stars(picked, next, waiting);
      oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, claims_.size(), 16), [&](const auto& range) {
        Trial& trial = candidates_->trial();
        for (std::size_t i = range.begin(); i != range.end(); ++i)
          examine_claim(claims_[i], plans_[i], trial);
      });
      for (std::size_t i = 0; i < claims_.size() && alive_count_ > target_count_; ++i)
        if (!take_claim(claims_[i], plans_[i])) waiting.push_back(claims_[i]);
    }
  }

  /// Sorts vertices that may still go in this round, first those that are `waiting` and then those of `picked` from
  /// place `next` on, into claims, which depend on nobody before them, and others, which wait on. Returns the place of
  /// the first that was not looked at.
  std::size_t claim_stars(const std::vector<Vertex>& picked, std::size_t next, std::vector<Vertex>& waiting) {
    ++claim_stamp_;
    claims_.clear();
    std::size_t kept = 0;
    const auto look_at = [&](Vertex vs) {
      if (!may_go(vs)) return true;
      const bool free = claimed_[vs] != claim_stamp_ && claimed_[candidates_->best(vs).target] != claim_stamp_;
      if (free) claims_.push_back(vs);
      // Who waits comes before what it would touch, too.
      for (const SlotId s : complex_.star(vs))
        for (const Vertex x : complex_.slot(s).v)
          claimed_[x] = claim_stamp_;
      return free;
    };
    for (const Vertex vs : waiting)
      if (!look_at(vs)) waiting[kept++] = vs;
    waiting.resize(kept);
    for (; next < picked.size() && claims_.size() < kClaims && waiting.size() < kClaims; ++next) {
      if (next + WorkingComplex::kPrefetch < picked.size())
        complex_.prefetch_star(picked[next + WorkingComplex::kPrefetch]);
      if (!look_at(picked[next])) waiting.push_back(picked[next]);
    }
    ++claim_stamp_; // from now on for what has changed
    plans_.resize(std::max(plans_.size(), claims_.size()));
    return next;
  }

  /// Whether the star of `vs` is as it was when the round began, and its best half-edge within the round's cost.
  [[nodiscard]] bool may_go(Vertex vs) const {
    return touched_[vs] != round_ && candidates_->best(vs).target != kNone &&
           candidates_->best(vs).cost <= candidates_->round_cost();
  }

  /// Goes down the half-edges of `vs`, to the first that is not refused by what depends on nothing but the stars of its
  /// ends: of that `plan` tells, if there is one.
  void examine_claim(Vertex vs, CollapsePlan& plan, Trial& trial) {
    plan.vs = kNone;
    while (may_go(vs)) {
      const CollapseStatus status = trial.examine(vs, candidates_->best(vs).target);
      if (status == CollapseStatus::kAccepted) {
        trial.swap(plan);
        return;
      }
      candidates_->count_refusal(status);
      candidates_->drop_best(vs, round_);
    }
  }

  /// False when its best half-edge within the round's cost, if there is one, is yet to be examined.
  bool take_claim(Vertex vs, CollapsePlan& plan) {
    if (plan.vs == kNone) return true;
    const Vertex vd = plan.vd;
    CollapseStatus status = CollapseStatus::kAccepted;
    if (claimed_[vd] == claim_stamp_) // another collapse has changed its star
      status = candidates_->trial().examine(vs, vd);
    else
      candidates_->trial().swap(plan);
    if (status == CollapseStatus::kAccepted) status = collapse_if_allowed(nullptr);
    if (counted(status) != CollapseStatus::kAccepted) {
      candidates_->drop_best(vs, round_);
      return false;
    }
    claimed_[vd] = claim_stamp_;
    for (const LinkVertex& x : candidates_->trial().check().plan().link)
      claimed_[x.vertex] = claim_stamp_;
    return true;
  }

  /// Measures candidates whose stars do not overlap, in parallel, and takes those that are still among the best.
  void take_measured(const std::vector<Vertex>& picked) {
    std::vector<Vertex> apart;
    for (const Vertex vs : picked) {
      if (touched_[vs] == round_) continue;
      for (const SlotId s : complex_.star(vs))
        for (const Vertex x : complex_.slot(s).v)
          touched_[x] = round_;
      apart.push_back(vs);
    }
    touched_[complex_.dummy()] = 0;
    std::vector<Verdict> verdicts(apart.size());
    for (std::size_t begin = 0; begin < apart.size(); begin += kMeasuredBetweenLooks) {
      if (begin > 0) tell_within_round();
      const std::size_t end = std::min(begin + kMeasuredBetweenLooks, apart.size());
      oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(begin, end, 8), [&](const auto& range) {
        Trial& trial = candidates_->trial();
        for (std::size_t i = range.begin(); i != range.end(); ++i)
          verdicts[i] = measure(apart[i], trial);
      });
    }
    report_.exact_evaluations += static_cast<std::uint64_t>(std::count_if(
        verdicts.begin(), verdicts.end(), [](const Verdict& verdict) { return !verdict.errors.empty(); }));
    for (std::size_t i = 0; i < apart.size() && alive_count_ > target_count_; ++i) {
      const Vertex vs = apart[i];
      if (verdicts[i].status == CollapseStatus::kAccepted && verdicts[i].cost > candidates_->round_cost()) {
        candidates_->raise_best(vs, verdicts[i].cost);
        continue;
      }
      CollapseStatus status = verdicts[i].status;
      if (status == CollapseStatus::kAccepted) status = try_collapse(vs, candidates_->best(vs).target, &verdicts[i]);
      if (counted(status) != CollapseStatus::kAccepted) candidates_->drop_best(vs, round_);
    }
  }

  /// The exact errors of a candidate and what it costs by them; at least kGiveUpAt times the round's cost when it was
  /// given up.
  [[nodiscard]] Verdict measure(Vertex vs, Trial& trial) {
    const std::size_t fields = fields_.field_count();
    const HalfEdge half_edge = candidates_->best(vs);
    Verdict verdict;
    verdict.status = trial.examine(vs, half_edge.target);
    const bool moves_boundary = trial.check().moves_boundary();
    // What the boundary forbids is cheaper to find out than what a measurement costs.
    if (verdict.status == CollapseStatus::kAccepted && moves_boundary)
      verdict.status = boundary_.examine(trial.check().plan());
    if (verdict.status != CollapseStatus::kAccepted) return verdict;
    const RemovedVertices::Simulation& seen = trial.simulate();
    verdict.errors.assign(seen.errors_inside().begin(), seen.errors_inside().end());
    verdict.outside.assign(seen.errors_outside().begin(), seen.errors_outside().end());
    // The integral grows from what stands in the star now to what the collapse makes of it.
    std::vector<double> before(fields), growth(fields);
    for (const std::span<const SlotId> part : {trial.check().deleted(), trial.check().modified()})
      for (const SlotId s : part)
        for (std::size_t f = 0; f < fields; ++f)
          before[f] += slot_squared_[s * fields + f];
    const double enough = kGiveUpAt * static_cast<double>(candidates_->round_cost());
    // Always in the order of the slots, and of what has not been measured nothing: the sums only rise, and whether they
    // pass a limit does not depend on what was measured first.
    const auto cost = [&] {
      std::fill(growth.begin(), growth.end(), 0.0);
      for (std::size_t i = 0; i < verdict.integrals.size(); ++i)
        growth[i % fields] += verdict.integrals[i];
      for (std::size_t f = 0; f < fields; ++f)
        growth[f] = (growth[f] - before[f]) / vertex_volume_;
      return std::max({cost_.of_maximum(verdict.errors), cost_.of_maximum(verdict.outside), cost_.of_mean(growth)});
    };
    std::vector<double> limit = limits_.field();
    for (std::size_t f = 0; f < fields; ++f)
      limit[f] = std::min(limit[f], cost_.error_at(enough, f));
    if (remembers_ && !known_[vs]) known_[vs] = std::make_unique<KnownVersions>();
    const bool whole = trial.measure(
        verdict.errors, &verdict.integrals, limit, [&] { return cost() > enough; }, known_[vs].get());
    if (limits_.passed_by(verdict.errors) || limits_.passed_by(verdict.outside))
      verdict.status = CollapseStatus::kFieldError;
    verdict.cost = std::max(half_edge.cost, static_cast<float>(cost()));
    // Not to be taken now, whatever is left of it in a float.
    if (!whole)
      verdict.cost = std::max(static_cast<float>(enough), std::nextafter(candidates_->round_cost(), INFINITY));
    if (moves_boundary && verdict.status == CollapseStatus::kAccepted && verdict.cost <= candidates_->round_cost()) {
      verdict.domain_error = boundary_.bound(vs, half_edge.target, verdict.handover);
      if (verdict.domain_error > limits_.domain()) verdict.status = CollapseStatus::kDomainError;
    }
    // What is not put back does not come up again.
    if (verdict.status != CollapseStatus::kAccepted || verdict.cost <= candidates_->round_cost()) known_[vs].reset();
    return verdict;
  }

  CollapseStatus counted(CollapseStatus status) {
    ++report_.collapses[static_cast<std::size_t>(status)];
    return status;
  }

  struct Allowed {
    CollapseStatus status;
    double domain_error; ///< sampled, unless it is to be bounded
  };
  /// What an accepted collapse would do to the boundary.
  [[nodiscard]] Allowed examine_surface(const CollapsePlan& plan) {
    if (!plan.moves_boundary) return {CollapseStatus::kAccepted, 0};
    if (const CollapseStatus refused = boundary_.examine(plan); refused != CollapseStatus::kAccepted)
      return {refused, 0};
    if (bounds_domain_error()) return {CollapseStatus::kAccepted, 0};
    const double domain_error = surface_.simulate(plan.vs, plan.vd);
    return {domain_error > limits_.domain() ? CollapseStatus::kDomainError : CollapseStatus::kAccepted, domain_error};
  }

  /// `measured`: what is known exactly; null: the errors are those at the removed vertices, or as predicted.
  CollapseStatus try_collapse(Vertex vs, Vertex vd, Verdict* measured) {
    const CollapseStatus status = candidates_->trial().examine(vs, vd);
    return status == CollapseStatus::kAccepted ? collapse_if_allowed(measured) : status;
  }

  /// As above, for the half-edge that this thread's trial has accepted.
  CollapseStatus collapse_if_allowed(Verdict* measured) {
    Trial& trial = candidates_->trial();
    const CollapseCheck& check = trial.check();
    const Vertex vs = check.plan().vs, vd = check.plan().vd;
    const auto [status, sampled_domain_error] = examine_surface(check.plan());
    if (status != CollapseStatus::kAccepted) return status;
    double domain_error = sampled_domain_error;
    std::vector<double>& errors = record_errors_;
    errors.resize(fields_.field_count());
    outside_errors_.clear();
    if (options_.evaluation == Evaluation::kNone) {
      predictor_.predictor->field_errors(vs, vd, errors);
    } else {
      const RemovedVertices::Simulation& seen = trial.simulate();
      const bool everywhere = options_.evaluation == Evaluation::kExact;
      const auto stated = everywhere ? seen.errors_inside() : seen.errors();
      errors.assign(stated.begin(), stated.end());
      if (everywhere) outside_errors_.assign(seen.errors_outside().begin(), seen.errors_outside().end());
    }
    if (measured != nullptr) errors = measured->errors;
    if (limits_.passed_by(errors) || limits_.passed_by(outside_errors_)) return CollapseStatus::kFieldError;
    if (measured == nullptr && exact_) {
      std::vector<double> everywhere(errors.size());
      if (!trial.measure(everywhere, nullptr, limits_.field(), [] { return false; }))
        return CollapseStatus::kFieldError;
    }
    if (check.moves_boundary() && bounds_domain_error()) {
      if (measured != nullptr) {
        domain_error = measured->domain_error;
        handover_ = std::move(measured->handover);
      } else {
        domain_error = boundary_.bound(vs, vd, handover_);
      }
      if (domain_error > limits_.domain()) return CollapseStatus::kDomainError;
    }
    commit(vs, vd, trial, domain_error, measured, height_of_record(vs));
    return CollapseStatus::kAccepted;
  }

  void commit(Vertex vs, Vertex vd, const Trial& trial, double domain_error, const Verdict* measured,
              std::uint32_t height) {
    const CollapseCheck& check = trial.check();
    const auto deleted = check.deleted();
    const auto modified = check.modified();
    for (const std::span<const SlotId> part : {modified, deleted})
      for (const SlotId s : part)
        stream_.fine.push_back(VersionId{complex_.slot(s).version});
    touched_[vs] = round_;
    candidates_->forget(vd); // its own cost has changed, not only its star
    for (const LinkVertex& x : check.plan().link) {
      touched_[x.vertex] = round_;
      candidates_->change_star(x, vd, height);
    }

    if (measured != nullptr) record_squared_errors(deleted, modified, measured->integrals);
    if (options_.evaluation != Evaluation::kNone) removed_.commit(complex_, deleted, trial.last_simulation());
    predictor_.predictor->collapse(vs, vd, deleted, modified);
    complex_.collapse(vs, vd, deleted, modified);
    if (check.moves_boundary()) surface_.collapse(complex_, vs, vd, modified, deleted, handover_);

    stream_.removed.push_back(VertexId{vs});
    stream_.target.push_back(VertexId{vd});
    stream_.round.push_back(round_);
    stream_.fine_begin.push_back(stream_.fine.size());
    stream_.modified_count.push_back(static_cast<std::uint16_t>(modified.size()));
    stream_.coarse_begin.push_back(VersionId{static_cast<std::uint32_t>(stream_.versions.size())});
    for (std::size_t m = 0; m < modified.size(); ++m) {
      Slot& slot = complex_.slot(modified[m]);
      slot.version = static_cast<std::uint32_t>(stream_.versions.size());
      slot.quality = check.new_quality()[m];
      slot.height = height;
      stream_.versions.push_back(complex_.tet_of(slot));
    }
    if (stream_.versions.size() >= kNone / 2)
      throw Error(ErrorCode::kLimit, "the build makes more tets than 31-bit ids can name");
    for (std::size_t f = 0; f < record_errors_.size(); ++f)
      stream_.field_error.push_back(record_errors_[f] * fields_.fields()[f].range);
    for (std::size_t f = 0; f < outside_errors_.size(); ++f) // none where they are among the others
      stream_.outside_error.push_back(outside_errors_[f] * fields_.fields()[f].range);
    stream_.also_needs_begin.push_back(stream_.also_needs.size());
    stream_.domain_error.push_back(domain_error);
    report_.depth = std::max(report_.depth, height);
    --alive_count_;
  }

  /// The change of the squared errors, from those of the star's slots to those measured.
  void record_squared_errors(std::span<const SlotId> deleted, std::span<const SlotId> modified,
                             const std::vector<double>& integrals) {
    const std::size_t fields = fields_.field_count();
    for (std::size_t f = 0; f < fields; ++f) {
      double change = 0;
      for (const SlotId s : deleted)
        change -= std::exchange(slot_squared_[s * fields + f], 0.0);
      for (std::size_t m = 0; m < modified.size(); ++m) {
        double& squared = slot_squared_[modified[m] * fields + f];
        change += integrals[m * fields + f] - squared;
        squared = integrals[m * fields + f];
      }
      stream_.squared_error.push_back(change * squared_scale_[f]);
    }
  }

  const PreparedMesh& prepared_;
  const BuildOptions& options_;
  BuildReport& report_;
  const ProgressCallback& progress_;
  CheckpointWriter checkpoints_;
  bool stopping_ = false;  ///< somebody said so within a round
  BuildIdentity identity_; ///< where there are checkpoints
  std::vector<char> frozen_;
  NormalizedFields fields_;
  MeshScales scales_;
  double diagonal_;
  ErrorLimits limits_;
  WorkingComplex complex_;
  BoundarySurface surface_;
  BoundaryCheck boundary_;
  RemovedVertices removed_;
  ChosenPredictor predictor_;
  CollapseCost cost_;
  std::optional<ExactFieldError> exact_; ///< where errors are measured, or limits hold, everywhere
  std::optional<Candidates> candidates_;
  std::vector<std::uint32_t> touched_; ///< by vertex: the last round in which its star changed, or was to change
  // Where collapses are taken by what was predicted of them: those that are examined at the same time.
  std::vector<Vertex> claims_;
  std::vector<CollapsePlan> plans_;
  std::vector<std::uint32_t>
      claimed_; ///< by vertex: odd stamps for stars that are claimed, even for those that changed
  std::uint32_t claim_stamp_ = 0;
  std::uint32_t alive_count_;
  std::uint32_t target_count_ = 0;
  std::uint32_t round_ = 0;
  bool swept_ = true;           ///< nothing was accepted since every vertex was looked at afresh
  bool collapsed_ = false;      ///< no more collapses follow
  std::uint64_t certified_ = 0; ///< records whose field errors have been measured after the collapses
  StatusCounts before_sweep_{}; ///< refusals when the last sweep began
  std::vector<double> squared_scale_;
  double vertex_volume_ = 0;         ///< of an average vertex
  std::vector<double> slot_squared_; ///< slot x field: integral of the squared error, where that is measured
  std::vector<std::unique_ptr<KnownVersions>> known_;  ///< by vertex: where a measured half-edge was put back
  bool remembers_ = false;                             ///< whether it is kept
  std::vector<double> record_errors_, outside_errors_; ///< of the collapse in hand
  BoundarySurface::Handover handover_;                 ///< likewise
  RecordStream stream_;
};

} // namespace

RecordStream build_records(const PreparedMesh& prepared, const BuildOptions& options, BuildReport& report,
                           const ProgressCallback& progress, const Decisions* decided) {
  check_options(options);
  report.pieces = decided != nullptr ? options.pieces : 1;
  return Builder(prepared, options, report, progress).run(decided);
}

RecordStream collapse_part(const PreparedMesh& part, const BuildOptions& options, const MeshScales& whole,
                           FieldSamples samples, BuildReport& report, const ProgressCallback& progress) {
  return Builder(part, options, report, progress, &whole, std::move(samples)).collapse();
}

} // namespace ptet::build
