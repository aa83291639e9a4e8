// The working complex: the mesh while it is being collapsed, made for speed and nothing else.
//
//   slots   one row for each tet and each ghost (boundary face joined to the dummy vertex). A modified tet keeps its
//           slot, a deleted one leaves its slot dead for good; nothing else ever moves.
//   stars   for each vertex the slots around it, ghosts included, in one pool:
//
//             stars_[v] = { begin, size, capacity }  ->  pool_[begin .. begin+size)
//
//           kept exact by every collapse, so that no list ever holds a dead slot. Where a star stood that is gone, or
//           has become too large for its place, another may stand.
//
// Vertices are plain row numbers here; the dummy vertex is the row behind the last one, so that mark arrays may be
// indexed with it.
#pragma once

#include "mesh/large_pages.hpp"
#include "ptet/mesh.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace ptet::build {

using Vertex = std::uint32_t;
using SlotId = std::uint32_t;
inline constexpr std::uint32_t kNone = 0xffffffffU;

struct Slot {
  std::array<Vertex, 4> v;
  std::uint32_t version; ///< of the tets and ghosts that there ever were, in the order in which they were made
  float quality;         ///< 6 sqrt(2) V / Lmax^3; 0 for ghosts
  std::uint32_t height;  ///< longest chain of records below the version; 0 for an original one
  std::uint32_t first_point = kNone; ///< head of the list of removed vertices that the tet holds
};

class WorkingComplex {
public:
  /// Tets first, then a ghost for each outward oriented boundary face.
  WorkingComplex(std::uint32_t vertex_count, std::span<const Tet> tets,
                 std::span<const std::array<VertexId, 3>> boundary_faces);

  [[nodiscard]] std::uint32_t vertex_count() const { return dummy_; }
  [[nodiscard]] Vertex dummy() const { return dummy_; }
  [[nodiscard]] std::uint32_t slot_count() const { return static_cast<std::uint32_t>(slots_.size()); }
  [[nodiscard]] Slot& slot(SlotId s) { return slots_[s]; }
  [[nodiscard]] const Slot& slot(SlotId s) const { return slots_[s]; }
  [[nodiscard]] bool is_ghost(const Slot& s) const {
    return s.v[0] == dummy_ || s.v[1] == dummy_ || s.v[2] == dummy_ || s.v[3] == dummy_;
  }
  /// As records name it.
  [[nodiscard]] Tet tet_of(const Slot& s) const {
    Tet tet;
    for (std::size_t i = 0; i < 4; ++i)
      tet[i] = s.v[i] == dummy_ ? kDummyVertex : VertexId{s.v[i]};
    return tet;
  }
  [[nodiscard]] std::span<const SlotId> star(Vertex v) const {
    const Star& star = stars_[v];
    return {pool_.data() + star.begin, star.size};
  }
  /// Loops over vertices call their stars into the cache so many vertices ahead.
  static constexpr std::size_t kPrefetch = 3;
  /// The slots around `v` are wanted soon, each from another place in memory.
  void prefetch_star(Vertex v) const {
    for (const SlotId s : star(v))
      __builtin_prefetch(&slots_[s]);
  }
  [[nodiscard]] bool alive(Vertex v) const { return stars_[v].size != 0; }

  /// Half-edge collapse vs -> vd: `deleted` are the slots that hold both, `modified` the rest of star(vs).
  /// The caller has checked that this is allowed.
  void collapse(Vertex vs, Vertex vd, std::span<const SlotId> deleted, std::span<const SlotId> modified);

  /// Gives the memory of the stars back: what slots hold is all that may be asked from now on.
  void forget_stars();

  /// Explains the first broken invariant; empty when all hold. O(slots).
  [[nodiscard]] std::string validate() const;

private:
  struct Star {
    std::uint32_t begin = 0;
    std::uint32_t size = 0;
    std::uint32_t capacity = 0;
  };

  void remove_from_star(Vertex v, SlotId s);
  [[nodiscard]] Star take_chunk(std::uint32_t size);
  void free_chunk(const Star& star);

  Vertex dummy_;
  LargeVector<Slot> slots_;
  LargeVector<Star> stars_;
  LargeVector<SlotId> pool_;
  /// By capacity, where chunks begin that hold no star; larger ones are not used again.
  std::array<std::vector<std::uint32_t>, 256> free_;
};

} // namespace ptet::build
