#include "build/builder.hpp"

#include "build/boundary_surface.hpp"
#include "build/certify.hpp"
#include "build/collapse_check.hpp"
#include "build/cut_conflicts.hpp"
#include "build/normalized_fields.hpp"
#include "build/quadric_predictor.hpp"
#include "build/removed_vertices.hpp"
#include "build/working_complex.hpp"
#include "mesh/shape.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <compare>
#include <limits>
#include <numeric>
#include <optional>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace ptet::build {
namespace {

/// Stars are called into the cache so many vertices ahead.
constexpr std::size_t kPrefetch = 3;
constexpr unsigned kMostThreads = 1024;
constexpr float kNoCandidate = std::numeric_limits<float>::infinity();
/// A vertex all of whose half-edges were refused waits 1, 2, 4, ... rounds; at most 2 to this power.
constexpr std::uint32_t kLongestWait = 5;
/// Without thresholds from the user, a domain error of this fraction of the diagonal weighs as much as a field error
/// of the whole range.
constexpr double kDomainPerField = 1.0 / 16;

struct HalfEdge {
  float cost = kNoCandidate;
  Vertex target = kNone;
  friend auto operator<=>(const HalfEdge&, const HalfEdge&) = default;
};

/// What is known of a vertex as one to be removed.
struct Candidate {
  HalfEdge next;                  ///< the cheapest half-edge not refused since the star last changed; none: no target
  std::uint32_t height = 0;       ///< longest chain of records below the star
  std::uint32_t failures = 0;     ///< how often every half-edge was refused
  std::uint32_t resume_round = 0; ///< not looked at again before this round, unless nothing else is left
};

double diagonal_of(const PreparedMesh& prepared) {
  Point low = prepared.points.at(0);
  Point high = low;
  for (std::uint32_t v = 0; v < prepared.used_vertex_count; ++v)
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], prepared.points[v][i]);
      high[i] = std::max(high[i], prepared.points[v][i]);
    }
  const double diagonal = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  return diagonal > 0 ? diagonal : 1;
}

/// Largest allowed error of each field, as a fraction of its range; infinite where there is no limit.
std::vector<double> field_limits(const PreparedMesh& prepared, const NormalizedFields& fields,
                                 const std::vector<FieldBound>& bounds) {
  std::vector<double> limits(fields.field_count(), std::numeric_limits<double>::infinity());
  for (const FieldBound& bound : bounds) {
    if (!(bound.bound.value >= 0)) throw Error(ErrorCode::kBadArgument, "a field error limit must be a number >= 0");
    bool found = false;
    for (std::size_t f = 0; f < limits.size(); ++f) {
      const GoverningField& field = fields.fields()[f];
      if (!bound.field.empty() && prepared.mesh.point_arrays[field.array].name != bound.field) continue;
      limits[f] = std::min(limits[f], bound.bound.absolute(field.range) / field.range);
      found = true;
    }
    if (!found && !bound.field.empty())
      throw Error(ErrorCode::kBadArgument, "a limit was given for '" + bound.field + "', which is no governing field");
  }
  return limits;
}

template <class F>
double seconds_of(F&& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class Builder {
public:
  Builder(const PreparedMesh& prepared, const BuildOptions& options, BuildReport& report,
          const ProgressCallback& progress)
      : prepared_(prepared), options_(options), report_(report), progress_(progress), frozen_(prepared.frozen),
        diagonal_(diagonal_of(prepared)), fields_(prepared, options.fields),
        field_limit_(field_limits(prepared, fields_, options.max_field_error)),
        domain_limit_(options.max_domain_error.absolute(diagonal_)),
        complex_(prepared.used_vertex_count, prepared.mesh.tets, prepared.boundary_faces),
        surface_(complex_, prepared.points, diagonal_, frozen_), removed_(prepared.points, fields_, diagonal_),
        predictor_(complex_, prepared.points, fields_, diagonal_, field_weights(), domain_weight()),
        check_(complex_, prepared.points, options.min_quality, options.max_star),
        candidates_(prepared.used_vertex_count), dirty_(prepared.used_vertex_count, 1),
        touched_(prepared.used_vertex_count + 1, 0), alive_count_(prepared.used_vertex_count), marks_([this] {
          return Marks{std::vector<std::uint32_t>(complex_.vertex_count() + 1), 0};
        }) {
    const double target = options.target_vertices < 1
                              ? options.target_vertices * static_cast<double>(prepared.used_vertex_count)
                              : options.target_vertices;
    if (has_field_limits() && options.evaluation == Evaluation::kExact) {
      exact_.emplace(prepared, fields_.view());
      exact_workspace_.emplace(*exact_);
    }
    report.collapses[static_cast<std::size_t>(CollapseStatus::kFrozenVertex)] =
        static_cast<std::uint64_t>(std::count_if(frozen_.begin(), frozen_.begin() + prepared.used_vertex_count,
                                                 [](char frozen) { return frozen != 0; }));
    target_count_ = static_cast<std::uint32_t>(std::min<double>(std::ceil(target), alive_count_));
    for (Vertex v = 0; v < frozen_.size(); ++v)
      if (v < prepared.used_vertex_count && !frozen_[v]) movable_.push_back(v);
  }

  RecordStream run() {
    begin_stream();
    const int threads = options_.threads == 0 ? oneapi::tbb::info::default_concurrency()
                                              : static_cast<int>(std::min(options_.threads, kMostThreads));
    // More threads than cores are allowed, where they are asked for.
    const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(threads));
    oneapi::tbb::task_arena arena(threads);
    report_.collapse_seconds = seconds_of([&] { arena.execute([&] { collapse_all(); }); });
    if (options_.evaluation == Evaluation::kExact)
      report_.certify_seconds =
          seconds_of([&] { arena.execute([&] { certify_field_errors(prepared_, fields_, stream_, progress_); }); });
    arena.execute([&] { report_.cut_dependencies = add_cut_dependencies(prepared_, stream_, progress_); });
    finish_report();
    return std::move(stream_);
  }

private:
  struct Marks {
    std::vector<std::uint32_t> mark;
    std::uint32_t stamp;
  };

  [[nodiscard]] std::vector<double> field_weights() const {
    std::vector<double> weights;
    for (const double limit : field_limit_)
      weights.push_back(std::isfinite(limit) && limit > 0 ? 1 / limit : 1.0);
    return weights;
  }
  [[nodiscard]] bool has_field_limits() const {
    return std::any_of(field_limit_.begin(), field_limit_.end(), [](double x) { return std::isfinite(x); });
  }
  [[nodiscard]] double domain_weight() const {
    // With thresholds for fields, the corner of the growing square is (field limits, domain limit).
    return has_field_limits() && domain_limit_ > 0 ? diagonal_ / domain_limit_ : 1 / kDomainPerField;
  }

  void begin_stream() {
    stream_.fields = fields_.fields();
    stream_.diagonal = diagonal_;
    stream_.original_tet_count = static_cast<std::uint32_t>(prepared_.mesh.tets.size());
    stream_.original_ghost_count = static_cast<std::uint32_t>(prepared_.boundary_faces.size());
    // A collapse makes some 16 versions; reserving for all of them keeps the peak at one copy.
    stream_.versions.reserve(complex_.slot_count() * std::size_t{4});
    for (SlotId s = 0; s < complex_.slot_count(); ++s) {
      Slot& slot = complex_.slot(s);
      stream_.versions.push_back(ids_of(slot));
      if (!complex_.is_ghost(slot))
        slot.quality = static_cast<float>(shape_quality(prepared_.points[slot.v[0]], prepared_.points[slot.v[1]],
                                                        prepared_.points[slot.v[2]], prepared_.points[slot.v[3]]));
    }
  }

  [[nodiscard]] Tet ids_of(const Slot& slot) const {
    Tet tet;
    for (std::size_t i = 0; i < 4; ++i)
      tet[i] = slot.v[i] == complex_.dummy() ? kDummyVertex : VertexId{slot.v[i]};
    return tet;
  }

  void collapse_all() {
    bool swept = true; // nothing was accepted or refused since every vertex was looked at afresh
    while (alive_count_ > target_count_) {
      ++round_;
      predict();
      const auto picked = pick();
      if (picked.empty()) {
        if (swept) break;
        // Refusals may have lost their reason by collapses near by: look at everything once more.
        for (const Vertex v : movable_) {
          dirty_[v] = 1;
          candidates_[v].resume_round = 0;
        }
        swept = true;
        before_sweep_ = report_.collapses;
        continue;
      }
      const std::size_t before = stream_.size();
      for (std::size_t i = 0; i < picked.size() && alive_count_ > target_count_; ++i) {
        if (i + kPrefetch < picked.size()) complex_.prefetch_star(picked[i + kPrefetch]);
        try_vertex(picked[i]);
      }
      if (stream_.size() != before) {
        swept = false;
        ++report_.rounds;
      }
      tell_progress();
    }
    report_.stopped_by = alive_count_ <= target_count_ ? "target" : why_stuck();
  }

  /// What stands against the half-edges that are left, from the last sweep over all of them.
  [[nodiscard]] std::string why_stuck() const {
    std::string reasons;
    for (std::size_t i = 1; i < kCollapseStatusCount; ++i) {
      const std::uint64_t count = report_.collapses[i] - before_sweep_[i];
      if (count != 0)
        reasons += (reasons.empty() ? "" : ", ") + std::string(name_of(static_cast<CollapseStatus>(i))) + " " +
                   std::to_string(count);
    }
    const auto frozen = alive_count_ - movable_.size();
    if (frozen != 0)
      reasons += (reasons.empty() ? "" : ", ") + std::string("frozen vertices ") + std::to_string(frozen);
    return "no candidate left (" + (reasons.empty() ? "no edge may be collapsed" : "refused: " + reasons) + ")";
  }

  void tell_progress() {
    if (!progress_) return;
    const std::uint64_t total = prepared_.used_vertex_count - std::min(target_count_, prepared_.used_vertex_count);
    if (!progress_({"collapsing", stream_.size(), total}))
      throw Error(ErrorCode::kCancelled, "the build was cancelled");
  }

  /// Calls `visit(cost, target)` for every half-edge out of `v` that may be tried; sets its height.
  template <class Visit>
  void for_each_half_edge(Vertex v, Marks& marks, Visit&& visit) {
    ++marks.stamp;
    marks.mark[v] = marks.stamp;
    const bool boundary = surface_.contains(v);
    std::uint32_t height = 0;
    for (const SlotId s : complex_.star(v)) {
      const Slot& slot = complex_.slot(s);
      height = std::max(height, slot.height);
      // A boundary vertex may only move along the boundary: its targets stand in its ghosts.
      if (boundary && !complex_.is_ghost(slot)) continue;
      for (const Vertex x : slot.v) {
        if (x == complex_.dummy() || marks.mark[x] == marks.stamp) continue;
        marks.mark[x] = marks.stamp;
        visit(predictor_.cost(v, x), x);
      }
    }
    candidates_[v].height = height;
  }

  void predict_vertex(Vertex v, Marks& marks) {
    HalfEdge cheapest;
    for_each_half_edge(v, marks, [&](float cost, Vertex x) { cheapest = std::min(cheapest, HalfEdge{cost, x}); });
    candidates_[v].next = cheapest;
  }

  void predict() {
    std::erase_if(movable_, [&](Vertex v) { return !complex_.alive(v); });
    work_.clear();
    for (const Vertex v : movable_)
      if (dirty_[v] && candidates_[v].resume_round <= round_) {
        dirty_[v] = 0;
        work_.push_back(v);
      }
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, work_.size(), 256), [&](const auto& range) {
      Marks& marks = marks_.local();
      for (std::size_t i = range.begin(); i != range.end(); ++i) {
        if (i + kPrefetch < range.end()) complex_.prefetch_star(work_[i + kPrefetch]);
        predict_vertex(work_[i], marks);
      }
    });
  }

  /// The best part of the candidates by cost, in the order (height, octave of cost, vertex).
  std::vector<Vertex> pick() {
    std::vector<Vertex> live;
    for (const Vertex v : movable_)
      if (candidates_[v].next.target != kNone) live.push_back(v);
    if (live.empty()) return live;
    const auto by_cost = [&](Vertex a, Vertex b) {
      return std::tie(candidates_[a].next.cost, a) < std::tie(candidates_[b].next.cost, b);
    };
    const auto count = std::clamp<std::size_t>(
        static_cast<std::size_t>(std::ceil(options_.round_fraction * static_cast<double>(live.size()))), 1,
        live.size());
    std::nth_element(live.begin(), live.begin() + static_cast<std::ptrdiff_t>(count - 1), live.end(), by_cost);
    live.resize(count);
    round_cost_ = candidates_[live.back()].next.cost;
    // Within an octave of cost along the curve of the numbering: what is near in space is near in memory.
    const auto octave = [&](Vertex v) { return std::bit_cast<std::uint32_t>(candidates_[v].next.cost) >> 23U; };
    std::sort(live.begin(), live.end(), [&](Vertex a, Vertex b) {
      return std::make_tuple(candidates_[a].height, octave(a), a) <
             std::make_tuple(candidates_[b].height, octave(b), b);
    });
    return live;
  }

  /// Tries the half-edges out of `vs`, cheapest first, as far as this round's cost goes.
  void try_vertex(Vertex vs) {
    Candidate& candidate = candidates_[vs];
    if (touched_[vs] == round_) return;
    if (counted_try(vs, candidate.next.target)) return;
    const HalfEdge refused = candidate.next;
    half_edges_.clear();
    for_each_half_edge(vs, marks_.local(), [&](float cost, Vertex x) {
      if (refused < HalfEdge{cost, x}) half_edges_.push_back({cost, x});
    });
    std::sort(half_edges_.begin(), half_edges_.end());
    for (const HalfEdge& half_edge : half_edges_) {
      if (half_edge.cost > round_cost_) {
        candidate.next = half_edge;
        return;
      }
      if (counted_try(vs, half_edge.target)) return;
    }
    // A vertex that nothing can be done with is likely to stay so: wait longer each time.
    candidate.next = {};
    candidate.resume_round = round_ + (1U << std::min(candidate.failures++, kLongestWait));
  }

  bool counted_try(Vertex vs, Vertex vd) {
    const CollapseStatus status = try_collapse(vs, vd);
    ++report_.collapses[static_cast<std::size_t>(status)];
    return status == CollapseStatus::kAccepted;
  }

  CollapseStatus try_collapse(Vertex vs, Vertex vd) {
    const CollapseStatus status = check_.examine(vs, vd);
    if (status != CollapseStatus::kAccepted) return status;
    double domain_error = 0;
    if (check_.moves_boundary()) {
      if (!surface_.collapse_ok(vs, vd)) return CollapseStatus::kSurfaceTopology;
      domain_error = surface_.simulate(vs, vd);
      if (domain_error > domain_limit_) return CollapseStatus::kDomainError;
    }
    if (check_.moves_boundary() && surface_.would_intersect(complex_, vs, vd, check_.modified(), check_.deleted()))
      return CollapseStatus::kSelfIntersection;
    removed_.simulate(complex_, vs, vd, check_.deleted(), check_.modified(), check_.moves_boundary());
    const auto errors = removed_.errors();
    for (std::size_t f = 0; f < errors.size(); ++f)
      if (errors[f] > field_limit_[f]) return CollapseStatus::kFieldError;
    if (exact_ && !exact_errors_within_limits(vs, vd)) return CollapseStatus::kFieldError;
    commit(vs, vd, domain_error);
    return CollapseStatus::kAccepted;
  }

  [[nodiscard]] bool exact_errors_within_limits(Vertex vs, Vertex vd) {
    std::vector<double> errors(field_limit_.size(), 0.0);
    for (const SlotId s : check_.modified()) {
      const Slot& slot = complex_.slot(s);
      if (complex_.is_ghost(slot)) continue;
      Tet tet = ids_of(slot);
      std::replace(tet.begin(), tet.end(), VertexId{vs}, VertexId{vd});
      exact_->measure(tet, *exact_workspace_, errors);
      for (std::size_t f = 0; f < errors.size(); ++f)
        if (certified(errors[f]) > field_limit_[f]) return false;
    }
    return true;
  }

  void commit(Vertex vs, Vertex vd, double domain_error) {
    const auto deleted = check_.deleted();
    const auto modified = check_.modified();
    for (const std::span<const SlotId> part : {modified, deleted})
      for (const SlotId s : part) {
        stream_.fine.push_back(VersionId{complex_.slot(s).version});
        for (const Vertex x : complex_.slot(s).v) {
          touched_[x] = round_;
          if (x != complex_.dummy()) dirty_[x] = 1;
        }
      }
    touched_[complex_.dummy()] = 0;

    removed_.commit(complex_, deleted);
    predictor_.merge(vs, vd);
    complex_.collapse(vs, vd, deleted, modified);
    if (check_.moves_boundary()) surface_.collapse(complex_, vs, vd, modified, deleted);

    stream_.removed.push_back(VertexId{vs});
    stream_.target.push_back(VertexId{vd});
    stream_.round.push_back(round_);
    stream_.fine_begin.push_back(stream_.fine.size());
    stream_.modified_count.push_back(static_cast<std::uint16_t>(modified.size()));
    stream_.coarse_begin.push_back(VersionId{static_cast<std::uint32_t>(stream_.versions.size())});
    const std::uint32_t height = candidates_[vs].height + 1;
    for (std::size_t m = 0; m < modified.size(); ++m) {
      Slot& slot = complex_.slot(modified[m]);
      slot.version = static_cast<std::uint32_t>(stream_.versions.size());
      slot.quality = check_.new_quality()[m];
      slot.height = height;
      stream_.versions.push_back(ids_of(slot));
    }
    if (stream_.versions.size() >= kNone / 2)
      throw Error(ErrorCode::kLimit, "the build makes more tets than 31-bit ids can name");
    const auto errors = removed_.errors();
    for (std::size_t f = 0; f < errors.size(); ++f)
      stream_.field_error.push_back(errors[f] * fields_.fields()[f].range);
    stream_.also_needs_begin.push_back(stream_.also_needs.size());
    stream_.domain_error.push_back(domain_error);
    report_.depth = std::max(report_.depth, height);
    candidates_[vs].next = {};
    --alive_count_;
  }

  void finish_report() {
    report_.records = stream_.size();
    report_.base_vertices = alive_count_ + prepared_.mesh.vertex_count() - prepared_.used_vertex_count;
    std::uint64_t deleted_tets = 0;
    for (std::size_t r = 0; r < stream_.size(); ++r) {
      const auto consumed = stream_.consumed(r).subspan(stream_.modified_count[r]);
      deleted_tets += static_cast<std::uint64_t>(std::count_if(consumed.begin(), consumed.end(), [&](VersionId t) {
        const Tet& v = stream_.versions[t.index()];
        return std::find(v.begin(), v.end(), kDummyVertex) == v.end();
      }));
    }
    report_.base_tets = stream_.original_tet_count - deleted_tets;
    const std::size_t k = fields_.field_count();
    for (std::size_t f = 0; f < k; ++f) {
      double worst = 0;
      for (std::size_t r = 0; r < stream_.size(); ++r)
        worst = std::max(worst, stream_.field_error[r * k + f]);
      report_.field_error.emplace_back(prepared_.mesh.point_arrays[fields_.fields()[f].array].name, worst);
    }
    for (const double error : stream_.domain_error)
      report_.domain_error = std::max(report_.domain_error, error);
  }

  const PreparedMesh& prepared_;
  const BuildOptions& options_;
  BuildReport& report_;
  const ProgressCallback& progress_;
  std::vector<char> frozen_;
  double diagonal_;
  NormalizedFields fields_;
  std::vector<double> field_limit_;
  double domain_limit_;
  WorkingComplex complex_;
  BoundarySurface surface_;
  RemovedVertices removed_;
  QuadricPredictor predictor_;
  CollapseCheck check_;
  std::optional<ExactFieldError> exact_; ///< where limits are to hold everywhere
  std::optional<ExactFieldError::Workspace> exact_workspace_;
  std::vector<Candidate> candidates_;
  std::vector<char> dirty_;
  std::vector<std::uint32_t> touched_; ///< by vertex: the last round in which its star changed
  std::uint32_t alive_count_;
  std::uint32_t target_count_ = 0;
  std::uint32_t round_ = 0;
  std::array<std::uint64_t, kCollapseStatusCount> before_sweep_{}; ///< report_.collapses when the last sweep began
  float round_cost_ = 0;
  std::vector<Vertex> movable_; ///< vertices that are there and not frozen
  std::vector<Vertex> work_;
  std::vector<HalfEdge> half_edges_;
  oneapi::tbb::enumerable_thread_specific<Marks> marks_;
  RecordStream stream_;
};

void check_options(const BuildOptions& options) {
  const auto require = [](bool good, const char* what) {
    if (!good) throw Error(ErrorCode::kBadArgument, what);
  };
  require(options.target_vertices >= 0 && std::isfinite(options.target_vertices),
          "the target number of vertices must be a number >= 0");
  require(options.min_quality >= 0 && options.min_quality < 1, "the least quality must be in [0, 1)");
  require(options.max_star >= 8, "the cap on the star must be at least 8");
  require(options.round_fraction > 0 && options.round_fraction <= 1, "the part taken in a round must be in (0, 1]");
  require(options.max_domain_error.value >= 0, "the limit on domain error must be a number >= 0");
}

} // namespace

RecordStream build_records(const PreparedMesh& prepared, const BuildOptions& options, BuildReport& report,
                           const ProgressCallback& progress) {
  check_options(options);
  return Builder(prepared, options, report, progress).run();
}

} // namespace ptet::build
