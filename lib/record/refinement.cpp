#include "record/refinement.hpp"

#include "record/ghost.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace ptet {
namespace {

// Moving corner k to corner 0 by an even permutation is exchanging the corners in two pairs: corner j goes to j ^ k.
template <class T>
std::array<T, 4> corner_to_front(const std::array<T, 4>& values, std::uint32_t corner) {
  return {values[corner], values[corner ^ 1U], values[corner ^ 2U], values[corner ^ 3U]};
}

/// A face of a cell without its least vertex.
struct KeyedFace {
  VertexId middle, greatest;
  std::uint32_t cell, corner;

  [[nodiscard]] bool same_face(const KeyedFace& other) const {
    return middle == other.middle && greatest == other.greatest;
  }
};

/// Gathers the half faces of cells `first`..`last`-1 that `wanted(cell, corner)` selects and calls `visit` with each
/// run of equal ones, in ascending order of (vertices, cell, corner).
template <class Wanted, class Visit>
void for_each_face(std::span<const Tet> cells, std::size_t first, std::uint32_t vertex_count, Wanted&& wanted,
                   Visit&& visit) {
  const auto sorted_face = [&](std::size_t cell, std::uint32_t corner) {
    std::array<VertexId, 3> face = {cells[cell][corner ^ 1U], cells[cell][corner ^ 2U], cells[cell][corner ^ 3U]};
    std::sort(face.begin(), face.end());
    return face;
  };
  std::vector<std::size_t> begin(vertex_count + std::size_t{1}, 0);
  for (std::size_t cell = first; cell < cells.size(); ++cell)
    for (std::uint32_t corner = 0; corner < 4; ++corner)
      if (wanted(cell, corner)) ++begin[sorted_face(cell, corner)[0].index()];
  std::size_t total = 0;
  for (std::size_t& count : begin)
    total += std::exchange(count, total);
  std::vector<KeyedFace> faces(total);
  for (std::size_t cell = first; cell < cells.size(); ++cell)
    for (std::uint32_t corner = 0; corner < 4; ++corner)
      if (wanted(cell, corner)) {
        const auto face = sorted_face(cell, corner);
        faces[begin[face[0].index()]++] = {face[1], face[2], static_cast<std::uint32_t>(cell), corner};
      }
  // begin[v] is now the end of v's bucket. Inside a bucket the faces stand by cell and corner.
  auto bucket = faces.begin();
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    const auto bucket_end = faces.begin() + static_cast<std::ptrdiff_t>(begin[v]);
    std::sort(bucket, bucket_end, [](const KeyedFace& x, const KeyedFace& y) {
      return std::tie(x.middle, x.greatest, x.cell, x.corner) < std::tie(y.middle, y.greatest, y.cell, y.corner);
    });
    while (bucket != bucket_end) {
      const auto run =
          std::find_if(bucket, bucket_end, [&](const KeyedFace& face) { return !face.same_face(*bucket); });
      visit(std::span<const KeyedFace>(&*bucket, static_cast<std::size_t>(run - bucket)));
      bucket = run;
    }
  }
}

} // namespace

Refinement::Refinement(std::vector<Tet> base_tets, std::uint32_t base_vertex_count, std::uint32_t record_count)
    : base_vertex_count_(base_vertex_count) {
  if (record_count > kMaxRecords || base_vertex_count >= kDummyVertex.index() - record_count ||
      base_tets.size() >= kMaxLive / 4)
    throw Error(ErrorCode::kLimit, "the base mesh is too large: more vertices or tets than can be refined");
  for (const Tet& tet : base_tets) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (tet[i].index() >= base_vertex_count)
        throw Error(ErrorCode::kCorruptFile, "a base tet refers to vertex " + std::to_string(tet[i].index()) + " of " +
                                                 std::to_string(base_vertex_count));
      for (std::size_t j = 0; j < i; ++j)
        if (tet[i] == tet[j])
          throw Error(ErrorCode::kCorruptFile, "a base tet holds vertex " + std::to_string(tet[i].index()) + " twice");
    }
  }
  base_tet_count_ = static_cast<std::uint32_t>(base_tets.size());
  base_tets_.assign(base_tets.begin(), base_tets.end());
  base_tets = std::vector<Tet>();
  close_boundary();
  if (live_.size() >= kMaxLive)
    throw Error(ErrorCode::kLimit, "the base mesh is too large: more tets and boundary faces than can be refined");
  for (std::uint32_t place = 0; place < base_place_count(); ++place)
    live_[place].tet = base_tets_[place];
  version_count_ = base_place_count();

  marks_.resize(base_vertex_count_ + std::size_t{record_count} + 1);
  target_.resize(record_count);
  fine_count_.resize(record_count);
  parent_count_.resize(record_count);
  parent_begin_.reserve(record_count + std::size_t{1});
  parent_begin_.resize(record_count);
  base_kinds_.resize(record_count);
  modified_begin_.resize(record_count);
  rim_begin_.resize(record_count);
  rim_place_.resize(record_count);
  rim_size_.resize(record_count);
}

void Refinement::reserve(const Sizes& sizes) {
  live_.reserve(sizes.places);
  modified_.reserve(sizes.modified);
  triangles_.reserve(sizes.modified);
  rim_vertices_.reserve(sizes.link_vertices);
  parents_.reserve(sizes.parents);
  parent_kinds_.reserve(sizes.parents);
}

void Refinement::close_boundary() {
  live_.resize(base_tets_.size());
  std::vector<Tet> ghosts;
  for_each_face(
      base_tets_, 0, base_vertex_count_, [](std::size_t, std::uint32_t) { return true; },
      [&](std::span<const KeyedFace> same) {
        if (same.size() > 2)
          throw Error(ErrorCode::kCorruptFile,
                      "base tet " + std::to_string(same[2].cell) + " shares a face with two others");
        const auto [cell, corner] = std::pair(same[0].cell, same[0].corner);
        if (same.size() == 2) {
          live_[cell].neighbour[corner] = same[1].cell;
          live_[same[1].cell].neighbour[same[1].corner] = cell;
          return;
        }
        const Tet& tet = base_tets_[cell];
        ghosts.push_back({tet[corner ^ 1U], tet[corner ^ 2U], tet[corner ^ 3U], kDummyVertex});
        live_[cell].neighbour[corner] = static_cast<std::uint32_t>(live_.size());
        live_.emplace_back().neighbour[3] = cell;
      });
  for (std::uint32_t t = 0; t < base_tet_count_; ++t) {
    auto neighbour = live_[t].neighbour;
    std::sort(neighbour.begin(), neighbour.end());
    if (std::adjacent_find(neighbour.begin(), neighbour.end()) != neighbour.end())
      throw Error(ErrorCode::kCorruptFile, "base tet " + std::to_string(t) + " is there twice");
  }
  base_tets_.reserve(base_tets_.size() + ghosts.size());
  base_tets_.insert(base_tets_.end(), ghosts.begin(), ghosts.end());
  for_each_face(
      base_tets_, base_tet_count_, base_vertex_count_, [](std::size_t, std::uint32_t corner) { return corner < 3; },
      [&](std::span<const KeyedFace> same) {
        // More than two boundary faces at an edge: which of them are neighbours cannot be told from the tets alone.
        if (same.size() != 2) return;
        live_[same[0].cell].neighbour[same[0].corner] = same[1].cell;
        live_[same[1].cell].neighbour[same[1].corner] = same[0].cell;
      });
}

void Refinement::fail(RecordId r, const char* what) {
  throw Error(ErrorCode::kCorruptFile, "record " + std::to_string(r.index()) + " cannot be applied: " + what);
}

void Refinement::begin_split(RecordId r, VertexId target, std::span<const std::uint32_t> seeds,
                             std::span<const RecordId> others) {
  if (r.index() >= record_count() || applied(r)) fail(r, "it is applied already, or there is no such record");
  if (target.index() >= base_vertex_count_ + record_count()) fail(r, "its target is no vertex");
  for (const RecordId other : others)
    if (other.index() >= record_count() || !applied(other)) fail(r, "a record that it depends on is not applied");
  if (seeds.empty() || seeds.size() > kMaxRegion) fail(r, "it names no place in the mesh");
  region_.clear();
  for (const std::uint32_t seed : seeds) {
    if (seed >= live_.size()) fail(r, "it starts from a tet that is not in the mesh");
    if (corner_of(live_[seed].tet, target) == 4) fail(r, "it starts from a tet that is not at its target");
    if (live_[seed].split == applied_count_ + 1) fail(r, "it names the same tet twice");
    join_region(seed);
  }
}

void Refinement::finish_split(RecordId r, VertexId target, std::span<const RecordId> others) {
  measure_region(r);
  store_parents(r, others);
  const std::size_t fine = region_.size() + rim_.size();
  version_count_ += fine;
  if (version_count_ >= kNoPlace || live_.size() + rim_.size() >= kMaxLive)
    throw Error(ErrorCode::kLimit, "the mesh is too large: more tets than can be refined");
  fine_count_[r.index()] = static_cast<std::uint16_t>(fine);
  live_.resize(live_.size() + rim_.size());
  replace_region(r);
  order_rim(r);
  add_rim(r, target);
  pack_link(r);
  target_[r.index()] = target;
  ++applied_count_;
}

// Finds the rim and checks that the region's triangles in the link of u have the Euler characteristic of a disk; that
// the rim is one cycle shows when its tets are joined.
void Refinement::measure_region(RecordId r) {
  const std::uint32_t current = applied_count_ + 1;
  // Whether a face is of the rim or a vertex is new is as good as chance, so both are written down and then counted.
  rim_.resize(3 * region_.size());
  link_.resize(3 * region_.size());
  std::size_t rim_faces = 0, link_vertices = 0;
  for (const RegionTet& tet : region_) {
    const Live& live = live_[tet.place];
    const Tet& corners = live.tet;
    for (std::uint32_t modified_corner = 1; modified_corner < 4; ++modified_corner) {
      const VertexId v = corners[tet.u_corner ^ modified_corner];
      link_[link_vertices] = v;
      link_vertices += std::exchange(mark_of(v).in_link, current) != current ? 1 : 0;
    }
    for (std::uint32_t other = 0; other < 3; ++other) {
      const std::uint32_t corner = other + (other < tet.u_corner ? 0 : 1);
      const std::uint32_t behind = live.neighbour[corner];
      const std::size_t is_rim = behind == kNoPlace || live_[behind].split != current ? 1 : 0;
      rim_[rim_faces] = {tet.place, corner ^ tet.u_corner, 0};
      rim_faces += is_rim;
    }
  }
  rim_.resize(rim_faces);
  link_.resize(link_vertices);
  // V - E + F = 1, with 2 E = 3 F + rim.
  if (rim_.size() < 3 || 2 * link_.size() != region_.size() + rim_.size() + 2)
    fail(r, "the region of its vertex is no disk");
}

void Refinement::store_parents(RecordId r, std::span<const RecordId> others) {
  const std::uint32_t current = applied_count_ + 1;
  const std::size_t begin = parents_.size();
  if (begin + region_.size() + others.size() >= kNoPlace)
    throw Error(ErrorCode::kLimit, "the mesh is too large: more dependencies than 32-bit ids can name");
  const auto add = [&](RecordId parent, VersionKinds kind) {
    VertexMark& mark = mark_of(vertex_of(parent));
    if (std::exchange(mark.is_parent, current) != current) {
      parents_.push_back(parent);
      mark.value = 0;
    }
    mark.value |= kind;
  };
  VersionKinds base = 0;
  for (const RegionTet& tet : region_) {
    const VersionKinds kind = is_ghost(live_[tet.place].tet) ? kHasGhosts : kHasTets;
    if (const RecordId parent = consumer(tet.place); !parent.is_none())
      add(parent, kind);
    else
      base |= kind;
  }
  for (const RecordId other : others)
    add(other, 0);
  std::sort(parents_.begin() + static_cast<std::ptrdiff_t>(begin), parents_.end());
  for (std::size_t i = begin; i < parents_.size(); ++i)
    parent_kinds_.push_back(static_cast<VersionKinds>(mark_of(vertex_of(parents_[i])).value));
  base_kinds_[r.index()] = base;
  parent_begin_[r.index()] = static_cast<std::uint32_t>(begin);
  parent_count_[r.index()] = static_cast<std::uint32_t>(parents_.size() - begin);
}

void Refinement::replace_region(RecordId r) {
  modified_begin_[r.index()] = static_cast<std::uint32_t>(modified_.size());
  for (const RegionTet& tet : region_) {
    Live& live = live_[tet.place];
    live.tet = corner_to_front(live.tet, tet.u_corner);
    live.tet[0] = vertex_of(r);
    live.neighbour = corner_to_front(live.neighbour, tet.u_corner);
    modified_.emplace_back(tet.place, is_ghost(live.tet));
  }
}

// The faces' edges (a, b) all run the same way around the disk: b of one is a of the next.
void Refinement::order_rim(RecordId r) {
  const std::uint32_t current = applied_count_ + 1;
  for (std::uint32_t i = 0; i < rim_.size(); ++i) {
    VertexMark& mark = mark_of(live_[rim_[i].place].tet[rim_[i].a_corner()]);
    if (std::exchange(mark.in_rim, current) == current) fail(r, "the rim of its region meets itself");
    mark.value = i;
  }
  if (rim_vertices_.size() > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::kLimit, "the mesh is too large: more vertices around edges than 32-bit ids can name");
  rim_begin_[r.index()] = static_cast<std::uint32_t>(rim_vertices_.size());
  const unsigned has_dummy = mark_of(kDummyVertex).in_rim == current ? 1 : 0;
  rim_size_[r.index()] = static_cast<std::uint16_t>(2 * rim_.size() + has_dummy);
  std::uint32_t at = 0, rank = 0;
  do {
    RimFace& face = rim_[at];
    const Tet& modified = live_[face.place].tet;
    face.rank = rank++;
    rim_vertices_.push_back(modified[face.a_corner()]);
    const VertexMark& next = mark_of(modified[face.b_corner()]);
    if (next.in_rim != current) fail(r, "the rim of its region is not closed");
    at = next.value;
  } while (at != 0 && rank < rim_.size());
  if (at != 0 || rank != rim_.size()) fail(r, "the rim of its region falls apart");
}

// As link_triangle() is to find it.
void Refinement::pack_link(RecordId r) {
  if (link_.size() > (1U << kLinkBits)) {
    for (const RegionTet& tet : region_)
      rim_vertices_.insert(rim_vertices_.end(), live_[tet.place].tet.begin() + 1, live_[tet.place].tet.end());
    triangles_.resize(triangles_.size() + region_.size(), kWide);
    return;
  }
  const std::uint32_t current = applied_count_ + 1;
  std::uint32_t next = 0;
  for (std::size_t i = rim_begin_[r.index()]; i < rim_vertices_.size(); ++i)
    mark_of(rim_vertices_[i]).value = next++;
  for (const VertexId v : link_) {
    VertexMark& mark = mark_of(v);
    if (mark.in_rim == current) continue;
    mark.value = next++;
    rim_vertices_.push_back(v);
  }
  for (const RegionTet& tet : region_) {
    const auto number = [&](std::size_t corner) { return mark_of(live_[tet.place].tet[corner]).value; };
    triangles_.push_back(static_cast<std::uint16_t>(number(1) | number(2) << kLinkBits | number(3) << (2 * kLinkBits)));
  }
}

// One tet (v, u, a, b) for each rim face. Around the edge (u, v) they stand as in the rim.
void Refinement::add_rim(RecordId r, VertexId target) {
  const auto count = static_cast<std::uint32_t>(rim_.size());
  const auto first = static_cast<std::uint32_t>(live_.size()) - count;
  rim_place_[r.index()] = first;
  for (const RimFace& face : rim_) {
    const std::uint32_t place = first + face.rank;
    Live& modified = live_[face.place];
    Live& live = live_[place];
    live.tet = rim_tet(modified.tet, face.corner, target);
    live.neighbour[0] = modified.neighbour[face.corner];
    live.neighbour[face.corner] = face.place;
    modified.neighbour[face.corner] = place;
    if (live.neighbour[0] != kNoPlace) {
      auto& beyond = live_[live.neighbour[0]].neighbour;
      *std::find(beyond.begin(), beyond.begin() + 3, face.place) = place;
    }
    live.neighbour[face.b_corner() ^ face.corner] = first + (face.rank == 0 ? count : face.rank) - 1;
    live.neighbour[face.a_corner() ^ face.corner] = first + (face.rank + 1 == count ? 0 : face.rank + 1);
  }
}

namespace {

template <class List>
void drop(List& values) {
  List().swap(values);
}

} // namespace

void Refinement::settle() {
  if (is_settled_ || applied_count_ != record_count()) return;
  settle_links();
  settle_places();
  settle_parents();
  drop(marks_);
  drop(region_);
  drop(rim_);
  drop(link_);
  is_settled_ = true;
}

void Refinement::settle_links() {
  LargeVector<VertexId> vertices;
  LargeVector<std::uint16_t> triangles;
  vertices.reserve(rim_vertices_.size());
  triangles.reserve(triangles_.size());
  for (std::uint32_t r = 0; r < record_count(); ++r) {
    const auto first = triangles_.begin() + modified_begin_[r];
    triangles.insert(triangles.end(), first, first + static_cast<std::ptrdiff_t>(modified(RecordId{r}).size()));
    // Of a disk, see measure_region().
    const std::size_t link_vertices = (fine_count_[r] + std::size_t{2}) / 2;
    const bool is_wide = link_vertices > (1U << kLinkBits);
    const auto link = rim_vertices_.begin() + std::exchange(rim_begin_[r], static_cast<std::uint32_t>(vertices.size()));
    vertices.insert(vertices.end(), link,
                    link + static_cast<std::ptrdiff_t>(is_wide ? rim_vertex_count(r) + 3 * modified(RecordId{r}).size()
                                                               : link_vertices));
  }
  rim_vertices_ = std::move(vertices);
  triangles_ = std::move(triangles);
}

// Near records, which have near numbers, then have near places: a mesh that is refined in the order of the records
// finds them in the cache.
void Refinement::settle_places() {
  settled_place_count_ = place_count();
  drop(live_);
  LargeVector<std::uint32_t> renumbered(settled_place_count_);
  std::uint32_t next = 0;
  while (next < base_place_count()) {
    renumbered[next] = next;
    ++next;
  }
  for (std::uint32_t r = 0; r < record_count(); ++r) {
    const std::uint32_t old = std::exchange(rim_place_[r], next);
    for (std::uint32_t i = 0; i < rim_vertex_count(r); ++i)
      renumbered[old + i] = next++;
  }
  LargeVector<Place> packed;
  packed.reserve(modified_.size());
  for (std::uint32_t r = 0; r < record_count(); ++r) {
    const auto places = modified(RecordId{r});
    modified_begin_[r] = static_cast<std::uint32_t>(packed.size());
    for (const Place place : places)
      packed.emplace_back(renumbered[place.index()], place.is_ghost());
  }
  modified_ = std::move(packed);
}

void Refinement::settle_parents() {
  LargeVector<RecordId> packed;
  VersionKindsList kinds;
  packed.reserve(parents_.size());
  kinds.reserve(parents_.size());
  for (std::uint32_t r = 0; r < record_count(); ++r) {
    const auto mine = parents(RecordId{r});
    for (std::size_t i = 0; i < mine.size(); ++i)
      kinds.push_back(parent_kinds(RecordId{r}, i));
    parent_begin_[r] = static_cast<std::uint32_t>(packed.size());
    packed.insert(packed.end(), mine.begin(), mine.end());
  }
  parent_begin_.push_back(static_cast<std::uint32_t>(packed.size()));
  drop(parent_count_);
  parents_ = std::move(packed);
  parent_kinds_ = std::move(kinds);
}

/// The tet around the edge to `target` behind the face of a modified tet that is opposite `corner`.
Tet Refinement::rim_tet(const Tet& modified, std::uint32_t corner, VertexId target) {
  Tet tet = corner_to_front(modified, corner);
  tet[0] = modified[0];
  tet[corner] = target;
  return tet;
}

std::uint32_t Refinement::fine_in_place(RecordId r, std::uint32_t place) const {
  const auto in_place = modified(r);
  const auto count = static_cast<std::uint32_t>(in_place.size());
  if (const std::uint32_t of_rim = place - rim_place_[r.index()]; of_rim < rim_vertex_count(r.index()))
    return count + of_rim;
  const auto found = std::find_if(in_place.begin(), in_place.end(), [&](Place at) { return at.index() == place; });
  return found != in_place.end() ? static_cast<std::uint32_t>(found - in_place.begin()) : fine_count(r);
}

std::vector<Tet> Refinement::fine_tets(RecordId r) const {
  const std::size_t modified_count = modified(r).size();
  const auto around = rim(r);
  std::vector<Tet> tets(fine_count(r));
  std::vector<std::pair<VertexId, std::size_t>> place_in_rim;
  for (std::size_t i = 0; i < around.size(); ++i)
    place_in_rim.emplace_back(around[i], i);
  std::sort(place_in_rim.begin(), place_in_rim.end());
  for (std::size_t k = 0; k < modified_count; ++k) {
    const auto [x, y, z] = link_triangle(r, k);
    tets[k] = {vertex_of(r), x, y, z};
    for (std::uint32_t corner = 1; corner < 4; ++corner) {
      const RimFace face{0, corner, 0};
      const VertexId a = tets[k][face.a_corner()], b = tets[k][face.b_corner()];
      const auto found = std::lower_bound(place_in_rim.begin(), place_in_rim.end(), std::pair(a, std::size_t{0}));
      if (found == place_in_rim.end() || found->first != a) continue;
      const std::size_t i = found->second;
      if (rim_edge(around, i).b == b) tets[modified_count + i] = rim_tet(tets[k], corner, target(r));
    }
  }
  return tets;
}

std::span<const RecordId> Refinement::parents(RecordId r) const {
  const std::size_t begin = parent_begin_[r.index()];
  return {parents_.data() + begin,
          is_settled_ ? parent_begin_[r.index() + std::size_t{1}] - begin : parent_count_[r.index()]};
}

/// By place, 1: what stands there is what the record of its first vertex put there.
std::vector<char> Refinement::places_with_maker() const {
  std::vector<char> has_maker(live_.size(), 0);
  for (std::uint32_t i = 0; i < record_count(); ++i) {
    const RecordId r{i};
    if (!applied(r)) continue;
    const std::vector<Tet> tets = fine_tets(r);
    const auto in_place = modified(r);
    for (std::size_t k = 0; k < tets.size(); ++k) {
      const std::size_t place = k < in_place.size() ? in_place[k].index() : rim_place_[i] + (k - in_place.size());
      if (place < live_.size() && consumer(static_cast<std::uint32_t>(place)) == r && live_[place].tet == tets[k])
        has_maker[place] = 1;
    }
  }
  return has_maker;
}

std::string Refinement::validate() const {
  const auto name = [](std::uint32_t place) { return "the tet in place " + std::to_string(place); };
  std::uint64_t versions = base_place_count(), places = base_place_count();
  for (std::uint32_t r = 0; r < record_count(); ++r) {
    if (!applied(RecordId{r})) continue;
    versions += fine_count_[r];
    places += rim_vertex_count(r);
  }
  if (versions != version_count_) return "the splits have made other than " + std::to_string(version_count_) + " tets";
  if (places != live_.size())
    return "the splits have made " + std::to_string(places) + " places, and there are " + std::to_string(live_.size());
  const std::vector<char> has_maker = places_with_maker();
  for (std::uint32_t place = 0; place < live_.size(); ++place) {
    const Live& live = live_[place];
    if (consumer(place).is_none()) {
      if (place >= base_place_count() || live.tet != base_tets_[place]) return name(place) + " is of no record";
    } else if (has_maker[place] == 0) {
      return name(place) + " is not among those of the record of its first vertex";
    }
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      const std::uint32_t behind = live.neighbour[corner];
      if (behind == kNoPlace) continue;
      if (behind >= live_.size()) return name(place) + " has a neighbour that is not there";
      for (std::uint32_t shared = 0; shared < 4; ++shared)
        if ((corner_of(live_[behind].tet, live.tet[shared]) == 4) != (shared == corner))
          return name(place) + " and its neighbour, " + name(behind) + ", do not share their face";
      const auto& back = live_[behind].neighbour;
      if (std::count(back.begin(), back.end(), place) != 1)
        return name(place) + " is not a neighbour of its neighbour, " + name(behind);
    }
  }
  for (std::uint32_t r = 0; r < record_count(); ++r)
    for (const RecordId parent : parents(RecordId{r}))
      if (!applied(parent))
        return "record " + std::to_string(r) + " is applied, its parent " + std::to_string(parent.index()) + " is not";
  return {};
}

} // namespace ptet
