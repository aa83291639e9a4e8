#include "error/star_cones.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {
using namespace vec;
namespace {

/// What rounding may do to a direction, and far more.
constexpr double kSlack = 1e-9;
/// Cones so wide are taken for the whole space.
constexpr double kWide = 0.125;

constexpr BoundingBox kCube{{-1, -1, -1}, {1, 1, 1}};

/// Holds what is seen of the triangle from the apex on the surface of the cube.
BoundingBox box_of_directions(const Point& apex, const StarCones::Triangle& triangle) {
  BoundingBox box;
  for (const Point& corner : triangle) {
    const Vec3 d = corner - apex;
    const double size = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
    if (!(size > 0) || !std::isfinite(1 / size)) return kCube;
    box.add((1 / size) * d);
  }
  // Between the corners, which are on the cube now, the triangle may run inside of it, but no nearer to the apex, in
  // the norm whose unit ball the cube is, than this. So it is seen at itself times 1 to 1 / nearest.
  double nearest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    nearest = std::max({nearest, box.low[axis], -box.high[axis]});
  if (nearest < kWide) return kCube;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] = std::min(box.low[axis], box.low[axis] / nearest) - kSlack;
    box.high[axis] = std::max(box.high[axis], box.high[axis] / nearest) + kSlack;
  }
  return box;
}

std::vector<BoundingBox> boxes_of_directions(const Point& apex, std::span<const StarCones::Triangle> opposite) {
  std::vector<BoundingBox> boxes;
  boxes.reserve(opposite.size());
  for (const StarCones::Triangle& triangle : opposite)
    boxes.push_back(box_of_directions(apex, triangle));
  return boxes;
}

} // namespace

StarCones::StarCones(const Point& apex, std::span<const Triangle> opposite)
    : apex_(apex), tree_(boxes_of_directions(apex, opposite)) {}

void StarCones::find_near(const Triangle& opposite, std::vector<std::uint32_t>& found) const {
  found.clear();
  tree_.each_meeting(box_of_directions(apex_, opposite), [&](std::uint32_t tet) { found.push_back(tet); });
  std::sort(found.begin(), found.end());
}

} // namespace ptet
