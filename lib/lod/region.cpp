#include "lod/region.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ptet {
namespace {

using namespace vec;

// Far more than the rounding of the few products and sums of a projection.
constexpr double kSlack = 1e-14;
constexpr std::array<Point, 3> kAxes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

double magnitude(const Point& axis, const Point& p) {
  return std::fabs(axis[0] * p[0]) + std::fabs(axis[1] * p[1]) + std::fabs(axis[2] * p[2]);
}

double length(const Point& a) {
  // std::hypot is slow, and needed only where squares would overflow or vanish.
  const double squared = dot(a, a);
  return squared > 1e-200 && squared < 1e200 ? std::sqrt(squared) : std::hypot(a[0], a[1], a[2]);
}

/// How far something reaches along an axis, and for each end a bound on the numbers that went into it: a box may be
/// far larger than the mesh, and what matters still be its near side.
struct Extent {
  double low, high, low_magnitude, high_magnitude;
};
Extent extent(const Box& box, const Point& axis) {
  Extent e{0, 0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const double low = axis[i] * (axis[i] > 0 ? box.min[i] : box.max[i]);
    const double high = axis[i] * (axis[i] > 0 ? box.max[i] : box.min[i]);
    e.low += low;
    e.high += high;
    e.low_magnitude += std::fabs(low);
    e.high_magnitude += std::fabs(high);
  }
  return e;
}
Extent extent(const OrientedBox& box, const Point& axis) {
  const double middle = dot(axis, box.centre);
  double reach = 0, most = magnitude(axis, box.centre);
  for (const Point& half : box.half_axes) {
    reach += std::fabs(dot(axis, half));
    most += magnitude(axis, half);
  }
  return {middle - reach, middle + reach, most, most};
}
Extent extent(const Sphere& sphere, const Point& axis) {
  const double middle = dot(axis, sphere.centre);
  const double reach = sphere.radius * norm(axis);
  const double most = magnitude(axis, sphere.centre) + reach;
  return {middle - reach, middle + reach, most, most};
}
Extent extent(std::span<const Point> corners, const Point& axis) {
  Extent e{INFINITY, -INFINITY, 0, 0};
  for (const Point& p : corners) {
    const double at = dot(axis, p);
    e.low = std::min(e.low, at);
    e.high = std::max(e.high, at);
    e.low_magnitude = std::max(e.low_magnitude, magnitude(axis, p));
  }
  e.high_magnitude = e.low_magnitude;
  return e;
}

// Any axis that separates is proof, however inaccurately the axis itself was found; one of length zero never does.
double gap(const Extent& a, const Extent& b) {
  return std::max(a.low - b.high - kSlack * std::max(a.low_magnitude, b.high_magnitude),
                  b.low - a.high - kSlack * std::max(b.low_magnitude, a.high_magnitude));
}

// ---- the axes along which a shape and a polytope can be apart; `f` returns true to see no more of them ----

template <class F>
bool any_face_normal(std::span<const Point> corners, F&& f) {
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (std::size_t j = i + 1; j < corners.size(); ++j)
      for (std::size_t k = j + 1; k < corners.size(); ++k)
        if (f(cross(corners[j] - corners[i], corners[k] - corners[i]))) return true;
  return false;
}

/// `sides`: the directions of the box's edges.
template <class F>
bool any_box_axis(const std::array<Point, 3>& sides, std::span<const Point> corners, F&& f) {
  for (const Point& axis : sides)
    if (f(axis)) return true;
  if (any_face_normal(corners, f)) return true;
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (std::size_t j = i + 1; j < corners.size(); ++j)
      for (const Point& axis : sides)
        if (f(cross(axis, corners[j] - corners[i]))) return true;
  // A triangle has three more axes: its edges' normals in its own plane. A tet's faces take care of that.
  if (corners.size() == 3) {
    const Point normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
    for (std::size_t i = 0; i < 3; ++i)
      if (f(cross(normal, corners[(i + 1) % 3] - corners[i]))) return true;
  }
  return false;
}
template <class F>
bool any_axis(const Box&, std::span<const Point> corners, F&& f) {
  return any_box_axis(kAxes, corners, f);
}
template <class F>
bool any_axis(const OrientedBox& box, std::span<const Point> corners, F&& f) {
  // The half axes are perpendicular only nearly, so the sides have normals of their own.
  for (std::size_t i = 0; i < 3; ++i)
    if (f(cross(box.half_axes[i], box.half_axes[(i + 1) % 3]))) return true;
  return any_box_axis(box.half_axes, corners, f);
}
// A ball is apart from a polytope if and only if the direction to the closest point, which is on a corner, an edge or
// a face, separates them.
template <class F>
bool any_axis(const Sphere& sphere, std::span<const Point> corners, F&& f) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point to_corner = corners[i] - sphere.centre;
    if (f(to_corner)) return true;
    for (std::size_t j = i + 1; j < corners.size(); ++j) {
      const Point edge = corners[j] - corners[i];
      if (f(cross(edge, cross(to_corner, edge)))) return true;
    }
  }
  return any_face_normal(corners, f);
}

// Apart from those, what is nearest may be a corner of one and a corner or an edge of the other.
Point closest_point(const Box& box, const Point& p) {
  Point q{};
  for (std::size_t i = 0; i < 3; ++i)
    q[i] = std::clamp(p[i], box.min[i], box.max[i]);
  return q;
}
Point closest_point(const OrientedBox& box, const Point& p) {
  Point q = box.centre;
  for (const Point& half : box.half_axes) {
    const double square = dot(half, half);
    if (square > 0) q = q + std::clamp(dot(p - box.centre, half) / square, -1.0, 1.0) * half;
  }
  return q;
}
std::array<Point, 8> corners_of(const Box& box) {
  return box_corners(box.min, box.max);
}
std::array<Point, 8> corners_of(const OrientedBox& box) {
  std::array<Point, 8> corners{};
  for (std::size_t i = 0; i < 8; ++i) {
    corners[i] = box.centre;
    for (std::size_t axis = 0; axis < 3; ++axis)
      corners[i] = corners[i] + (((i >> axis) & 1U) != 0 ? 1.0 : -1.0) * box.half_axes[axis];
  }
  return corners;
}
template <class AnyBox, class F>
void nearest_corner_axes(const AnyBox& box, std::span<const Point> corners, F&& f) {
  for (const Point& p : corners)
    f(p - closest_point(box, p));
  for (const Point& q : corners_of(box))
    for (std::size_t i = 0; i < corners.size(); ++i)
      for (std::size_t j = i + 1; j < corners.size(); ++j) {
        const Point edge = corners[j] - corners[i];
        f(cross(edge, cross(corners[i] - q, edge)));
      }
}
template <class F>
void nearest_corner_axes(const Sphere&, std::span<const Point>, F&&) {}

template <class Shape>
bool are_apart(const Shape& shape, std::span<const Point> corners) {
  return any_axis(shape, corners,
                  [&](const Point& axis) { return gap(extent(shape, axis), extent(corners, axis)) > 0; });
}

template <class Shape>
double lower_bound(const Shape& shape, std::span<const Point> corners) {
  double most = 0;
  const auto look_along = [&](const Point& axis) {
    const double apart = gap(extent(shape, axis), extent(corners, axis));
    if (apart > 0) most = std::max(most, apart / norm(axis) * (1 - kSlack));
    return false;
  };
  any_axis(shape, corners, look_along);
  if (most > 0) nearest_corner_axes(shape, corners, look_along);
  return most;
}

/// How far the least of the corners is out of the half-space, times the length of its normal; not above the truth.
double height(const HalfSpace& half_space, std::span<const Point> corners) {
  const Extent e = extent(corners, half_space.normal);
  return e.low - half_space.offset - kSlack * std::max(e.low_magnitude, std::fabs(half_space.offset));
}
bool are_apart(const HalfSpace& half_space, std::span<const Point> corners) {
  return height(half_space, corners) > 0;
}
double lower_bound(const HalfSpace& half_space, std::span<const Point> corners) {
  return std::max(0.0, height(half_space, corners)) / norm(half_space.normal) * (1 - kSlack);
}

// ---- against a box that is parallel to the axes ----

double box_distance(const Box& region, const Box& box) {
  Point apart{};
  for (std::size_t i = 0; i < 3; ++i)
    apart[i] = std::max({region.min[i] - box.max[i], box.min[i] - region.max[i], 0.0});
  return length(apart) * (1 - kSlack);
}
double box_distance(const Sphere& sphere, const Box& box) {
  Point apart{};
  double most = sphere.radius;
  for (std::size_t i = 0; i < 3; ++i) {
    apart[i] = std::max({box.min[i] - sphere.centre[i], sphere.centre[i] - box.max[i], 0.0});
    most = std::max({most, std::fabs(sphere.centre[i]), std::fabs(box.min[i]), std::fabs(box.max[i])});
  }
  return std::max(0.0, length(apart) - sphere.radius - kSlack * most);
}
double box_distance(const OrientedBox& region, const Box& box) {
  double most = 0;
  const auto look_along = [&](const Point& axis) {
    const double apart = gap(extent(region, axis), extent(box, axis));
    if (apart > 0) most = std::max(most, apart / norm(axis) * (1 - kSlack));
  };
  for (std::size_t i = 0; i < 3; ++i) {
    look_along(kAxes[i]);
    look_along(region.half_axes[i]);
    look_along(cross(region.half_axes[i], region.half_axes[(i + 1) % 3]));
  }
  return most;
}
double box_distance(const HalfSpace& half_space, const Box& box) {
  const Extent e = extent(box, half_space.normal);
  const double above = e.low - half_space.offset - kSlack * std::max(e.low_magnitude, std::fabs(half_space.offset));
  return std::max(0.0, above) / norm(half_space.normal) * (1 - kSlack);
}

template <class Shape>
double farthest_in(const Shape& shape, const Box& box) {
  return box_distance(shape, box) + norm(box.max - box.min);
}
// Its distance from a box is a lower bound, that from a point is none.
double farthest_in(const OrientedBox& region, const Box& box) {
  const Point middle = 0.5 * box.min + 0.5 * box.max;
  return lower_bound(region, std::span(&middle, 1)) + 0.5 * norm(box.max - box.min);
}

template <class Shape>
bool are_apart(const Shape& shape, const Box& box) {
  return box_distance(shape, box) > 0;
}
// Asked of every star near the sphere: squares decide, but where the distances are nearly the same. That says of all
// the others what their distance would.
bool are_apart(const Sphere& sphere, const Box& box) {
  double apart_sq = 0, most = sphere.radius;
  for (std::size_t i = 0; i < 3; ++i) {
    const double apart = std::max({box.min[i] - sphere.centre[i], sphere.centre[i] - box.max[i], 0.0});
    apart_sq += apart * apart;
    most = std::max({most, std::fabs(sphere.centre[i]), std::fabs(box.min[i]), std::fabs(box.max[i])});
  }
  const double radius_sq = sphere.radius * sphere.radius;
  if (radius_sq > 1e-200 && radius_sq < 1e200) { // else what matters may have vanished
    if (apart_sq <= radius_sq) return false;
    constexpr double kPlainly = 1.01, kFarAboveSlack = 1e8 * kSlack * kSlack; // the gap is 0.4% of the distance
    if (apart_sq > kPlainly * radius_sq && apart_sq > kFarAboveSlack * most * most) return true;
  }
  return box_distance(sphere, box) > 0;
}

bool holds(const Box& box, const Point& p) {
  for (std::size_t i = 0; i < 3; ++i)
    if (p[i] < box.min[i] || p[i] > box.max[i]) return false;
  return true;
}
// Well inside: the half axes may be askew by 1e-6 of their lengths.
bool holds(const OrientedBox& box, const Point& p) {
  constexpr double kAskew = 1e-5;
  for (const Point& half : box.half_axes) {
    const double square = dot(half, half);
    const Point to = p - box.centre;
    const double at = std::fabs(dot(to, half)) + kAskew * norm(to) * norm(half) + kSlack * magnitude(half, box.centre);
    if (!(at < square)) return false;
  }
  return true;
}
bool holds(const Sphere& sphere, const Point& p) {
  const double most = std::max({magnitude({1, 1, 1}, sphere.centre), magnitude({1, 1, 1}, p), sphere.radius});
  return length(p - sphere.centre) < sphere.radius - kSlack * most;
}
bool holds(const HalfSpace& half_space, const Point& p) {
  const double most = std::max(magnitude(half_space.normal, p), std::fabs(half_space.offset));
  return dot(half_space.normal, p) < half_space.offset - kSlack * most;
}

} // namespace

bool meets(const Region& region, std::span<const Point> corners, double around) {
  return std::visit([&](const auto& shape) { return !are_apart(shape, corners); }, region) ||
         (around > 0 && distance(region, corners) <= around);
}

bool meets(const Region& region, const Point& min, const Point& max, double around) {
  return std::visit(
             [&](const auto& shape) {
               return !are_apart(shape, Box{min, max});
             },
             region) ||
         (around > 0 && distance(region, min, max) <= around);
}

void find_meeting(const Region& region, std::span<const Box> boxes, std::span<char> found) {
  std::visit(
      [&](const auto& shape) {
        for (std::size_t i = 0; i < boxes.size(); ++i)
          if (found[i] == 0) found[i] = are_apart(shape, boxes[i]) ? 0 : 1;
      },
      region);
}

double distance(const Region& region, std::span<const Point> corners) {
  return std::visit([&](const auto& shape) { return lower_bound(shape, corners); }, region);
}

double distance(const Region& region, const Point& min, const Point& max) {
  return std::visit([&](const auto& shape) { return box_distance(shape, Box{min, max}); }, region);
}

double farthest(const Region& region, const Point& min, const Point& max) {
  return std::visit([&](const auto& shape) { return farthest_in(shape, Box{min, max}); }, region);
}

bool contains(const Region& region, const Point& min, const Point& max) {
  if (min == max) return std::visit([&](const auto& shape) { return holds(shape, min); }, region);
  const std::array<Point, 8> corners = box_corners(min, max);
  return std::visit(
      [&](const auto& shape) {
        return std::all_of(corners.begin(), corners.end(), [&](const Point& p) { return holds(shape, p); });
      },
      region);
}

std::array<Point, 8> box_corners(const Point& min, const Point& max) {
  std::array<Point, 8> corners{};
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      corners[i][axis] = ((i >> axis) & 1U) != 0 ? max[axis] : min[axis];
  return corners;
}

} // namespace ptet
