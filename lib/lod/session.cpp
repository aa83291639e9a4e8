#include "ptet/session.hpp"

#include "lod/cancellation.hpp"
#include "lod/dataset_impl.hpp"
#include "lod/extraction.hpp"
#include "lod/running_cut.hpp"
#include "lod/running_errors.hpp"
#include "lod/slot_mesh.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

namespace ptet {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::optional<Clock::time_point> end_of(const std::optional<double>& max_milliseconds, Clock::time_point begin) {
  constexpr double kMost = 1e9; // more is no limit, and would not fit a clock
  if (!max_milliseconds) return std::nullopt;
  const std::chrono::duration<double, std::milli> time(std::min(*max_milliseconds, kMost));
  return begin + std::chrono::duration_cast<Clock::duration>(time);
}

std::shared_ptr<const Dataset> checked(std::shared_ptr<const Dataset> dataset) {
  if (!dataset) throw Error(ErrorCode::kBadArgument, "no dataset was given");
  return dataset;
}

} // namespace

class Session::Impl {
public:
  explicit Impl(std::shared_ptr<const Dataset> dataset)
      : dataset_(checked(std::move(dataset))), hierarchy_(dataset_->impl().hierarchy) {
    start_over();
  }
  ~Impl() { hierarchy_.loader().unpin(pinned_); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const SessionUpdate& update(const Request& request, const ProgressCallback& progress) {
    const auto begin = Clock::now();
    if (request.input_order)
      throw Error(ErrorCode::kBadArgument, "a session's slots have an order of their own, not that of the input");
    resolve(request, hierarchy_.header(), next_); // what is refused has changed nothing
    next_asked_ = request;
    next_asked_->max_milliseconds.reset();
    Cancellation cancellation(progress);
    cancellation.check();
    Cancellation* const asks = progress ? &cancellation : nullptr;
    const Loader::Turn turn(hierarchy_.loader(), std::nullopt, asks);
    const std::optional<Clock::time_point> until = end_of(request.max_milliseconds, begin);
    bool is_renumbered = std::exchange(is_broken_, true);
    if (is_renumbered) start_over();
    exchange_requests();
    std::shared_lock<std::shared_mutex> lock;
    try {
      lock = cut_->set(request_, until, asks);
      while (!is_sound(cut_->read())) {
        lock.unlock();
        start_over();
        is_renumbered = true;
        lock = cut_->set(request_, until, asks);
      }
    } catch (const Error& error) {
      // Nothing has been done to the mesh, but to start over, which the next update has to tell of.
      if (error.code() == ErrorCode::kCancelled) {
        is_broken_ = is_renumbered;
        exchange_requests();
      }
      throw;
    }
    // The first update tells of the base mesh, too.
    if (std::exchange(is_told_, true)) mesh_->forget_changes();
    const std::uint64_t tets = result_.tets, vertices = result_.vertices;
    result_ = {};
    find_changes();
    mesh_->make_room();
    if (request_.origins)
      mesh_->follow_creators(cut_->read(), applied_);
    else
      mesh_->forget_creators();
    result_.complete = change(with_a_share(until, begin)) && !cut_->is_out_of_time();
    cut_->drop_touched([&](std::uint32_t r) { return cut_->contains(r) != (applied_[r] != 0); });
    show_unused_vertices();
    if (result_.complete && mesh_->compact()) is_renumbered = true;
    result_.renumbered = is_renumbered;
    errors_->update(applied_, cut_->read());
    describe();
    read_ = cut_->read();
    missing_ = cut_->missing();
    pin(read_);
    result_.tets_added = result_.tets + result_.tets_removed - tets;
    result_.vertices_added = result_.vertices + result_.vertices_removed - vertices;
    result_.seconds = seconds_since(begin);
    is_broken_ = false;
    return result_;
  }

  Extraction extraction() const {
    const auto begin = Clock::now();
    auto lock = hierarchy_.lock();
    if (is_broken_ || !is_sound(read_)) {
      lock.unlock();
      return asked_ ? dataset_->extract(*asked_) : Impl(dataset_).extraction();
    }
    Extraction extraction =
        extract_cut(hierarchy_, {applied_, applied_count_, read_, missing_, result_.limited_by}, request_);
    extraction.complete = !lacks_blocks_;
    extraction.failures = failures_;
    extraction.bytes_read = hierarchy_.bytes_read();
    extraction.read_requests = hierarchy_.read_requests();
    extraction.seconds = seconds_since(begin);
    return extraction;
  }

  /// None where starting over has failed.
  [[nodiscard]] const SlotMesh* mesh() const { return mesh_ ? &*mesh_ : nullptr; }

private:
  /// Whether what the session knows of the hierarchy still holds, and these blocks are in it. The lock must be held.
  [[nodiscard]] bool is_sound(const BlockSet& read) const {
    const Loader& loader = hierarchy_.loader();
    return loader.revision() == revision_ && loader.holds(read);
  }

  void exchange_requests() {
    std::swap(request_, next_);
    std::swap(asked_, next_asked_);
  }

  /// Whether no block is missing that the request depends on.
  [[nodiscard]] bool is_all_there() const { return std::count(cut_->missing().begin(), cut_->missing().end(), 1) == 0; }

  // From the base mesh, like a new session.
  void start_over() {
    const auto lock = hierarchy_.lock();
    revision_ = hierarchy_.loader().revision();
    cut_.emplace(hierarchy_);
    mesh_.emplace(hierarchy_);
    errors_.emplace(hierarchy_);
    applied_.assign(hierarchy_.header().record_count, 0);
    applied_count_ = 0;
    read_.assign(hierarchy_.blocks().size(), 0);
    missing_.assign(hierarchy_.blocks().size(), 0);
    result_ = {};
    result_.limited_by = applied_.empty() ? LimitedBy::kNothing : LimitedBy::kError; // nothing is asked of it yet
    is_told_ = false;
  }

  /// What the mesh is made of stays in memory.
  void pin(const BlockSet& set) {
    Loader& loader = hierarchy_.loader();
    if (!loader.is_limited()) return;
    BlockSet next = set;
    loader.pin(next);
    loader.unpin(pinned_);
    pinned_ = std::move(next);
  }

  // Collapses have the children first, splits the parents.
  void find_changes() {
    collapses_.clear();
    splits_.clear();
    for (const std::uint32_t r : cut_->touched())
      if (cut_->contains(r) != (applied_[r] != 0)) (applied_[r] != 0 ? collapses_ : splits_).push_back(r);
    sort_by_generation(collapses_);
    std::reverse(collapses_.begin(), collapses_.end());
    sort_by_generation(splits_);
  }

  void sort_by_generation(std::vector<std::uint32_t>& records) {
    const std::vector<std::uint32_t>& generation = hierarchy_.content().generation;
    bucket_.clear();
    for (const std::uint32_t r : records) {
      if (generation[r] + std::size_t{2} > bucket_.size()) bucket_.resize(generation[r] + std::size_t{2}, 0);
      ++bucket_[generation[r] + 1];
    }
    for (std::size_t i = 1; i < bucket_.size(); ++i)
      bucket_[i] += bucket_[i - 1];
    sorted_.resize(records.size());
    for (const std::uint32_t r : records)
      sorted_[bucket_[generation[r]]++] = r;
    records.swap(sorted_);
  }

  // At least half of the time, even where finding the cut took all of it: else a view that moves was never followed.
  static std::optional<Clock::time_point> with_a_share(const std::optional<Clock::time_point>& until,
                                                       Clock::time_point begin) {
    if (!until) return until;
    return std::max(*until, Clock::now() + (*until - begin) / 2);
  }

  // Vertices that no tet uses are in the original mesh only.
  void show_unused_vertices() {
    const std::uint64_t before = mesh_->vertex_count();
    mesh_->show_unused_vertices(applied_count_ == applied_.size());
    if (mesh_->vertex_count() < before) result_.vertices_removed += before - mesh_->vertex_count();
  }

  /// False when the time was up before all was done.
  bool change(const std::optional<Clock::time_point>& until) {
    constexpr std::size_t kBetweenLooks = 64;
    std::size_t done = 0;
    const auto is_time_up = [&] { return until && ++done % kBetweenLooks == 0 && Clock::now() > *until; };
    const std::uint64_t tets = mesh_->tet_count(), vertices = mesh_->vertex_count();
    for (std::size_t i = 0; i < collapses_.size() && !is_time_up(); ++i) {
      fetch_ahead(collapses_, i);
      mesh_->collapse(RecordId{collapses_[i]});
      set_applied(collapses_[i], false);
    }
    result_.tets_removed = tets - mesh_->tet_count();
    result_.vertices_removed = vertices - mesh_->vertex_count();
    const bool is_coarse = result_.collapses == collapses_.size();
    for (std::size_t i = 0; is_coarse && i < splits_.size() && !is_time_up(); ++i) {
      fetch_ahead(splits_, i);
      mesh_->split(RecordId{splits_[i]});
      set_applied(splits_[i], true);
    }
    return is_coarse && result_.splits == splits_.size();
  }

  void fetch_ahead(const std::vector<std::uint32_t>& records, std::size_t i) const {
    constexpr std::size_t kRecord = 16, kLists = 12, kPlaces = 8, kSlots = 4; // records ahead
    const Refinement& refinement = hierarchy_.content().refinement;
    if (i + kRecord < records.size()) refinement.fetch_record(RecordId{records[i + kRecord]});
    if (i + kLists < records.size()) refinement.fetch_lists(RecordId{records[i + kLists]});
    if (i + kPlaces < records.size()) mesh_->fetch_places(RecordId{records[i + kPlaces]});
    if (i + kSlots < records.size()) mesh_->fetch_slots(RecordId{records[i + kSlots]});
  }

  void set_applied(std::uint32_t r, bool applied) {
    applied_[r] = applied ? 1 : 0;
    applied_count_ += applied ? 1U : ~0U;
    ++(applied ? result_.splits : result_.collapses);
    errors_->note(r);
  }

  void describe() {
    result_.changed_tets = mesh_->changed_tets();
    result_.changed_faces = mesh_->changed_faces();
    result_.changed_vertices = mesh_->changed_vertices();
    result_.tets = mesh_->tet_count();
    result_.boundary_faces = mesh_->face_count();
    result_.vertices = mesh_->vertex_count();
    result_.field_error = errors_->field_error();
    result_.rms_error = errors_->rms_error();
    result_.covered = errors_->covered();
    result_.domain_error = errors_->domain_error();
    failures_.clear();
    lacks_blocks_ = false;
    result_.limited_by = !result_.complete                   ? LimitedBy::kTime
                         : cut_->is_stopped_by_budget()      ? LimitedBy::kBudget
                         : applied_count_ == applied_.size() ? LimitedBy::kNothing
                                                             : request_.when_met;
    if (is_all_there()) return;
    Loader::Shortfall shortfall = hierarchy_.loader().explain(cut_->missing());
    if (result_.complete) result_.limited_by = shortfall.limited_by;
    result_.complete = false;
    failures_ = std::move(shortfall.failures);
    result_.failures = failures_;
    lacks_blocks_ = !cut_->is_out_of_time() || !failures_.empty();
  }

  std::shared_ptr<const Dataset> dataset_;
  Hierarchy& hierarchy_;
  std::optional<Request> asked_, next_asked_; ///< the last one, none before the first update; the one that comes
  ResolvedRequest request_, next_;
  bool is_broken_ = false;     ///< an update did not come to its end: the next one starts over
  std::uint64_t revision_ = 0; ///< of the hierarchy's content that the following is about
  std::optional<RunningCut> cut_;
  std::optional<SlotMesh> mesh_;
  std::optional<RunningErrors> errors_;
  std::vector<char> applied_; ///< by record: what the mesh is split by
  std::uint32_t applied_count_ = 0;
  BlockSet read_, missing_; ///< of the cut that the mesh was made for
  SessionUpdate result_;
  std::vector<BlockFailure> failures_;
  bool lacks_blocks_ = false; ///< that could not be had; there may be others that there was no time for
  BlockSet pinned_;
  bool is_told_ = false;
  std::vector<std::uint32_t> collapses_, splits_;
  std::vector<std::uint32_t> bucket_, sorted_; // scratch
};

Session::Session(std::shared_ptr<const Dataset> dataset) : impl_(std::make_unique<Impl>(std::move(dataset))) {}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

const SessionUpdate& Session::update(const Request& request, const ProgressCallback& progress) {
  return impl_->update(request, progress);
}
std::span<const std::array<std::uint32_t, 4>> Session::tets() const {
  return impl_->mesh() ? impl_->mesh()->tets() : std::span<const std::array<std::uint32_t, 4>>();
}
std::span<const std::array<std::uint32_t, 3>> Session::boundary_faces() const {
  return impl_->mesh() ? impl_->mesh()->boundary_faces() : std::span<const std::array<std::uint32_t, 3>>();
}
std::span<const VertexId> Session::vertex_in_file() const {
  return impl_->mesh() ? impl_->mesh()->vertices() : std::span<const VertexId>();
}
std::span<const RecordId> Session::made_by() const {
  return impl_->mesh() ? impl_->mesh()->made_by() : std::span<const RecordId>();
}
const PointArray& Session::positions() const {
  static const PointArray kNone;
  return impl_->mesh() ? impl_->mesh()->positions() : kNone;
}
std::span<const PointArray> Session::point_arrays() const {
  return impl_->mesh() ? impl_->mesh()->arrays() : std::span<const PointArray>();
}
Extraction Session::extraction() const {
  return impl_->extraction();
}

} // namespace ptet
