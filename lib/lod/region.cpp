#include "lod/region.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {
namespace {

// Far more than the rounding of the few products and sums of a projection.
constexpr double kSlack = 1e-14;

Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
double length(const Point& a) {
  // std::hypot is slow, and needed only where squares would overflow or vanish.
  const double squared = dot(a, a);
  return squared > 1e-200 && squared < 1e200 ? std::sqrt(squared) : std::hypot(a[0], a[1], a[2]);
}
double magnitude(const Point& axis, const Point& p) {
  return std::fabs(axis[0] * p[0]) + std::fabs(axis[1] * p[1]) + std::fabs(axis[2] * p[2]);
}

// The region's extent along the axis, and a bound on the numbers that went into it.
struct Extent {
  double low, high, magnitude;
};
Extent extent(const Box& box, const Point& axis) {
  Extent e{0, 0, magnitude(axis, box.min) + magnitude(axis, box.max)};
  for (std::size_t i = 0; i < 3; ++i) {
    e.low += axis[i] * (axis[i] > 0 ? box.min[i] : box.max[i]);
    e.high += axis[i] * (axis[i] > 0 ? box.max[i] : box.min[i]);
  }
  return e;
}
Extent extent(const Sphere& sphere, const Point& axis) {
  const double middle = dot(axis, sphere.centre);
  const double reach = sphere.radius * std::sqrt(dot(axis, axis));
  return {middle - reach, middle + reach, magnitude(axis, sphere.centre) + reach};
}

// Any axis that separates is proof, however inaccurately the axis itself was found; one of length zero never does.
template <class Region>
bool separates(const Point& axis, const Region& region, std::span<const Point> corners) {
  const Extent e = extent(region, axis);
  double low = INFINITY, high = -INFINITY, most = e.magnitude;
  for (const Point& p : corners) {
    const double at = dot(axis, p);
    low = std::min(low, at);
    high = std::max(high, at);
    most = std::max(most, magnitude(axis, p));
  }
  const double slack = kSlack * most;
  return low - e.high > slack || e.low - high > slack;
}

template <class Region>
bool a_face_separates(const Region& region, std::span<const Point> corners) {
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (std::size_t j = i + 1; j < corners.size(); ++j)
      for (std::size_t k = j + 1; k < corners.size(); ++k)
        if (separates(cross(minus(corners[j], corners[i]), minus(corners[k], corners[i])), region, corners))
          return true;
  return false;
}

bool are_apart(const Box& box, std::span<const Point> corners) {
  constexpr std::array<Point, 3> kAxes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (const Point& axis : kAxes)
    if (separates(axis, box, corners)) return true;
  if (a_face_separates(box, corners)) return true;
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (std::size_t j = i + 1; j < corners.size(); ++j)
      for (const Point& axis : kAxes)
        if (separates(cross(axis, minus(corners[j], corners[i])), box, corners)) return true;
  // A triangle has three more axes: its edges' normals in its own plane. A tet's faces take care of that.
  if (corners.size() == 3) {
    const Point normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    for (std::size_t i = 0; i < 3; ++i)
      if (separates(cross(normal, minus(corners[(i + 1) % 3], corners[i])), box, corners)) return true;
  }
  return false;
}

// A ball is apart from a polytope if and only if the direction to the closest point, which is on a corner, an edge or
// a face, separates them.
bool are_apart(const Sphere& sphere, std::span<const Point> corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point to_corner = minus(corners[i], sphere.centre);
    if (separates(to_corner, sphere, corners)) return true;
    for (std::size_t j = i + 1; j < corners.size(); ++j) {
      const Point edge = minus(corners[j], corners[i]);
      if (separates(cross(edge, cross(to_corner, edge)), sphere, corners)) return true;
    }
  }
  return a_face_separates(sphere, corners);
}

} // namespace

bool meets(const FocusRegion& region, std::span<const Point> corners) {
  return std::visit([&](const auto& shape) { return !are_apart(shape, corners); }, region);
}

bool meets(const FocusRegion& region, const Point& min, const Point& max) {
  if (const Box* const box = std::get_if<Box>(&region)) {
    for (std::size_t i = 0; i < 3; ++i)
      if (box->min[i] > max[i] || box->max[i] < min[i]) return false;
    return true;
  }
  const Sphere& sphere = std::get<Sphere>(region);
  Point outside{};
  double most = sphere.radius;
  for (std::size_t i = 0; i < 3; ++i) {
    outside[i] = std::max({min[i] - sphere.centre[i], sphere.centre[i] - max[i], 0.0});
    most = std::max({most, std::fabs(sphere.centre[i]), std::fabs(min[i]), std::fabs(max[i])});
  }
  return !(length(outside) > sphere.radius + kSlack * most);
}

bool contains(const FocusRegion& region, const Point& min, const Point& max) {
  if (const Box* const box = std::get_if<Box>(&region)) {
    for (std::size_t i = 0; i < 3; ++i)
      if (min[i] < box->min[i] || max[i] > box->max[i]) return false;
    return true;
  }
  const Sphere& sphere = std::get<Sphere>(region);
  Point furthest{};
  double most = sphere.radius;
  for (std::size_t i = 0; i < 3; ++i) {
    furthest[i] = std::max(max[i] - sphere.centre[i], sphere.centre[i] - min[i]);
    most = std::max({most, std::fabs(sphere.centre[i]), std::fabs(min[i]), std::fabs(max[i])});
  }
  return length(furthest) < sphere.radius - kSlack * most;
}

} // namespace ptet
