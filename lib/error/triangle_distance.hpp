// How far many points are from one triangle: what does not depend on the point is found once.
#pragma once

#include "mesh/closest_point.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace ptet {

class TriangleDistance {
public:
  explicit TriangleDistance(const std::array<Point, 3>& corners) : corners_(corners) {
    using namespace vec;
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      along_[i] = corners[(i + 1) % 3] - corners[i];
      length_[i] = norm(along_[i]);
      longest = std::max(longest, length_[i]);
    }
    const Vec3 twice_area = cross(along_[0], along_[1]);
    const double size = norm(twice_area);
    is_thin_ = !(size > kThin * longest * longest);
    if (is_thin_) return;
    normal_ = (1 / size) * twice_area;
    for (std::size_t i = 0; i < 3; ++i) {
      along_[i] = (1 / length_[i]) * along_[i];
      inward_[i] = cross(normal_, along_[i]);
    }
  }

  /// The square of the distance; where that is no less than `enough`, perhaps a lower bound, which is no less either.
  [[nodiscard]] double squared(const Point& p, double enough = std::numeric_limits<double>::infinity()) const {
    using namespace vec;
    if (is_thin_) return closest_on_triangle(p, corners_[0], corners_[1], corners_[2]).distance_sq;
    const double above = dot(normal_, p - corners_[0]);
    const double above_sq = above * above;
    if (above_sq >= enough) return above_sq;
    // Over the inside the nearest point is the foot on the plane; else it lies on an edge that is seen from the foot.
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 from_corner = p - corners_[i];
      const double inside = dot(inward_[i], from_corner);
      if (inside >= 0) continue;
      const double to_line_sq = above_sq + inside * inside;
      if (to_line_sq >= enough) return to_line_sq;
      const Vec3 rest = from_corner - std::clamp(dot(along_[i], from_corner), 0.0, length_[i]) * along_[i];
      nearest = std::min(nearest, dot(rest, rest));
    }
    return nearest < std::numeric_limits<double>::infinity() ? nearest : above_sq;
  }

private:
  /// Below this height, as a part of the longest edge, what is precomputed is not exact enough.
  static constexpr double kThin = 1e-2;

  std::array<Point, 3> corners_;
  Vec3 normal_{};                        ///< of length 1
  std::array<Vec3, 3> along_, inward_{}; ///< by edge, of length 1: to its end, and in the plane to the inside
  std::array<double, 3> length_{};
  bool is_thin_;
};

} // namespace ptet
