#include "build/cut_conflicts.hpp"

#include "build/self_crossings.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/face_plane.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::build {
namespace {

using Record = std::uint32_t;

constexpr Record kNobody = std::numeric_limits<Record>::max();
/// Records between two reports of progress.
constexpr Record kBatch = 16384;
/// So many records are climbed from before it is looked whether faces meet.
constexpr std::size_t kShortClimb = 64;

/// A boundary face that a collapse made.
struct MadeFace {
  Face face;
  Record maker;
};

/// A boundary face that a collapse consumed.
struct FineFace {
  BoundingBox box;
  Face face;
  FacePlane plane;
  SelfCrossings::Set curves;
};

/// For each record others, in compressed rows.
struct Rows {
  std::vector<std::uint64_t> begin{0};
  std::vector<Record> others;
  [[nodiscard]] std::span<const Record> of(Record r) const {
    return {others.data() + begin[r], others.data() + begin[r + 1]};
  }
};

/// The boundary face of a ghost; false for a real tet.
bool face_of_ghost(const Tet& tet, Face& face) {
  if (std::find(tet.begin(), tet.end(), kDummyVertex) == tet.end()) return false;
  std::copy_if(tet.begin(), tet.end(), face.begin(), [](VertexId v) { return v != kDummyVertex; });
  return true;
}

BoundingBox box_of_face(const Face& face, const std::vector<Point>& points) {
  return box_of(std::array{points[face[0].index()], points[face[1].index()], points[face[2].index()]});
}

/// The records that consumed what each record made.
Rows parents_of(const RecordStream& records) {
  const std::uint32_t first_made = records.original_tet_count + records.original_ghost_count;
  std::vector<Record> consumer(records.versions.size() - first_made, kNobody);
  for (Record r = 0; r < records.size(); ++r)
    for (const VersionId t : records.consumed(r))
      if (t.index() >= first_made) consumer[t.index() - first_made] = r;
  Rows parents;
  for (Record r = 0; r < records.size(); ++r) {
    const auto row = static_cast<std::ptrdiff_t>(parents.others.size());
    const std::uint32_t first = records.coarse_begin[r].index() - first_made;
    for (std::uint32_t t = first; t < first + records.modified_count[r]; ++t)
      if (consumer[t] != kNobody) parents.others.push_back(consumer[t]);
    std::sort(parents.others.begin() + row, parents.others.end());
    parents.others.erase(std::unique(parents.others.begin() + row, parents.others.end()), parents.others.end());
    parents.begin.push_back(parents.others.size());
  }
  return parents;
}

/// Of which curves the boundary faces are where the original crosses itself: by original ghost and by record, of whose
/// faces all are of the same. As the builder's boundary surface found them.
class CurvesOfFaces {
public:
  CurvesOfFaces(const PreparedMesh& prepared, const RecordStream& records)
      : records_(records), crossings_(prepared.crossing_curves) {
    if (crossings_.empty()) return;
    const std::uint32_t first_made = records.original_tet_count + records.original_ghost_count;
    maker_.reserve(records.versions.size() - first_made);
    for (Record r = 0; r < records.size(); ++r) {
      SelfCrossings::Set all = SelfCrossings::kNone;
      for (const VersionId t : records.consumed(r))
        if (Face face{}; face_of_ghost(records.versions[t.index()], face)) all = crossings_.join(all, of_ghost(t));
      of_record_.push_back(all);
      maker_.insert(maker_.end(), records.modified_count[r], r);
    }
  }
  [[nodiscard]] SelfCrossings::Set of_ghost(VersionId t) const {
    if (crossings_.empty()) return SelfCrossings::kNone;
    const std::uint32_t ghost = t.index() - records_.original_tet_count;
    if (ghost < records_.original_ghost_count) return crossings_.of_original(ghost);
    return of_record_[maker_[ghost - records_.original_ghost_count]];
  }
  /// Whether faces of these curves, and those that the record made, may cross.
  [[nodiscard]] bool share(SelfCrossings::Set curves, Record maker) const {
    return !crossings_.empty() && crossings_.share(curves, of_record_[maker]);
  }

private:
  const RecordStream& records_;
  SelfCrossings crossings_;
  std::vector<SelfCrossings::Set> of_record_;
  std::vector<Record> maker_; ///< by version made
};

/// Marks on records, all taken away at once.
class Marks {
public:
  explicit Marks(std::size_t count) : stamp_of_(count) {}
  void clear() {
    if (++stamp_ != 0) return;
    std::fill(stamp_of_.begin(), stamp_of_.end(), 0);
    stamp_ = 1;
  }
  [[nodiscard]] bool has(Record r) const { return stamp_of_[r] == stamp_; }
  /// False if it was there before.
  bool add(Record r) {
    if (has(r)) return false;
    stamp_of_[r] = stamp_;
    return true;
  }
  bool remove(Record r) {
    if (!has(r)) return false;
    stamp_of_[r] = stamp_ - 1;
    return true;
  }

private:
  std::vector<std::uint32_t> stamp_of_;
  std::uint32_t stamp_ = 0;
};

class Conflicts {
public:
  Conflicts(const PreparedMesh& prepared, const RecordStream& records)
      : points_(prepared.points), records_(records), parents_(parents_of(records)), curves_(prepared, records),
        scratch_([&] { return Scratch(records.size()); }) {
    std::vector<BoundingBox> boxes;
    for (Record r = 0; r < records.size(); ++r) {
      first_made_.push_back(static_cast<std::uint32_t>(made_.size()));
      for (std::uint32_t m = 0; m < records.modified_count[r]; ++m)
        if (Face face{}; face_of_ghost(records.versions[records.coarse_begin[r].index() + m], face)) {
          boxes.push_back(box_of_face(face, points_));
          made_.push_back({face, r});
        }
    }
    first_made_.push_back(static_cast<std::uint32_t>(made_.size()));
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
    Marks reached;
    Marks open; ///< makers of faces near by that were not reached yet
    std::size_t open_count = 0;
    Record last = 0;                 ///< of those that were open
    std::vector<Record> queue;       ///< the records reached
    std::size_t next = 0;            ///< the first of them whose parents were not looked at
    std::vector<std::uint32_t> near; ///< places among the made faces
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
    for (const VersionId t : records_.consumed(r))
      if (Face face{}; face_of_ghost(records_.versions[t.index()], face))
        s.fine.push_back({box_of_face(face, points_), face, FacePlane(face, points_), curves_.of_ghost(t)});
    if (s.fine.empty()) return;
    BoundingBox all;
    for (const FineFace& mine : s.fine) {
      all.add(mine.box.low);
      all.add(mine.box.high);
    }
    s.near.clear();
    tree_->each_meeting(all, first_made_[r + 1], [&](std::uint32_t place) { s.near.push_back(place); });
    // Most makers are needed, and found near by; what is not needed seldom meets. So the long way up is seldom gone.
    begin_climb(r, s);
    climb_to_makers(s, kShortClimb);
    if (s.open_count == 0) return;
    std::erase_if(s.near, [&](std::uint32_t place) {
      const auto& [face, maker] = made_[place];
      if (!s.open.has(maker)) return true;
      const BoundingBox box = box_of_face(face, points_);
      return std::none_of(s.fine.begin(), s.fine.end(), [&, &face = face, &maker = maker](const FineFace& mine) {
        return mine.box.meets(box) && !mine.plane.surely_misses(face, points_) &&
               faces_meet_improperly(mine.face, face, points_) &&
               (share_vertex(mine.face, face) || !curves_.share(mine.curves, maker));
      });
    });
    open_makers(s);
    climb_to_makers(s, std::numeric_limits<std::size_t>::max());
    if (s.open_count == 0) return;
    for (const std::uint32_t place : s.near)
      if (s.open.remove(made_[place].maker)) found.push_back(made_[place].maker);
    std::sort(found.begin(), found.end());
  }

  /// Opens the makers of the faces near by.
  void open_makers(Scratch& s) const {
    s.open.clear();
    s.open_count = 0;
    s.last = 0;
    for (const std::uint32_t place : s.near)
      if (const Record maker = made_[place].maker; s.open.add(maker)) {
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
  Rows parents_;
  CurvesOfFaces curves_;
  std::vector<MadeFace> made_;            ///< in the order of the records
  std::vector<std::uint32_t> first_made_; ///< by record, and the end
  std::optional<BoxTree> tree_;           ///< of the made faces
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
