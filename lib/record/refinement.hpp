// The refinement: a mesh that is refined split by split, and what the splits do.
//
// Reader and writer both run it, the reader to learn what a record's coded split means, the writer to code it. The
// run-time library keeps its result: for each record its parents and what its split does to a mesh (see Place), from
// which the versions F(r) that it makes follow.
//
//      vertex u and its star, before            after split(r: u -> u, v)
//      C(r) = the tets of the region            F(r) = one modified tet (v instead of u) for each tet of the region,
//             around u that v takes over               then one tet (u, v, a, b) for each rim face (u, a, b)
//
// The region grows from seed tets across faces that contain u; an oracle says for each such face whether the tet
// behind it belongs to the region. Ghost tets (boundary faces joined to kDummyVertex) are tets like any other.
// What the oracle may look at is only what is the same in every closed set of loaded records: u, v, the face, the
// region's tet before the face, and not the tet behind it.
//
// A split is possible once the record's parents are applied, in any order that respects this; what it makes, and in
// which order, is the same whatever that order was. The parents are the consumers of the versions in C(r), and the
// records that a file names besides (RecordStream::also_needs).
//
// Source: after Cignoni et al. 2000, section 3 (vertex splits); De Floriani et al., dependencies of a
// multi-tessellation.
#pragma once

#include "mesh/large_pages.hpp"
#include "ptet/error.hpp"
#include "ptet/ids.hpp"
#include "ptet/mesh.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace ptet {

/// A face (u, a, b) met while the region of a split grows, seen from region tet (u, a, b, c), which is positively
/// oriented in this order: det(a-u, b-u, c-u) > 0. Any of a, b, c may be kDummyVertex.
struct GrowthFace {
  VertexId u, a, b, c;
  /// Place of the tet behind the face, to be used by the writer's oracle only (see above). A face with nothing behind
  /// (the boundary closes nowhere at a non-manifold edge) is not asked about: the region ends there.
  std::uint32_t behind;
};

/// Where a tet or ghost of the mesh stands. A split puts its modified tets in the places of those that they replace,
/// and each tet of its rim in a new one, so that a place holds one after the other and never a tet now and a ghost
/// then. To split or to collapse needs no more than the list of places, in any mesh in which the record's parents are
/// applied:
///
///   split(r)      in each of modified(r): target(r) becomes vertex_of(r)
///                 at rim_place(r) + i, i < n: (vertex_of(r), target(r), rim(r)[i], rim(r)[(i + 1) % n]) comes
///   collapse(r)   the same backwards
///
/// In place p < base_place_count() stands a tet of the base before any split, or, from base_tet_count() on, a ghost.
class Place {
public:
  constexpr Place() = default;
  constexpr Place(std::uint32_t index, bool is_ghost) : bits_(index | (is_ghost ? kGhost : 0)) {}
  [[nodiscard]] constexpr std::uint32_t index() const { return bits_ & ~kGhost; }
  [[nodiscard]] constexpr bool is_ghost() const { return (bits_ & kGhost) != 0; }

private:
  static constexpr std::uint32_t kGhost = 1U << 31;
  std::uint32_t bits_ = 0;
};

/// Which of some versions there are: bits.
using VersionKinds = std::uint8_t;
inline constexpr VersionKinds kHasTets = 1;
inline constexpr VersionKinds kHasGhosts = 2;

/// Two neighbours among the vertices around an edge, see Refinement::rim(): the edge and they are a tet of F(r), or a
/// ghost.
struct RimEdge {
  VertexId a, b;
  [[nodiscard]] bool is_of_ghost() const { return a == kDummyVertex || b == kDummyVertex; }
};
/// The i-th vertex of a rim and the one after it; after the last comes the first.
[[nodiscard]] inline RimEdge rim_edge(std::span<const VertexId> rim, std::size_t i) {
  return {rim[i], rim[i + 1 < rim.size() ? i + 1 : 0]};
}

/// A list of them, four a byte.
class VersionKindsList {
public:
  void reserve(std::size_t count) { bytes_.reserve((count + kPerByte - 1) / kPerByte); }
  void push_back(VersionKinds kinds) {
    const unsigned shift = kBits * (size_++ % kPerByte);
    if (shift == 0) bytes_.push_back(0);
    bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | kinds << shift);
  }
  [[nodiscard]] VersionKinds operator[](std::size_t i) const {
    return static_cast<VersionKinds>(bytes_[i / kPerByte] >> kBits * (i % kPerByte) & kMask);
  }

private:
  static constexpr unsigned kBits = 2, kPerByte = 4;
  static constexpr VersionKinds kMask = kHasTets | kHasGhosts;

  LargeVector<std::uint8_t> bytes_;
  std::size_t size_ = 0;
};

class Refinement {
public:
  static constexpr std::size_t kMaxRegion = 4096;              ///< tets that one split may take
  static constexpr std::uint32_t kMaxRecords = (1U << 31) - 1; ///< that there may be

  /// Starts from the base mesh. Vertices 0 .. base_vertex_count-1 are the base's; record r brings vertex
  /// base_vertex_count + r. The boundary faces of `base_tets` become base ghosts.
  /// Throws Error(kCorruptFile) for ids out of range, a repeated vertex in a tet, a face of more than two tets, two
  /// tets with the same vertices; Error(kLimit) when the counts do not fit 32-bit ids.
  Refinement(std::vector<Tet> base_tets, std::uint32_t base_vertex_count, std::uint32_t record_count);

  /// What there will be in the end, as far as it is known.
  struct Sizes {
    std::size_t places = 0, modified = 0, link_vertices = 0, parents = 0; ///< of all records together
  };
  /// Makes room, so that the lists need not grow, which takes twice the memory.
  void reserve(const Sizes& sizes);

  [[nodiscard]] std::uint32_t base_vertex_count() const { return base_vertex_count_; }
  [[nodiscard]] std::uint32_t record_count() const { return static_cast<std::uint32_t>(target_.size()); }
  [[nodiscard]] VertexId vertex_of(RecordId r) const { return VertexId{base_vertex_count_ + r.index()}; }
  /// The record that brings `v`; none for a base vertex.
  [[nodiscard]] RecordId record_of(VertexId v) const {
    return v.index() < base_vertex_count_ ? RecordId{} : RecordId{v.index() - base_vertex_count_};
  }

  /// Applies the split of record `r`: u = target becomes u and v = vertex_of(r).
  /// `seeds`: places of tets of C(r) from which the rest is reached, all at `target`.
  /// `joins(const GrowthFace&) -> bool`: see above; asked once for each face met, in an order that depends only on
  /// the record.
  /// `others`: records that must be applied before, too; they become parents like those found.
  /// Throws Error(kCorruptFile) when the record is applied already, one of `others` is not, a seed is no place or none
  /// at the target, or the region is no disk around the new vertex (then the refinement must not be used further).
  template <class Joins>
  void split(RecordId r, VertexId target, std::span<const std::uint32_t> seeds, Joins&& joins,
             std::span<const RecordId> others = {});

  [[nodiscard]] bool applied(RecordId r) const { return !target_[r.index()].is_none(); }
  [[nodiscard]] std::uint32_t applied_count() const { return applied_count_; }
  [[nodiscard]] VertexId target(RecordId r) const { return target_[r.index()]; }

  /// The tets and ghosts of the base, and all that splits have made.
  [[nodiscard]] std::uint64_t version_count() const { return version_count_; }
  /// Tets and ghosts of the base.
  [[nodiscard]] std::uint32_t base_place_count() const { return static_cast<std::uint32_t>(base_tets_.size()); }
  [[nodiscard]] std::uint32_t base_tet_count() const { return base_tet_count_; }
  /// What stands in the place before any split.
  [[nodiscard]] const Tet& base_tet(std::uint32_t place) const { return base_tets_[place]; }
  /// How many versions there are in F(r), r applied: modified ones first, in order of growth, then the ones around the
  /// edge (u, v), in order of the rim.
  [[nodiscard]] std::uint32_t fine_count(RecordId r) const { return fine_count_[r.index()]; }
  /// Their four vertices in an order that is the same in every run, vertex_of(r) at corner 0. Not when settled.
  [[nodiscard]] std::vector<Tet> fine_tets(RecordId r) const;
  /// Where the split puts the k-th of them, k < fine_count(r).
  [[nodiscard]] std::uint32_t fine_place(RecordId r, std::uint32_t k) const {
    const auto in_place = modified(r);
    return k < in_place.size() ? in_place[k].index()
                               : rim_place_[r.index()] + k - static_cast<std::uint32_t>(in_place.size());
  }
  /// Which of F(r) the split puts in `place`; fine_count(r) if none.
  [[nodiscard]] std::uint32_t fine_in_place(RecordId r, std::uint32_t place) const;
  /// Number of real (not ghost) tets in F(r) less C(r).
  [[nodiscard]] std::uint32_t added_tet_count(RecordId r) const {
    return rim_vertex_count(r.index()) - (rim_size_[r.index()] % 2 != 0 ? 2 : 0);
  }

  // What stands in a place now; not when settled.
  [[nodiscard]] const Tet& tet(std::uint32_t place) const { return live_[place].tet; }
  /// The record whose split put it there; none for one of the base.
  [[nodiscard]] RecordId consumer(std::uint32_t place) const { return record_of(live_[place].tet[0]); }
  /// The place of what is behind its face opposite `corner`; kNoPlace when nothing is there.
  [[nodiscard]] std::uint32_t neighbour(std::uint32_t place, std::uint32_t corner) const {
    return live_[place].neighbour[corner];
  }
  static constexpr std::uint32_t kNoPlace = std::numeric_limits<std::uint32_t>::max();

  /// Records that must be applied before `r`: consumers of the versions in C(r) and the others that split() was given,
  /// without repetition, ascending.
  [[nodiscard]] std::span<const RecordId> parents(RecordId r) const;
  /// What of C(r) is of its i-th parent: 0 for a parent of split()'s `others` only.
  [[nodiscard]] VersionKinds parent_kinds(RecordId r, std::size_t i) const {
    return parent_kinds_[parent_begin_[r.index()] + i];
  }
  /// What of C(r) is of the base.
  [[nodiscard]] VersionKinds base_kinds(RecordId r) const { return base_kinds_[r.index()]; }

  /// Its row of the scratch is wanted soon: it lies anywhere in memory.
  void prefetch(VertexId v) const { __builtin_prefetch(&marks_[v.index()]); }
  /// The vertices of the link triangles of the record split last, each once, in the order in which F(r) names them;
  /// kDummyVertex may be one.
  [[nodiscard]] std::span<const VertexId> last_link() const { return link_; }

  /// What split(r) does is wanted soon: first where it is told, then, some records later, what is told there.
  void fetch_record(RecordId r) const {
    const std::size_t i = r.index();
    __builtin_prefetch(&modified_begin_[i]);
    __builtin_prefetch(&fine_count_[i]);
    __builtin_prefetch(&rim_size_[i]);
    __builtin_prefetch(&rim_begin_[i]);
    __builtin_prefetch(&rim_place_[i]);
    __builtin_prefetch(&target_[i]);
  }
  void fetch_lists(RecordId r) const {
    if (const std::span<const Place> places = modified(r); !places.empty()) {
      __builtin_prefetch(&places.front());
      __builtin_prefetch(&places.back());
    }
    __builtin_prefetch(rim(r).data());
  }

  // What split(r) does, see Place; r applied.
  [[nodiscard]] std::uint32_t place_count() const {
    return is_settled_ ? settled_place_count_ : static_cast<std::uint32_t>(live_.size());
  }
  [[nodiscard]] std::span<const Place> modified(RecordId r) const {
    return {modified_.data() + modified_begin_[r.index()],
            std::size_t{fine_count_[r.index()]} - rim_vertex_count(r.index())};
  }
  /// Where modified(r) begins among those of all records, modified_count() in all; it stays there until settle().
  [[nodiscard]] std::uint32_t modified_begin(RecordId r) const { return modified_begin_[r.index()]; }
  [[nodiscard]] std::size_t modified_count() const { return modified_.size(); }
  [[nodiscard]] std::uint32_t rim_place(RecordId r) const { return rim_place_[r.index()]; }
  /// The vertices around the edge from target(r) to vertex_of(r), in order; kDummyVertex may be one.
  [[nodiscard]] std::span<const VertexId> rim(RecordId r) const {
    return {rim_vertices_.data() + rim_begin_[r.index()], rim_vertex_count(r.index())};
  }

  /// Gives up what only further splits need, all records being applied: what stands in the places, and its neighbours.
  /// What is kept is packed in the order of the records, and places are numbered anew: the base's, then those of each
  /// record's rim.
  void settle();
  [[nodiscard]] bool is_settled() const { return is_settled_; }

  /// The corners 1, 2, 3 of the k-th modified tet of F(r), k < modified(r).size(); corner 0 is vertex_of(r). The tets
  /// that split(r) modifies are (target(r), ...) with the same, F(r) has those of the rim besides.
  [[nodiscard]] std::array<VertexId, 3> link_triangle(RecordId r, std::size_t k) const {
    const std::uint32_t packed = triangles_[modified_begin_[r.index()] + k];
    constexpr std::uint32_t kMask = (1U << kLinkBits) - 1;
    const VertexId* const link = rim_vertices_.data() + rim_begin_[r.index()];
    if (packed == kWide) {
      const VertexId* const triangle = link + rim_vertex_count(r.index()) + 3 * k;
      return {triangle[0], triangle[1], triangle[2]};
    }
    return {link[packed & kMask], link[(packed >> kLinkBits) & kMask], link[packed >> (2 * kLinkBits)]};
  }

  /// Explains the first broken invariant; empty when all hold. Not when settled. O(versions).
  [[nodiscard]] std::string validate() const;

private:
  friend struct RefinementDamage; ///< of the tests: breaks invariants, to see that validate() notices

  static constexpr std::uint32_t kMaxLive = 1U << 30;

  /// What stands in a place. A modified tet takes the place of the tet it replaces, so the neighbours outside the
  /// region that share its outer face need no change.
  struct Live {
    Tet tet{};
    /// Place behind the face opposite the corner.
    std::array<std::uint32_t, 4> neighbour{kNoPlace, kNoPlace, kNoPlace, kNoPlace};
    std::uint32_t split = 0; ///< the last split whose region it was in
  };
  struct RegionTet {
    std::uint32_t place;
    std::uint32_t u_corner;
  };
  struct RimFace {
    std::uint32_t place;  ///< of the region tet
    std::uint32_t corner; ///< opposite the face, in the modified tet
    std::uint32_t rank;   ///< in the cycle around (u, v)

    // Corners a and b of the modified tet, such that (v, u, a, b) is the rim's, oriented like the others.
    [[nodiscard]] std::uint32_t a_corner() const { return (corner + 1) % 3 + 1; }
    [[nodiscard]] std::uint32_t b_corner() const { return corner % 3 + 1; }
  };
  /// Scratch by vertex, valid for the split whose number it holds. One row is one touch of memory.
  struct VertexMark {
    std::uint32_t in_link = 0;
    std::uint32_t in_rim = 0;
    std::uint32_t value = 0; ///< the rim face that starts at the vertex; what the record of a parent consumed
    std::uint32_t is_parent = 0;
  };

  void begin_split(RecordId r, VertexId target, std::span<const std::uint32_t> seeds, std::span<const RecordId> others);
  void finish_split(RecordId r, VertexId target, std::span<const RecordId> others);
  void measure_region(RecordId r);
  void store_parents(RecordId r, std::span<const RecordId> others);
  void replace_region(RecordId r);
  void order_rim(RecordId r);
  void add_rim(RecordId r, VertexId target);
  void pack_link(RecordId r);
  void join_region(std::uint32_t place);
  void close_boundary();
  [[nodiscard]] std::uint32_t rim_vertex_count(std::uint32_t r) const { return rim_size_[r] / 2U; }
  [[nodiscard]] static Tet rim_tet(const Tet& modified, std::uint32_t corner, VertexId target);
  void settle_places();
  void settle_links();
  void settle_parents();
  [[nodiscard]] std::vector<char> places_with_maker() const;
  [[noreturn]] static void fail(RecordId r, const char* what);

  [[nodiscard]] VertexMark& mark_of(VertexId v) { return marks_[v == kDummyVertex ? marks_.size() - 1 : v.index()]; }
  [[nodiscard]] static std::uint32_t corner_of(const Tet& tet, VertexId v) {
    return tet[0] == v ? 0 : tet[1] == v ? 1 : tet[2] == v ? 2 : tet[3] == v ? 3 : 4;
  }
  [[nodiscard]] static GrowthFace growth_face(const Tet& tet, std::uint32_t u_corner, std::uint32_t opposite,
                                              std::uint32_t behind);

  std::uint32_t base_vertex_count_ = 0;
  std::uint32_t base_tet_count_ = 0;
  std::uint32_t applied_count_ = 0;
  std::uint64_t version_count_ = 0;
  LargeVector<Tet> base_tets_; ///< and ghosts

  // By record.
  LargeVector<VertexId> target_;
  LargeVector<std::uint16_t> fine_count_;
  LargeVector<std::uint32_t> parent_begin_; ///< settled, one more: where they end
  LargeVector<std::uint32_t> parent_count_; ///< until settled
  LargeVector<RecordId> parents_;
  VersionKindsList parent_kinds_; ///< beside them
  LargeVector<VersionKinds> base_kinds_;
  LargeVector<std::uint32_t> modified_begin_, rim_begin_, rim_place_;
  LargeVector<std::uint16_t> rim_size_; ///< twice the vertices, and 1 where the dummy is one: two edges are of ghosts
  LargeVector<Place> modified_;
  /// The other vertices of the link follow those of the rim, or all its triangles where they are kWide.
  LargeVector<VertexId> rim_vertices_;

  // Link triangles beside modified_: numbers among the link's vertices, of kLinkBits bits each. Where the link has more
  // vertices than that can tell, kWide, and they stand one by one in rim_vertices_.
  static constexpr std::uint32_t kLinkBits = 5;
  static constexpr std::uint16_t kWide = 0xFFFF;
  bool is_settled_ = false;
  std::uint32_t settled_place_count_ = 0;
  LargeVector<std::uint16_t> triangles_;

  LargeVector<Live> live_;        ///< by place
  LargeVector<VertexMark> marks_; ///< one row a vertex, the last is the dummy's
  std::vector<RegionTet> region_;
  std::vector<RimFace> rim_;
  std::vector<VertexId> link_;
};

inline GrowthFace Refinement::growth_face(const Tet& tet, std::uint32_t u_corner, std::uint32_t opposite,
                                          std::uint32_t behind) {
  // The two other corners, in the order that makes (u, a, b, c) an even permutation of the tet.
  static constexpr std::array<std::array<std::uint8_t, 4>, 4> kA = {
      {{0, 2, 3, 1}, {3, 1, 0, 2}, {1, 3, 2, 0}, {2, 0, 1, 3}}};
  const std::uint32_t a = kA[u_corner][opposite];
  const std::uint32_t b = 6 - u_corner - opposite - a;
  return {tet[u_corner], tet[a], tet[b], tet[opposite], behind};
}

inline void Refinement::join_region(std::uint32_t place) {
  Live& live = live_[place];
  live.split = applied_count_ + 1;
  region_.push_back({place, 0});
  // What growth looks at next lies all over memory: its corner of the target is found when its turn comes.
  for (const std::uint32_t behind : live.neighbour)
    if (behind != kNoPlace) __builtin_prefetch(&live_[behind]);
}

template <class Joins>
void Refinement::split(RecordId r, VertexId target, std::span<const std::uint32_t> seeds, Joins&& joins,
                       std::span<const RecordId> others) {
  begin_split(r, target, seeds, others);
  const std::uint32_t current = applied_count_ + 1;
  for (std::size_t i = 0; i < region_.size(); ++i) {
    region_[i].u_corner = corner_of(live_[region_[i].place].tet, target);
    const RegionTet tet = region_[i];
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      const std::uint32_t behind = live_[tet.place].neighbour[corner];
      if (corner == tet.u_corner || behind == kNoPlace || live_[behind].split == current) continue;
      const GrowthFace face = growth_face(live_[tet.place].tet, tet.u_corner, corner, behind);
      if (!joins(face)) continue;
      if (region_.size() == kMaxRegion) fail(r, "its region has too many tets");
      join_region(behind);
    }
  }
  finish_split(r, target, others);
}

} // namespace ptet
