#include "placement.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace ptet::view {
namespace {

// What VTK draws well as it is: extents, and how far from the origin in extents.
constexpr double kLeast = 1e-4;
constexpr double kMost = 1e6;
constexpr double kFarthest = 1e4;

/// Moves and scales regions: points by one function, vectors and lengths by another.
template <class OfPoint, class OfLength, class OfPlane>
Region moved(const Region& region, OfPoint&& point, OfLength&& length, OfPlane&& plane) {
  struct Visitor {
    OfPoint& point;
    OfLength& length;
    OfPlane& plane;

    Region operator()(const Box& box) const { return Box{point(box.min), point(box.max)}; }
    Region operator()(const OrientedBox& box) const {
      OrientedBox result{point(box.centre), box.half_axes};
      for (Point& axis : result.half_axes)
        for (double& x : axis)
          x = length(x);
      return result;
    }
    Region operator()(const Sphere& sphere) const { return Sphere{point(sphere.centre), length(sphere.radius)}; }
    Region operator()(const HalfSpace& half_space) const {
      const Plane result = plane(Plane{half_space.normal, half_space.offset});
      return HalfSpace{result.normal, result.offset};
    }
  };
  return std::visit(Visitor{point, length, plane}, region);
}

} // namespace

Placement::Placement(const DatasetInfo& info) {
  double farthest = 0;
  for (std::size_t i = 0; i < 3; ++i)
    farthest = std::max({farthest, std::fabs(info.box_min[i]), std::fabs(info.box_max[i])});
  const double diagonal = info.diagonal;
  const bool is_drawn_well = kLeast <= diagonal && diagonal <= kMost && farthest <= kFarthest * diagonal;
  if (is_drawn_well || !(diagonal > 0) || !std::isfinite(diagonal)) return;
  is_identity_ = false;
  unit_ = diagonal;
  for (std::size_t i = 0; i < 3; ++i)
    origin_[i] = info.box_min[i] / 2 + info.box_max[i] / 2;
}

Plane Placement::drawn(const Plane& plane) const {
  if (is_identity_) return plane;
  return {plane.normal, (plane.offset - dot(plane.normal, origin_)) / unit_};
}

Region Placement::drawn(const Region& region) const {
  if (is_identity_) return region;
  return moved(
      region, [&](const Point& p) { return drawn(p); }, [&](double x) { return drawn(x); },
      [&](const Plane& plane) { return drawn(plane); });
}

Region Placement::in_file(const Region& region) const {
  if (is_identity_) return region;
  return moved(
      region,
      [&](const Point& p) {
        return Point{origin_[0] + unit_ * p[0], origin_[1] + unit_ * p[1], origin_[2] + unit_ * p[2]};
      },
      [&](double x) { return unit_ * x; },
      [&](const Plane& plane) {
        return Plane{plane.normal, unit_ * plane.offset + dot(plane.normal, origin_)};
      });
}

} // namespace ptet::view
