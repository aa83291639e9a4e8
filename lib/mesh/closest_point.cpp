#include "mesh/closest_point.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ptet {
using namespace vec;

namespace {

/// A triangle is thin where so many times its squared area is not above the products that cancel in it.
constexpr double kThin = 1e3;
/// Squared sine of an angle from which on the way from there to the inside of a triangle is told well.
constexpr double kWellTold = 1e-12;

ClosestOnTriangle closest_on_edges(const Point& p, const std::array<Point, 3>& x) {
  ClosestOnTriangle best{{}, std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const Vec3 edge = x[j] - x[i];
    const double edge_sq = dot(edge, edge);
    const double along = edge_sq > 0 ? std::clamp(dot(p - x[i], edge) / edge_sq, 0.0, 1.0) : 0;
    const Vec3 q = p - (x[i] + along * edge);
    const double distance_sq = dot(q, q);
    if (!(distance_sq < best.distance_sq)) continue;
    best = {{}, distance_sq};
    best.weight[i] = 1 - along;
    best.weight[j] = along;
  }
  return best;
}

/// The best of the edges and of the inside, which is seen from the corner of the greatest angle.
ClosestOnTriangle closest_on_thin_triangle(const Point& p, const std::array<Point, 3>& x) {
  std::array<double, 3> opposite_sq{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 edge = x[(i + 2) % 3] - x[(i + 1) % 3];
    opposite_sq[i] = dot(edge, edge);
  }
  const auto o =
      static_cast<std::size_t>(std::max_element(opposite_sq.begin(), opposite_sq.end()) - opposite_sq.begin());
  std::size_t i = (o + 1) % 3, j = (o + 2) % 3;
  if (opposite_sq[j] > opposite_sq[i]) std::swap(i, j);
  const double shorter_sq = opposite_sq[j], longer_sq = opposite_sq[i];
  const Vec3 shorter = x[i] - x[o], longer = x[j] - x[o];
  const double slope = shorter_sq > 0 ? dot(shorter, longer) / shorter_sq : 0;
  const Vec3 up = longer - slope * shorter;
  const double up_sq = dot(up, up);
  if (!(shorter_sq > 0) || !(up_sq > 0)) return closest_on_edges(p, x);
  double s = 0, t = 0;
  Vec3 rest = p - x[o];
  // The second pass takes away most of what the first one rounded.
  for (int pass = 0; pass < 2; ++pass) {
    const double more = dot(up, rest) / up_sq;
    t += more;
    s += dot(shorter, rest) / shorter_sq - slope * more;
    rest = p - (x[o] + s * shorter + t * longer);
  }
  const bool inside = s >= 0 && t >= 0 && s + t <= 1;
  ClosestOnTriangle within{{}, dot(rest, rest)};
  within.weight[o] = 1 - s - t;
  within.weight[i] = s;
  within.weight[j] = t;
  if (inside && up_sq > kWellTold * longer_sq) return within;
  const ClosestOnTriangle on_edge = closest_on_edges(p, x);
  return inside && within.distance_sq < on_edge.distance_sq ? within : on_edge;
}

} // namespace

ClosestOnTriangle closest_on_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = p - a;
  const auto found = [&](double v, double w) {
    const Vec3 q = ap - (v * ab + w * ac); // far from the origin no sum of positions is exact
    return ClosestOnTriangle{{1 - v - w, v, w}, dot(q, q)};
  };
  const double d1 = dot(ab, ap);
  const double d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return found(0, 0);
  const Vec3 bp = p - b;
  const double d3 = dot(ab, bp);
  const double d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return found(1, 0);
  const double ab_sq = dot(ab, ab), ac_sq = dot(ac, ac), ab_ac = dot(ab, ac);
  const auto [less, more] = std::minmax(ab_sq, ac_sq);
  if (!(kThin * (ab_sq * ac_sq - ab_ac * ab_ac) > more * std::max(less, std::abs(ab_ac))))
    return closest_on_thin_triangle(p, {a, b, c});
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
  return found(vb / sum, vc / sum);
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
