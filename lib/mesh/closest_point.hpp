// Closest points on triangles and tetrahedra, as barycentric coordinates.
//
// Source: Ericson, Real-Time Collision Detection (2005), sections 5.1.5 and 5.1.6; thin triangles, where its products
// of coordinates cancel, another way.
#pragma once

#include "ptet/mesh.hpp"

#include <array>

namespace ptet {

struct ClosestOnTriangle {
  std::array<double, 3> weight; ///< barycentric coordinates: none negative, sum 1, but for rounding
  double distance_sq;
};
[[nodiscard]] ClosestOnTriangle closest_on_triangle(const Point& p, const Point& a, const Point& b, const Point& c);

struct ClosestOnTet {
  std::array<double, 4> weight;
  double distance_sq;
};
/// For a point outside the tet, or one of a flat tet: the closest point of its surface.
[[nodiscard]] ClosestOnTet closest_on_tet_surface(const Point& p, const std::array<Point, 4>& tet);

} // namespace ptet
