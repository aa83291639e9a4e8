// The star of a record: the versions that its collapse made, C(r), and those that its split makes, F(r). Ghost tets,
// which stand for boundary faces, are among them; they have kDummyVertex for a corner.
//
//   C(r): (u, link triangle)     F(r): (v, link triangle) and, around the edge, (v, u, two neighbours of the rim)
#pragma once

#include "lod/hierarchy.hpp"

#include <array>
#include <span>

namespace ptet {

/// Whether `f(const Tet&)` holds for any version in C(r). The lock must be held and the record be loaded.
template <class F>
[[nodiscard]] bool any_coarse(const Refinement& refinement, RecordId r, F&& f) {
  const VertexId u = refinement.target(r);
  for (std::size_t k = 0; k < refinement.modified(r).size(); ++k) {
    const auto [a, b, c] = refinement.link_triangle(r, k);
    if (f(Tet{u, a, b, c})) return true;
  }
  return false;
}

/// The same for F(r).
template <class F>
[[nodiscard]] bool any_fine(const Refinement& refinement, RecordId r, F&& f) {
  const VertexId u = refinement.target(r), v = refinement.vertex_of(r);
  for (std::size_t k = 0; k < refinement.modified(r).size(); ++k) {
    const auto [a, b, c] = refinement.link_triangle(r, k);
    if (f(Tet{v, a, b, c})) return true;
  }
  const auto rim = refinement.rim(r);
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const auto [a, b] = rim_edge(rim, i);
    if (f(Tet{v, u, a, b})) return true;
  }
  return false;
}

/// The same for both.
template <class F>
[[nodiscard]] bool any_in_star(const Refinement& refinement, RecordId r, F&& f) {
  return any_coarse(refinement, r, f) || any_fine(refinement, r, f);
}

/// The points at the corners of a tet, or of the face that a ghost stands for.
class Corners {
public:
  Corners(const Hierarchy& hierarchy, const Tet& tet) {
    for (const VertexId v : tet)
      if (v != kDummyVertex) points_[count_++] = hierarchy.position(v);
  }
  [[nodiscard]] std::span<const Point> points() const { return {points_.data(), count_}; }

private:
  std::array<Point, 4> points_{};
  std::size_t count_ = 0;
};

} // namespace ptet
