#include "build/builder.hpp"

#include "build/certify.hpp"
#include "build/checkpoint.hpp"
#include "build/collapser.hpp"
#include "build/cut_conflicts.hpp"
#include "build/describe_options.hpp"
#include "build/memory_need.hpp"
#include "build/normalized_fields.hpp"
#include "build/piece_decisions.hpp"
#include "build/process_memory.hpp"
#include "build/replay.hpp"
#include "build/report.hpp"
#include "build/rounds.hpp"
#include "build/threads.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <chrono>
#include <new>
#include <optional>
#include <utility>

namespace ptet::build {
namespace {

template <class F>
double seconds_of(F&& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class Builder {
public:
  /// `whole`: the mesh that this is a part of, with `samples` in the part; null: this is all of it.
  Builder(PreparedMesh& prepared, const BuildOptions& options, BuildReport& report, const ProgressCallback& progress,
          const MeshScales* whole = nullptr, std::span<const Sample> samples = {})
      : prepared_(prepared), options_(options), report_(report), progress_(progress), threads_(options.threads),
        checkpoints_(options.checkpoint),
        fields_(prepared, options.fields, whole != nullptr ? &whole->field_range : nullptr) {
    report.notes.insert(report.notes.end(), fields_.notes().begin(), fields_.notes().end());
    threads_.run([&] {
      collapser_.emplace(prepared, fields_, whole, samples, options, records_);
      rounds_.emplace(*collapser_, options, round_state_, report);
    });
    if (auto note = whole == nullptr ? flat_domain_note(prepared, collapser_->scales(), options) : std::nullopt)
      report.notes.push_back(std::move(*note));
    report.min_quality = min_quality_of(options, prepared);
    if (checkpoints_.enabled())
      identity_ = identity_of(prepared.mesh, describe_options(options, prepared, fields_.fields()));
    prepared.mesh.tets = std::vector<Tet>(); // the complex has them, and {} would keep their memory
    report.collapses[static_cast<std::size_t>(CollapseStatus::kFrozenVertex)] =
        prepared.used_vertex_count - collapser_->candidates().movable_count();
  }

  RecordStream run(const Decisions* decided) {
    release_freed_memory();
    build(decided);
    report_records(prepared_, records_, report_);
    return std::move(records_);
  }

  /// The collapses alone.
  RecordStream collapse() {
    threads_.run([&] { take_rounds(); });
    return std::move(records_);
  }

private:
  void build(const Decisions* decided) {
    if (options_.checkpoint.resume) report_.resume_seconds = seconds_of([&] { threads_.run([&] { resume(); }); });
    if (decided != nullptr)
      report_.follow_seconds = seconds_of([&] { threads_.run([&] { follow_pieces(*decided); }); });
    if (!collapsed_) {
      report_.collapse_seconds = seconds_of([&] { threads_.run([&] { take_rounds(); }); });
      collapsed_ = true;
    }
    end_collapses();
    if (options_.evaluation == Evaluation::kExact && options_.prediction != Prediction::kExact)
      report_.certify_seconds = seconds_of([&] {
        threads_.run([&] {
          certify_field_errors(
              prepared_, fields_, records_, [this](const Progress& p) { return go_on(p); }, &certified_);
        });
      });
    if (checkpoints_.enabled()) save_in_passing(); // what follows takes little time, and is not kept
    threads_.run([&] { report_.cut_dependencies = add_cut_dependencies(prepared_, records_, progress_); });
  }

  void follow_pieces(const Decisions& decided) {
    follow(decided, *collapser_, report_, progress_);
    if (!decided.records.round.empty()) round_state_.round = decided.records.round.back();
    rounds_->go_on_from_collapses();
  }

  void take_rounds() {
    rounds_->run([this] { tell_within_round(); }, [this] { tell_after_round(); });
  }

  void end_collapses() {
    rounds_.reset(); // what follows wants the memory
    collapser_->end_records();
    collapser_.reset();
    release_freed_memory();
    prepared_.mesh.tets = records_.original();
    prepared_.mesh.tets.resize(records_.original_tet_count); // less the ghosts
  }

  // ---- progress ----

  [[nodiscard]] Progress progress_of_collapses() const {
    return {"collapsing", records_.size(), prepared_.used_vertex_count - collapser_->target_count()};
  }

  /// A checkpoint is of whole rounds: where one is wanted, stopping waits for the end of this one.
  void tell_within_round() {
    if (stopping_ || !progress_ || progress_(progress_of_collapses())) return;
    if (!checkpoints_.enabled()) throw Error(ErrorCode::kCancelled, "the build was cancelled");
    stopping_ = true;
  }

  void tell_after_round() {
    if (!go_on(progress_of_collapses())) throw Error(ErrorCode::kCancelled, "the build was cancelled");
  }

  /// What the caller says to this progress. Keeps a checkpoint when it is time, and before stopping.
  bool go_on(const Progress& progress) {
    const bool goes_on = !stopping_ && (!progress_ || progress_(progress));
    const bool has_memory = !near_memory_limit(options_);
    if (!goes_on && checkpoints_.enabled())
      save();
    else if (checkpoints_.due() || (checkpoints_.enabled() && !has_memory))
      save_in_passing();
    if (goes_on && !has_memory)
      throw Error(ErrorCode::kLimit, "the process has come near the memory limit of " +
                                         limit_text(options_.memory_limit) + " while " + std::string(progress.stage) +
                                         ", " + std::to_string(progress.done) + " of " +
                                         std::to_string(progress.total) + where_it_is());
    return goes_on;
  }

  /// What was done, for who is told that the build ends.
  [[nodiscard]] std::string where_it_is() const {
    if (!checkpoints_.enabled()) return {};
    return last_save_failed_ ? "; a checkpoint could not be written: " + report_.checkpoint_failure
                             : "; what was done is in the checkpoint";
  }

  // ---- checkpoints, between rounds and between batches of certified records ----

  void save() {
    checkpoints_.write(
        identity_,
        [&](file::OutputArchive& archive) {
          serialize_records(archive, records_);
          serialize_rest(archive);
        },
        report_);
    last_save_failed_ = false;
  }

  /// A build that can go on does so without one: it is there for what may happen, and may be possible the next time.
  void save_in_passing() {
    try {
      save();
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kIo) throw;
      go_on_unsaved(error.what());
    } catch (const std::bad_alloc&) {
      go_on_unsaved("there is not enough memory to make one");
    }
  }
  void go_on_unsaved(const char* reason) {
    checkpoints_.put_off();
    ++report_.checkpoints_failed;
    report_.checkpoint_failure = reason;
    last_save_failed_ = true;
  }

  void resume() {
    StoredState stored(options_.checkpoint.path, identity_);
    RecordStream decided;
    serialize_records(stored.archive(), decided);
    if (const std::string wrong = replay(decided, *collapser_, progress_); !wrong.empty()) stored.refuse(wrong);
    serialize_rest(stored.archive());
    stored.finish();
    report_.resumed_records = records_.size();
    report_.depth = collapser_->depth();
  }

  /// The collapses, and what the records say that making them again does not.
  template <class Archive>
  static void serialize_records(Archive& archive, RecordStream& records) {
    archive& records.removed& records.target& records.round& records.field_error& records.outside_error& records
        .domain_error& records.squared_error& records.uncovered_volume;
  }

  /// All else that lasts from one round to the next and does not come back with the collapses.
  template <class Archive>
  void serialize_rest(Archive& archive) {
    archive& round_state_& collapsed_& certified_;
    archive& report_.collapses& report_.rounds& report_.walk& report_.stopped_by& report_.last_refusals& report_
        .simulations& report_.exact_evaluations;
    if (!collapsed_) archive&* rounds_;
  }

  PreparedMesh& prepared_;
  const BuildOptions& options_;
  BuildReport& report_;
  const ProgressCallback& progress_;
  Threads threads_;
  CheckpointWriter checkpoints_;
  BuildIdentity identity_;        ///< where there are checkpoints
  bool stopping_ = false;         ///< somebody said so within a round
  bool last_save_failed_ = false; ///< of a checkpoint
  NormalizedFields fields_;
  RecordStream records_;
  RoundState round_state_;
  // Until nothing more is to be collapsed.
  std::optional<Collapser> collapser_;
  std::optional<Rounds> rounds_;
  bool collapsed_ = false;      ///< no more collapses follow
  std::uint64_t certified_ = 0; ///< records whose field errors have been measured after the collapses
};

} // namespace

RecordStream build_records(PreparedMesh& prepared, const BuildOptions& options, BuildReport& report,
                           const ProgressCallback& progress, const Decisions* decided) {
  check_options(options);
  report.pieces = decided != nullptr ? options.pieces : 1;
  return Builder(prepared, options, report, progress).run(decided);
}

RecordStream collapse_part(PreparedMesh& part, const BuildOptions& options, const MeshScales& whole,
                           std::span<const Sample> samples, BuildReport& report, const ProgressCallback& progress) {
  return Builder(part, options, report, progress, &whole, samples).collapse();
}

} // namespace ptet::build
