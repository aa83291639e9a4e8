#include "lod/camera.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {
namespace {

using namespace vec;

constexpr double kProjectionSlack = 1e-13; ///< of the numbers that go into a projection

/// Of a vector that has a direction.
Point unit(const Point& a) {
  return direction_of(a).value_or(a);
}

} // namespace

Camera::Camera(const View& view) : eye_(view.eye), forward_(unit(view.direction)) {
  const Point right = unit(cross(forward_, unit(view.up))), up = cross(right, forward_);
  const double tan_v = std::tan(view.vertical_angle / 2), tan_h = tan_v * view.width / view.height;
  beyond_ = {-1 * forward_, unit(right - tan_h * forward_), unit(-1 * right - tan_h * forward_),
             unit(up - tan_v * forward_), unit(-1 * up - tan_v * forward_)};
  slack_ = kProjectionSlack * (1 + tan_h + tan_v);
  const double focal = view.height / (2 * tan_v);
  steepest_ = focal * std::sqrt(1 + tan_h * tan_h + tan_v * tan_v) * (1 + kProjectionSlack);
}

double Camera::least_along(const Point& direction, std::span<const Point> corners) const {
  double least = INFINITY;
  for (const Point& p : corners)
    least = std::min(least, dot(p - eye_, direction));
  return least;
}
double Camera::least_along(const Point& direction, const Box& box) const {
  double least = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    least += direction[axis] * ((direction[axis] < 0 ? box.max : box.min)[axis] - eye_[axis]);
  return least;
}

// Not when all of it is beyond one side of the picture, or behind the eye. `farthest`: greatest coordinate.
template <class Place>
bool Camera::may_see(const Place& place, double farthest, double around) const {
  const double slack = slack_ * std::max({farthest, std::fabs(eye_[0]), std::fabs(eye_[1]), std::fabs(eye_[2])});
  return std::none_of(beyond_.begin(), beyond_.end(),
                      [&](const Point& beyond) { return least_along(beyond, place) > around + slack; });
}

bool Camera::meets(std::span<const Point> corners, double around) const {
  double farthest = 0;
  for (const Point& p : corners)
    farthest = std::max({farthest, std::fabs(p[0]), std::fabs(p[1]), std::fabs(p[2])});
  return may_see(corners, farthest, around);
}
bool Camera::meets(const Box& box, double around) const {
  double farthest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    farthest = std::max({farthest, std::fabs(box.min[axis]), std::fabs(box.max[axis])});
  return may_see(box, farthest, around);
}

double Camera::depth(std::span<const Point> corners) const {
  return std::max(0.0, least_along(forward_, corners));
}
double Camera::depth(const Box& box) const {
  return std::max(0.0, least_along(forward_, box));
}

double Camera::eye_distance(std::span<const Point> corners) const {
  Box around{corners[0], corners[0]};
  for (const Point& p : corners)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      around.min[axis] = std::min(around.min[axis], p[axis]);
      around.max[axis] = std::max(around.max[axis], p[axis]);
    }
  return eye_distance(around);
}
double Camera::eye_distance(const Box& box) const {
  double distance = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    distance = std::hypot(distance, std::max({box.min[axis] - eye_[axis], eye_[axis] - box.max[axis], 0.0}));
  return distance;
}

double Camera::length_of(double pixels, double depth) const {
  return pixels / (steepest_ + pixels) * depth;
}

double Camera::pixels_of(double length, double depth) const {
  if (length == 0) return 0;
  return length < depth ? length * steepest_ / (depth - length) : INFINITY;
}

} // namespace ptet
