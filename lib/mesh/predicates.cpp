#include "mesh/predicates.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace ptet {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point3 = Kernel::Point_3;
using Segment3 = Kernel::Segment_3;
using Triangle3 = Kernel::Triangle_3;
using ConvexHull = std::variant<Point3, Segment3, Triangle3>;

Point3 cgal(const Point& p) {
  return {p[0], p[1], p[2]};
}

ConvexHull hull(const Point3& a, const Point3& b) {
  if (a == b) return a;
  return Segment3(a, b);
}

/// CGAL's intersection tests take non-degenerate triangles only, so a collinear one becomes its longest segment.
ConvexHull hull(const Point3& a, const Point3& b, const Point3& c) {
  if (!CGAL::collinear(a, b, c)) return Triangle3(a, b, c);
  const auto [least, greatest] = std::minmax({a, b, c}, [](const Point3& p, const Point3& q) { return p < q; });
  return hull(least, greatest);
}

bool meet(const ConvexHull& s, const ConvexHull& t) {
  return std::visit([](const auto& x, const auto& y) { return CGAL::do_intersect(x, y); }, s, t);
}

bool strictly_one_side(int first, int second) {
  return first != 0 && first == second;
}

/// Whether conv(p, a, b) and `t`, which contains p, have a point other than p in common that is seen from p at the far
/// end of conv(p, a, b).
bool far_end_meets(const Point3& p, const Point3& a, const Point3& b, const ConvexHull& t) {
  if (!CGAL::collinear(p, a, b)) return meet(Segment3(a, b), t);
  return (a != p && meet(a, t)) || (b != p && meet(b, t));
}

/// Triangles (p, a, b) and (p, c, d). If they have another point in common, so they have on the ray from p through it
/// where the first of them ends, and that is on the side opposite p of one of them.
bool meet_beside_vertex(const Point3& p, const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  return far_end_meets(p, a, b, hull(p, c, d)) || far_end_meets(p, c, d, hull(p, a, b));
}

/// Coplanar triangles (p, q, a) and (p, q, b).
bool meet_beside_edge(const Point3& p, const Point3& q, const Point3& a, const Point3& b) {
  if (p == q) return meet_beside_vertex(p, a, a, b, b);
  const bool a_on_line = CGAL::collinear(p, q, a), b_on_line = CGAL::collinear(p, q, b);
  if (!a_on_line && !b_on_line) return CGAL::coplanar_orientation(p, q, a, b) == CGAL::POSITIVE;
  if (!a_on_line || !b_on_line) return false;
  const auto both_beyond = [&](const Point3& from, const Point3& end) {
    return CGAL::collinear_are_strictly_ordered_along_line(from, end, a) &&
           CGAL::collinear_are_strictly_ordered_along_line(from, end, b);
  };
  return both_beyond(p, q) || both_beyond(q, p);
}

/// How far `x` lies from `from` along `n`, less what rounding may have added to it. `n` is taken as it stands.
double surely_along(const Vec3& n, const Point& from, const Point& x) {
  double sum = 0, size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double product = n[i] * (x[i] - from[i]);
    sum += product;
    size += std::abs(product);
  }
  return sum - 1e-14 * size - 1e-300;
}

/// Whether the triangles (p, a, b) and (p, c, d) are seen to lie on different sides of the plane through p that is
/// across the directions in which they go. False decides nothing.
bool surely_leave_vertex(const Point& p, const Point& a, const Point& b, const Point& c, const Point& d) {
  using namespace vec;
  const Vec3 s = (a - p) + (b - p), t = (c - p) + (d - p);
  const double s_length = norm(s), t_length = norm(t);
  if (!(s_length > 0 && t_length > 0)) return false;
  const Vec3 n = (1 / s_length) * s - (1 / t_length) * t, back = -1.0 * n;
  return surely_along(n, p, a) > 0 && surely_along(n, p, b) > 0 && surely_along(back, p, c) > 0 &&
         surely_along(back, p, d) > 0;
}

/// Whether the triangles (p, q, a) and (p, q, b) are seen to make an angle of more than 90 degrees. False decides
/// nothing.
bool surely_leave_edge(const Point& p, const Point& q, const Point& a, const Point& b) {
  using namespace vec;
  const Vec3 e = q - p, to_a = a - p, to_b = b - p;
  return dot(cross(to_a, e), cross(to_b, e)) < -(1e-13 * dot(e, e) * norm(to_a) * norm(to_b) + 1e-300);
}

/// Whether `n` is seen to separate the triangles, all of one on either side. False decides nothing.
bool surely_separates(const Vec3& n, const std::array<Point, 3>& s, const std::array<Point, 3>& t) {
  // Relative to a point of the first triangle: what rounding adds is measured by how far apart they are.
  double size = 0;
  const auto along = [&](const Point& x) {
    double sum = 0, terms = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double product = n[i] * (x[i] - s[0][i]);
      sum += product;
      terms += std::abs(product);
    }
    size = std::max(size, terms);
    return sum;
  };
  const auto [s_least, s_greatest] = std::minmax({0.0, along(s[1]), along(s[2])});
  const auto [t_least, t_greatest] = std::minmax({along(t[0]), along(t[1]), along(t[2])});
  return std::max(t_least - s_greatest, s_least - t_greatest) > 1e-14 * size + 1e-300;
}

/// Whether the triangles are seen to have no point in common, on the axes that separate disjoint triangles. False
/// decides nothing.
bool surely_apart(const std::array<Point, 3>& s, const std::array<Point, 3>& t) {
  using namespace vec;
  if (surely_separates((t[0] - s[0]) + (t[1] - s[1]) + (t[2] - s[2]), s, t)) return true;
  const auto edges_of = [](const std::array<Point, 3>& x) {
    return std::array<Vec3, 3>{x[1] - x[0], x[2] - x[1], x[0] - x[2]};
  };
  const std::array<Vec3, 3> s_edges = edges_of(s), t_edges = edges_of(t);
  const Vec3 s_normal = cross(s_edges[0], s_edges[1]), t_normal = cross(t_edges[0], t_edges[1]);
  if (surely_separates(s_normal, s, t) || surely_separates(t_normal, s, t)) return true;
  for (std::size_t i = 0; i < 3; ++i) // in the plane of either, where the other lies in it, too
    if (surely_separates(cross(s_edges[i], s_normal), s, t) || surely_separates(cross(t_edges[i], t_normal), s, t))
      return true;
  for (const Vec3& s_edge : s_edges)
    for (const Vec3& t_edge : t_edges)
      if (surely_separates(cross(s_edge, t_edge), s, t)) return true;
  return false;
}

} // namespace

int detail::exact_orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  return static_cast<int>(CGAL::orientation(cgal(a), cgal(b), cgal(c), cgal(d)));
}

bool triangles_cross(const std::array<Point, 3>& s, const std::array<Point, 3>& t) {
  for (const Point& p : s) // as unwelded neighbours do, in great numbers
    if (p == t[0] || p == t[1] || p == t[2]) return true;
  if (surely_apart(s, t)) return false;
  const auto separates = [](const std::array<Point, 3>& plane, const std::array<Point, 3>& other) {
    const int first = orientation(plane[0], plane[1], plane[2], other[0]);
    return strictly_one_side(first, orientation(plane[0], plane[1], plane[2], other[1])) &&
           strictly_one_side(first, orientation(plane[0], plane[1], plane[2], other[2]));
  };
  if (separates(s, t) || separates(t, s)) return false;
  return meet(hull(cgal(s[0]), cgal(s[1]), cgal(s[2])), hull(cgal(t[0]), cgal(t[1]), cgal(t[2])));
}

bool faces_meet_improperly(const Face& s, const Face& t, std::span<const Point> points) {
  // Common vertices first, each face's others after them.
  Face s_ids = s, t_ids = t;
  std::size_t common = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto match = std::find(t_ids.begin() + common, t_ids.end(), s[i]);
    if (match == t_ids.end()) continue;
    std::swap(s_ids[common], *std::find(s_ids.begin() + common, s_ids.end(), s[i]));
    std::swap(t_ids[common++], *match);
  }
  const auto at = [&](VertexId v) -> const Point& { return points[v.index()]; };
  const Point &s0 = at(s_ids[0]), &s1 = at(s_ids[1]), &s2 = at(s_ids[2]);
  const Point &t0 = at(t_ids[0]), &t1 = at(t_ids[1]), &t2 = at(t_ids[2]);
  switch (common) {
  case 0: return triangles_cross({s0, s1, s2}, {t0, t1, t2});
  case 1:
    if (surely_leave_vertex(s0, s1, s2, t1, t2)) return false;
    if (strictly_one_side(orientation(s0, s1, s2, t1), orientation(s0, s1, s2, t2))) return false;
    if (strictly_one_side(orientation(t0, t1, t2, s1), orientation(t0, t1, t2, s2))) return false;
    return meet_beside_vertex(cgal(s0), cgal(s1), cgal(s2), cgal(t1), cgal(t2));
  case 2:
    if (surely_leave_edge(s0, s1, s2, t2)) return false;
    if (orientation(s0, s1, s2, t2) != 0) return false;
    return meet_beside_edge(cgal(s0), cgal(s1), cgal(s2), cgal(t2));
  default: return true;
  }
}

} // namespace ptet
