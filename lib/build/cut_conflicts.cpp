#include "build/cut_conflicts.hpp"

#include "build/self_crossings.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/clearable_set.hpp"
#include "mesh/face_plane.hpp"
#include "ptet/error.hpp"
#include "record/parents.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::build {
namespace {

using Record = std::uint32_t;

/// Records between two reports of progress.
constexpr Record kBatch = 16384;
/// So many records are climbed from before it is looked whether faces meet.
constexpr std::size_t kShortClimb = 64;

/// A boundary face that a collapse consumed.
struct FineFace {
  BoundingBox box;
  Face face;
  FacePlane plane;
  SelfCrossings::Set curves;
};

BoundingBox box_of_face(const Face& face, const std::vector<Point>& points) {
  return box_of(std::array{points[face[0].index()], points[face[1].index()], points[face[2].index()]});
}

/// The boundary faces that there were at some time, by number: the original ones, then those that collapses made, in
/// the order of the records.
class FaceVersions {
public:
  FaceVersions(std::span<const Face> original, const RecordStream& records)
      : faces_(original.begin(), original.end()), original_count_(original.size()) {
    std::vector<std::uint32_t> held(original.size()); // by slot of a ghost
    std::iota(held.begin(), held.end(), 0U);
    const auto held_in = [&](std::uint32_t slot) -> std::uint32_t& { return held[slot - records.original_tet_count]; };
    for (Record r = 0; r < records.size(); ++r) {
      first_made_.push_back(static_cast<std::uint32_t>(faces_.size()));
      for (const std::uint32_t slot : records.star(r))
        if (records.is_ghost(slot)) consumed_.push_back(held_in(slot));
      consumed_begin_.push_back(consumed_.size());
      for (const std::uint32_t slot : records.modified(r)) {
        if (!records.is_ghost(slot)) continue;
        Face face = faces_[held_in(slot)];
        std::replace(face.begin(), face.end(), records.removed[r], records.target[r]);
        held_in(slot) = static_cast<std::uint32_t>(faces_.size());
        faces_.push_back(face);
      }
      maker_.resize(faces_.size() - original_count_, r);
    }
    first_made_.push_back(static_cast<std::uint32_t>(faces_.size()));
  }
  [[nodiscard]] std::size_t original_count() const { return original_count_; }
  [[nodiscard]] bool is_original(std::uint32_t face) const { return face < original_count_; }
  /// Those that records made.
  [[nodiscard]] std::span<const Face> made() const { return std::span(faces_).subspan(original_count_); }
  [[nodiscard]] const Face& operator[](std::uint32_t face) const { return faces_[face]; }
  /// Not of an original one.
  [[nodiscard]] Record maker(std::uint32_t face) const { return maker_[face - original_count_]; }
  [[nodiscard]] std::span<const std::uint32_t> consumed(Record r) const {
    return {consumed_.data() + consumed_begin_[r], consumed_.data() + consumed_begin_[r + 1]};
  }
  /// The first that the record made, or that a later one did. `r` may be behind the last record.
  [[nodiscard]] std::uint32_t first_made(Record r) const { return first_made_[r]; }

private:
  std::vector<Face> faces_;
  std::size_t original_count_ = 0;
  std::vector<Record> maker_; ///< by face made
  std::vector<std::uint32_t> first_made_;
  std::vector<std::uint32_t> consumed_;
  std::vector<std::uint64_t> consumed_begin_{0};
};

/// Of which curves the boundary faces are where the original crosses itself: by original face and by record, of whose
/// faces all are of the same. As the builder's boundary surface found them.
class CurvesOfFaces {
public:
  CurvesOfFaces(const PreparedMesh& prepared, const FaceVersions& faces, std::size_t record_count)
      : faces_(faces), crossings_(prepared.crossing_curves) {
    if (crossings_.empty()) return;
    for (Record r = 0; r < record_count; ++r) {
      SelfCrossings::Set all = SelfCrossings::kNone;
      for (const std::uint32_t face : faces_.consumed(r))
        all = crossings_.join(all, of(face));
      of_record_.push_back(all);
    }
  }
  [[nodiscard]] SelfCrossings::Set of(std::uint32_t face) const {
    if (crossings_.empty()) return SelfCrossings::kNone;
    return faces_.is_original(face) ? crossings_.of_original(face) : of_record_[faces_.maker(face)];
  }
  /// Whether faces of these curves, and those that the record made, may cross.
  [[nodiscard]] bool share(SelfCrossings::Set curves, Record maker) const {
    return !crossings_.empty() && crossings_.share(curves, of_record_[maker]);
  }

private:
  const FaceVersions& faces_;
  SelfCrossings crossings_;
  std::vector<SelfCrossings::Set> of_record_;
};

class Conflicts {
public:
  Conflicts(const PreparedMesh& prepared, const RecordStream& records)
      : points_(prepared.points), records_(records), parents_(records), faces_(prepared.boundary_faces, records),
        curves_(prepared, faces_, records.size()), scratch_([&] { return Scratch(records.size()); }) {
    std::vector<BoundingBox> boxes;
    boxes.reserve(faces_.made().size());
    for (const Face& face : faces_.made())
      boxes.push_back(box_of_face(face, points_));
    tree_.emplace(boxes);
  }

  /// By record: later records whose faces it must not leave standing; ascending.
  std::vector<std::vector<Record>> find(const ProgressCallback& progress) {
    std::vector<std::vector<Record>> found(records_.size());
    const std::vector<Record> places = by_place();
    for (std::size_t begin = 0; begin < places.size(); begin += kBatch) {
      if (progress && !progress({"looking for cuts that cross themselves", begin, places.size()}))
        throw Error(ErrorCode::kCancelled, "the build was cancelled");
      const oneapi::tbb::blocked_range<std::size_t> batch(begin, std::min(begin + kBatch, places.size()), 64);
      oneapi::tbb::parallel_for(batch, [&](const auto& range) {
        Scratch& scratch = scratch_.local();
        for (std::size_t i = range.begin(); i != range.end(); ++i)
          look_at(places[i], scratch, found[places[i]]);
      });
    }
    return found;
  }

  /// Takes away what follows from the rest.
  void reduce(std::vector<std::vector<Record>>& found) {
    Scratch& scratch = scratch_.local();
    for (auto r = static_cast<Record>(found.size()); r-- > 0;) {
      if (found[r].empty()) continue;
      // Those needed first follow from no later one.
      std::vector<Record> wanted;
      wanted.swap(found[r]);
      scratch.reached.clear();
      climb(r, wanted.back(), scratch, [&](Record other) -> std::span<const Record> { return found[other]; });
      for (const Record other : wanted) {
        if (scratch.reached.has(other)) continue;
        found[r].push_back(other);
        scratch.reached.add(other);
        climb(other, wanted.back(), scratch, [&](Record next) -> std::span<const Record> { return found[next]; });
      }
    }
  }

private:
  /// The records that moved the boundary, those near one another together: as the vertices are numbered. In the order
  /// of the records they would be all over the tree, one after the other.
  [[nodiscard]] std::vector<Record> by_place() const {
    std::vector<Record> places;
    for (Record r = 0; r < records_.size(); ++r)
      if (records_.moves_boundary(r)) places.push_back(r);
    std::sort(places.begin(), places.end(),
              [&](Record a, Record b) { return records_.removed[a] < records_.removed[b]; });
    return places;
  }

  struct Scratch {
    explicit Scratch(std::size_t count) : reached(count), open(count) {}
    ClearableSet reached; ///< records
    ClearableSet open;    ///< makers of faces near by that were not reached yet
    std::size_t open_count = 0;
    Record last = 0;                 ///< of those that were open
    std::vector<Record> queue;       ///< the records reached
    std::size_t next = 0;            ///< the first of them whose parents were not looked at
    std::vector<std::uint32_t> near; ///< faces that records made
    std::vector<FineFace> fine;
  };

  /// Marks all that `from` needs up to record `last`.
  template <class Also>
  void climb(Record from, Record last, Scratch& s, Also&& also) const {
    s.queue.assign(1, from);
    const auto reach = [&](Record r) {
      if (r <= last && s.reached.add(r)) s.queue.push_back(r);
    };
    for (std::size_t next = 0; next < s.queue.size(); ++next) {
      const Record r = s.queue[next];
      for (const Record parent : parents_.of(r))
        reach(parent);
      for (const Record other : also(r))
        reach(other);
    }
  }

  void look_at(Record r, Scratch& s, std::vector<Record>& found) const {
    s.fine.clear();
    for (const std::uint32_t number : faces_.consumed(r)) {
      const Face& face = faces_[number];
      s.fine.push_back({box_of_face(face, points_), face, FacePlane(face, points_), curves_.of(number)});
    }
    if (s.fine.empty()) return;
    BoundingBox all;
    for (const FineFace& mine : s.fine)
      all.join(mine.box);
    s.near.clear();
    const auto original_count = static_cast<std::uint32_t>(faces_.original_count());
    tree_->each_meeting(all, faces_.first_made(r + 1) - original_count,
                        [&](std::uint32_t made) { s.near.push_back(original_count + made); });
    // Most makers are needed, and found near by; what is not needed seldom meets. So the long way up is seldom gone.
    begin_climb(r, s);
    climb_to_makers(s, kShortClimb);
    if (s.open_count == 0) return;
    std::erase_if(s.near, [&](std::uint32_t number) {
      const Face& face = faces_[number];
      const Record maker = faces_.maker(number);
      if (!s.open.has(maker)) return true;
      const BoundingBox box = box_of_face(face, points_);
      return std::none_of(s.fine.begin(), s.fine.end(), [&](const FineFace& mine) {
        return mine.box.meets(box) && !mine.plane.surely_misses(face, points_) &&
               faces_meet_improperly(mine.face, face, points_) &&
               (share_vertex(mine.face, face) || !curves_.share(mine.curves, maker));
      });
    });
    open_makers(s);
    climb_to_makers(s, std::numeric_limits<std::size_t>::max());
    if (s.open_count == 0) return;
    for (const std::uint32_t face : s.near)
      if (s.open.remove(faces_.maker(face))) found.push_back(faces_.maker(face));
    std::sort(found.begin(), found.end());
  }

  /// Opens the makers of the faces near by.
  void open_makers(Scratch& s) const {
    s.open.clear();
    s.open_count = 0;
    s.last = 0;
    for (const std::uint32_t face : s.near)
      if (const Record maker = faces_.maker(face); s.open.add(maker)) {
        ++s.open_count;
        s.last = std::max(s.last, maker);
      }
  }

  void begin_climb(Record r, Scratch& s) const {
    open_makers(s);
    s.reached.clear();
    s.queue.assign(1, r);
    s.next = 0;
  }

  /// Goes on to records that are needed through parents, to so many of them in all; those that are open it closes.
  void climb_to_makers(Scratch& s, std::size_t most) const {
    for (; s.next < std::min(most, s.queue.size()) && s.open_count != 0; ++s.next)
      for (const Record parent : parents_.of(s.queue[s.next])) {
        if (parent > s.last || !s.reached.add(parent)) continue;
        s.queue.push_back(parent);
        if (s.open.remove(parent)) --s.open_count;
      }
  }

  const std::vector<Point>& points_;
  const RecordStream& records_;
  StreamParents parents_;
  FaceVersions faces_;
  CurvesOfFaces curves_;
  std::optional<BoxTree> tree_; ///< of the faces that records made
  oneapi::tbb::enumerable_thread_specific<Scratch> scratch_;
};

} // namespace

std::size_t add_cut_dependencies(const PreparedMesh& prepared, RecordStream& records,
                                 const ProgressCallback& progress) {
  Conflicts conflicts(prepared, records);
  auto found = conflicts.find(progress);
  conflicts.reduce(found);
  records.also_needs.clear();
  records.also_needs_begin.assign(1, 0);
  for (const std::vector<Record>& others : found) {
    records.also_needs.insert(records.also_needs.end(), others.begin(), others.end());
    records.also_needs_begin.push_back(records.also_needs.size());
  }
  return records.also_needs.size();
}

} // namespace ptet::build
