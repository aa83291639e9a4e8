// What a half-edge collapse leaves around the vertex it removes, seen before it is done and without changing anything.
//
//   M(e)  the tets at vs without vd, with vd put in the place of vs; where vs would lie among them
//   the same of the boundary faces (the ghosts)
//
// Thread rule: everything here only reads.
#pragma once

#include "build/normalized_fields.hpp"
#include "build/working_complex.hpp"
#include "error/tolerances.hpp"
#include "mesh/closest_point.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace ptet::build {

/// A cost grows by this much for an edge as long as the diagonal, so that where nothing is lost short edges go first.
inline constexpr double kEdgeLengthWeight = 1e-4;
/// Barycentric coordinates above this count as inside: rounding at shared faces.
inline constexpr double kInsideTet = -1e-10;

[[nodiscard]] inline bool has_corner(const std::array<Vertex, 4>& corners, Vertex v) {
  return corners[0] == v || corners[1] == v || corners[2] == v || corners[3] == v;
}

/// Calls `visit(slot, corners)` for every tet that vs -> vd modifies, with its corners afterwards: vd where vs was.
template <class Visit>
void for_each_modified_tet(const WorkingComplex& complex, Vertex vs, Vertex vd, Visit&& visit) {
  for (const SlotId s : complex.star(vs)) {
    std::array<Vertex, 4> corners = complex.slot(s).v;
    if (has_corner(corners, vd) || has_corner(corners, complex.dummy())) continue;
    std::replace(corners.begin(), corners.end(), vs, vd);
    visit(s, corners);
  }
}

/// Calls `visit(slot, corners)` for every boundary face (its ghost) that vs -> vd modifies; vd is the first corner.
template <class Visit>
void for_each_modified_face(const WorkingComplex& complex, Vertex vs, Vertex vd, Visit&& visit) {
  for (const SlotId s : complex.star(vs)) {
    const Slot& slot = complex.slot(s);
    if (!complex.is_ghost(slot) || has_corner(slot.v, vd)) continue;
    std::array<Vertex, 3> corners{vd};
    std::size_t i = 1;
    for (const Vertex x : slot.v)
      if (x != vs && x != complex.dummy()) corners[i++] = x;
    visit(s, corners);
  }
}

[[nodiscard]] inline std::array<Point, 4> corner_points(const std::array<Vertex, 4>& corners,
                                                        const std::vector<Point>& positions) {
  return {positions[corners[0]], positions[corners[1]], positions[corners[2]], positions[corners[3]]};
}

/// What vs -> vd adds to the volume of the mesh; 0 where that may be rounding, as it is for vs inside.
[[nodiscard]] inline double volume_added(const WorkingComplex& complex, const std::vector<Point>& positions, Vertex vs,
                                         Vertex vd) {
  double before = 0, after = 0;
  for (const SlotId s : complex.star(vs))
    if (!complex.is_ghost(complex.slot(s))) before += tet_volume(corner_points(complex.slot(s).v, positions));
  for_each_modified_tet(complex, vs, vd, [&](SlotId, const std::array<Vertex, 4>& corners) {
    after += tet_volume(corner_points(corners, positions));
  });
  return volume_change(before, after);
}

[[nodiscard]] inline bool is_on_boundary(const WorkingComplex& complex, Vertex v) {
  const auto star = complex.star(v);
  return std::any_of(star.begin(), star.end(), [&](SlotId s) { return complex.is_ghost(complex.slot(s)); });
}

/// The gradients of the barycentric coordinates 1, 2 and 3; false when the tet is flat.
[[nodiscard]] inline bool barycentric_gradients(const std::array<Point, 4>& tet, std::array<Vec3, 3>& gradients) {
  using namespace vec;
  const Vec3 e1 = tet[1] - tet[0];
  const Vec3 e2 = tet[2] - tet[0];
  const Vec3 e3 = tet[3] - tet[0];
  const Vec3 n1 = cross(e2, e3);
  const double inverse = 1 / dot(e1, n1);
  if (!std::isfinite(inverse)) return false;
  gradients = {inverse * n1, inverse * cross(e3, e1), inverse * cross(e1, e2)};
  return true;
}

/// Barycentric coordinates of `p`, of whatever orientation the tet is; false when it is flat.
[[nodiscard]] inline bool barycentrics(const Point& p, const std::array<Point, 4>& tet, std::array<double, 4>& weight) {
  using namespace vec;
  std::array<Vec3, 3> gradients{};
  if (!barycentric_gradients(tet, gradients)) return false;
  const Vec3 d = p - tet[0];
  weight[1] = dot(gradients[0], d);
  weight[2] = dot(gradients[1], d);
  weight[3] = dot(gradients[2], d);
  weight[0] = 1 - weight[1] - weight[2] - weight[3];
  return true;
}

/// A point of a tet.
struct Place {
  std::array<Vertex, 4> corners;
  std::array<double, 4> weight; ///< barycentric coordinates
};

/// Where the position of vs lies after vs -> vd: in the modified tet that contains it, or at the closest point of all
/// of them when a moved boundary has left it outside. vd itself if no tet is left.
[[nodiscard]] inline Place place_after_collapse(const WorkingComplex& complex, const std::vector<Point>& positions,
                                                Vertex vs, Vertex vd) {
  const Point& p = positions[vs];
  Place inside{{vd, vd, vd, vd}, {1, 0, 0, 0}};
  double most = -std::numeric_limits<double>::infinity();
  for_each_modified_tet(complex, vs, vd, [&](SlotId, const std::array<Vertex, 4>& corners) {
    std::array<double, 4> weight{};
    if (most >= kInsideTet || !barycentrics(p, corner_points(corners, positions), weight)) return;
    const double least = std::min({weight[0], weight[1], weight[2], weight[3]});
    if (!(least > most)) return;
    most = least;
    inside = {corners, weight};
  });
  if (most >= kInsideTet) return inside;
  Place closest{{vd, vd, vd, vd}, {1, 0, 0, 0}};
  double distance_sq = std::numeric_limits<double>::infinity();
  for_each_modified_tet(complex, vs, vd, [&](SlotId, const std::array<Vertex, 4>& corners) {
    const ClosestOnTet on = closest_on_tet_surface(p, corner_points(corners, positions));
    if (!(on.distance_sq < distance_sq)) return;
    distance_sq = on.distance_sq;
    closest = {corners, on.weight};
  });
  return closest;
}

/// The distance of vs to the boundary faces that vs -> vd modifies, mesh units; to vd if none is left.
[[nodiscard]] inline double distance_to_modified_faces(const WorkingComplex& complex,
                                                       const std::vector<Point>& positions, Vertex vs, Vertex vd) {
  using namespace vec;
  const Point& p = positions[vs];
  double distance_sq = std::numeric_limits<double>::infinity();
  for_each_modified_face(complex, vs, vd, [&](SlotId, const std::array<Vertex, 3>& f) {
    distance_sq =
        std::min(distance_sq, closest_on_triangle(p, positions[f[0]], positions[f[1]], positions[f[2]]).distance_sq);
  });
  return std::isfinite(distance_sq) ? std::sqrt(distance_sq) : norm(positions[vd] - p);
}

/// Calls `visit(field, distance)` for every field: the Euclidean distance, over the components, of the values at `v`
/// and the values interpolated with `weight` (which may extrapolate) between `corners`; as a fraction of the range.
template <class Visit>
void for_each_field_difference(const NormalizedFields& fields, Vertex v, const std::array<Vertex, 4>& corners,
                               const std::array<double, 4>& weight, Visit&& visit) {
  const double* const f = fields.at(v);
  const std::array<const double*, 4> g{fields.at(corners[0]), fields.at(corners[1]), fields.at(corners[2]),
                                       fields.at(corners[3])};
  double sum_sq = 0;
  for (std::size_t c = 0; c < fields.channel_count(); ++c) {
    const double value = weight[0] * g[0][c] + weight[1] * g[1][c] + weight[2] * g[2][c] + weight[3] * g[3][c];
    sum_sq += (f[c] - value) * (f[c] - value);
    if (!fields.ends_field(c)) continue;
    visit(fields.field_of(c), std::sqrt(sum_sq));
    sum_sq = 0;
  }
}

} // namespace ptet::build
