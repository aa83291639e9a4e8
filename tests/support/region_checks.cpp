#include "support/region_checks.hpp"

#include "support/mesh_checks.hpp"

#include <array>
#include <cmath>
#include <variant>

namespace ptet::test {
namespace {

double product(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Point a_point_of(const Region& region) {
  if (const Box* const box = std::get_if<Box>(&region)) return box->max;
  if (const OrientedBox* const box = std::get_if<OrientedBox>(&region)) return box->centre;
  if (const Sphere* const sphere = std::get_if<Sphere>(&region)) return sphere->centre;
  const HalfSpace& half_space = std::get<HalfSpace>(region);
  Point p = half_space.normal;
  for (double& x : p)
    x *= (half_space.offset - 1e-9 * std::fabs(half_space.offset)) / product(half_space.normal, half_space.normal);
  return p;
}

bool is_in(const Region& region, const Point& p) {
  if (const Box* const box = std::get_if<Box>(&region)) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (p[axis] < box->min[axis] || p[axis] > box->max[axis]) return false;
    return true;
  }
  if (const HalfSpace* const half_space = std::get_if<HalfSpace>(&region))
    return product(half_space->normal, p) <= half_space->offset;
  const Point centre = a_point_of(region), to{p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
  if (const Sphere* const sphere = std::get_if<Sphere>(&region))
    return product(to, to) <= sphere->radius * sphere->radius;
  for (const Point& half : std::get<OrientedBox>(region).half_axes)
    if (std::fabs(product(to, half)) > product(half, half)) return false;
  return true;
}

} // namespace

bool contains(const TetMesh& mesh, const Tet& tet, const Point& p) {
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<Point, 4> corners;
    for (std::size_t j = 0; j < 4; ++j)
      corners[j] = mesh.position(tet[j]);
    corners[i] = p;
    if (orientation(corners[0], corners[1], corners[2], corners[3]) < 0) return false;
  }
  return true;
}

bool surely_meets(const Region& region, const TetMesh& mesh, const Tet& tet) {
  if (contains(mesh, tet, a_point_of(region))) return true;
  constexpr int kSteps = 4;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps - i; ++j)
      for (int k = 0; k <= kSteps - i - j; ++k) {
        const std::array<double, 4> weight = {i / double(kSteps), j / double(kSteps), k / double(kSteps),
                                              (kSteps - i - j - k) / double(kSteps)};
        Point p{};
        for (std::size_t corner = 0; corner < 4; ++corner)
          for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] += weight[corner] * mesh.position(tet[corner])[axis];
        if (is_in(region, p)) return true;
      }
  return false;
}

} // namespace ptet::test
