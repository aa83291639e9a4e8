#include "lod/camera.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ptet {
namespace {

using namespace vec;

constexpr double kProjectionSlack = 1e-13; ///< of the numbers that go into a projection

Point unit(const Point& a) {
  const double most = std::max({std::fabs(a[0]), std::fabs(a[1]), std::fabs(a[2])});
  const Point scaled = 1 / most * a; // squares of large numbers would overflow
  return 1 / norm(scaled) * scaled;
}

} // namespace

Camera::Camera(const View& view)
    : eye_(view.eye), forward_(unit(view.direction)), right_(unit(cross(forward_, unit(view.up)))),
      up_(cross(right_, forward_)), tan_v_(std::tan(view.vertical_angle / 2)) {
  tan_h_ = tan_v_ * view.width / view.height;
  const double focal = view.height / (2 * tan_v_);
  steepest_ = focal * std::sqrt(1 + tan_h_ * tan_h_ + tan_v_ * tan_v_) * (1 + kProjectionSlack);
}

// Outside when all points are beyond one side of the picture, or behind the eye.
bool Camera::meets(std::span<const Point> corners) const {
  std::array<double, 5> nearest;
  nearest.fill(INFINITY);
  double most = 0;
  for (const Point& p : corners) {
    const Point at = p - eye_;
    const double depth = dot(at, forward_), x = dot(at, right_), y = dot(at, up_);
    const std::array<double, 5> beyond = {-depth, x - depth * tan_h_, -x - depth * tan_h_, y - depth * tan_v_,
                                          -y - depth * tan_v_};
    for (std::size_t side = 0; side < 5; ++side)
      nearest[side] = std::min(nearest[side], beyond[side]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      most = std::max({most, std::fabs(p[axis]), std::fabs(eye_[axis])});
  }
  const double slack = kProjectionSlack * most * (1 + tan_h_ + tan_v_);
  return std::none_of(nearest.begin(), nearest.end(), [&](double beyond) { return beyond > slack; });
}

double Camera::depth(std::span<const Point> corners) const {
  double least = INFINITY;
  for (const Point& p : corners)
    least = std::min(least, dot(p - eye_, forward_));
  return std::max(0.0, least);
}

double Camera::eye_distance(std::span<const Point> corners) const {
  double distance = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double min = INFINITY, max = -INFINITY;
    for (const Point& p : corners) {
      min = std::min(min, p[axis]);
      max = std::max(max, p[axis]);
    }
    distance = std::hypot(distance, std::max({min - eye_[axis], eye_[axis] - max, 0.0}));
  }
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
