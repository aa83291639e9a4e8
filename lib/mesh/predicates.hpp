// Exact geometric predicates on double coordinates: the sign of an orientation, and whether triangles meet.
//
// `orientation` is inline up to a floating-point filter that decides all but nearly flat cases; what it leaves, and
// everything about triangles, is decided exactly by CGAL's Epick kernel behind this header. Coordinates must be finite.
//
// Source of the filter's bound: Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates, 1997, orient3d, stage A.
#pragma once

#include "ptet/mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace ptet {

/// A triangle by its vertices. Where it bounds a mesh, (b - a) x (c - a) points out of the mesh.
using Face = std::array<VertexId, 3>;

[[nodiscard]] inline bool share_vertex(const Face& s, const Face& t) {
  return std::any_of(s.begin(), s.end(), [&](VertexId v) { return std::find(t.begin(), t.end(), v) != t.end(); });
}

namespace detail {
/// The sign by exact arithmetic; what `orientation` falls back to.
[[nodiscard]] int exact_orientation(const Point& a, const Point& b, const Point& c, const Point& d);
} // namespace detail

/// The sign of det(b - a, c - a, d - a) where floating-point numbers are sure of it, else 0.
[[nodiscard]] inline int sure_orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  const double bax = b[0] - a[0], bay = b[1] - a[1], baz = b[2] - a[2];
  const double cax = c[0] - a[0], cay = c[1] - a[1], caz = c[2] - a[2];
  const double dax = d[0] - a[0], day = d[1] - a[1], daz = d[2] - a[2];
  const double cd = cax * day, dc = dax * cay;
  const double db = dax * bay, bd = bax * day;
  const double bc = bax * cay, cb = cax * bay;
  const double det = baz * (cd - dc) + caz * (db - bd) + daz * (bc - cb);
  const double b_height = std::abs(baz), c_height = std::abs(caz), d_height = std::abs(daz);
  const double permanent = b_height * (std::abs(cd) + std::abs(dc)) + c_height * (std::abs(db) + std::abs(bd)) +
                           d_height * (std::abs(bc) + std::abs(cb));
  // 8 u times the permanent, u = 2^-53, exceeds Shewchuk's bound of (7 + 56 u) u; the second term exceeds what
  // products that underflow can lose. Overflow makes the bound infinite or not a number, and the comparisons fail.
  const double bound = 0x1p-50 * permanent + 1e-300 * (b_height + c_height + d_height + 1.0);
  if (det > bound) return 1;
  return det < -bound ? -1 : 0;
}

/// The sign of det(b - a, c - a, d - a): +1 for a tet that is positively oriented, 0 exactly when the four points lie
/// in a plane. Exact.
[[nodiscard]] inline int orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (const int sign = sure_orientation(a, b, c, d); sign != 0) return sign;
  // In a plane across an axis: boundaries often are, and exact arithmetic takes its time to find that out.
  for (std::size_t i = 0; i < 3; ++i)
    if (b[i] == a[i] && c[i] == a[i] && d[i] == a[i]) return 0;
  return detail::exact_orientation(a, b, c, d);
}

/// Whether two closed triangles have a point in common. Exact; triangles may touch, be coplanar, and degenerate to
/// segments or points.
[[nodiscard]] bool triangles_cross(const std::array<Point, 3>& s, const std::array<Point, 3>& t);

/// Whether two faces have a point in common that is not a common vertex (by id) nor on their common edge. Exact.
/// Two faces on the same three vertices do. Vertices of different ids at one place count as a common point.
/// `points`: by VertexId.
[[nodiscard]] bool faces_meet_improperly(const Face& s, const Face& t, std::span<const Point> points);

} // namespace ptet
