#include "error/closest_point.hpp"

#include "mesh/vec3.hpp"

#include <limits>

namespace ptet {
using namespace vec;

ClosestOnTriangle closest_on_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const auto found = [&](double v, double w) {
    const Vec3 q = p - (a + v * ab + w * ac);
    return ClosestOnTriangle{{1 - v - w, v, w}, dot(q, q)};
  };
  const Vec3 ap = p - a;
  const double d1 = dot(ab, ap);
  const double d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return found(0, 0);
  const Vec3 bp = p - b;
  const double d3 = dot(ab, bp);
  const double d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return found(1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return found(d1 / (d1 - d3), 0);
  const Vec3 cp = p - c;
  const double d5 = dot(ab, cp);
  const double d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return found(0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return found(0, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && (d4 - d3) + (d5 - d6) > 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return found(1 - w, w);
  }
  const double sum = va + vb + vc;
  // Only a degenerate triangle comes here without an area.
  return sum > 0 ? found(vb / sum, vc / sum) : found(0, 0);
}

ClosestOnTet closest_on_tet_surface(const Point& p, const std::array<Point, 4>& tet) {
  static constexpr std::array<std::array<std::size_t, 3>, 4> kFaces{{{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}}};
  ClosestOnTet best{{}, std::numeric_limits<double>::infinity()};
  for (const auto& face : kFaces) {
    const ClosestOnTriangle on = closest_on_triangle(p, tet[face[0]], tet[face[1]], tet[face[2]]);
    if (!(on.distance_sq < best.distance_sq)) continue;
    best = {{}, on.distance_sq};
    for (std::size_t i = 0; i < 3; ++i)
      best.weight[face[i]] = on.weight[i];
  }
  return best;
}

} // namespace ptet
