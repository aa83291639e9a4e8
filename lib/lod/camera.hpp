// A View made ready for questions: what it sees, and how large an error looks.
//
//   eye *----------- direction: depth -->      picture: |right| <= depth tan_h, |up| <= depth tan_v, depth >= 0
#pragma once

#include "ptet/request.hpp"

#include <array>
#include <span>

namespace ptet {

class Camera {
public:
  /// Of a view that is known to be sound.
  explicit Camera(const View& view);

  /// Whether the hull of the points, or the box, or anything no further than `around` from it, may be seen in the
  /// picture; a "no" is certain.
  [[nodiscard]] bool meets(std::span<const Point> corners, double around = 0) const;
  [[nodiscard]] bool meets(const Box& box, double around = 0) const;
  /// Least depth of the points, or in the box; not below 0.
  [[nodiscard]] double depth(std::span<const Point> corners) const;
  [[nodiscard]] double depth(const Box& box) const;
  /// Distance from the eye to the box, or the one around the points.
  [[nodiscard]] double eye_distance(std::span<const Point> corners) const;
  [[nodiscard]] double eye_distance(const Box& box) const;

  /// The length that nowhere in the picture looks longer than `pixels` when the nearer end of it is at least so deep
  /// as `depth`, less that length: two points in the picture, e apart and deeper than z, are seen no more than
  /// focal e sqrt(1 + tan_h^2 + tan_v^2) / z apart, as the slope of the perspective is no steeper.
  [[nodiscard]] double length_of(double pixels, double depth) const;
  /// The other way round: how many pixels such a length is; infinity where it reaches the eye.
  [[nodiscard]] double pixels_of(double length, double depth) const;

  friend bool operator==(const Camera&, const Camera&) = default;

private:
  [[nodiscard]] double least_along(const Point& direction, std::span<const Point> corners) const;
  [[nodiscard]] double least_along(const Point& direction, const Box& box) const;
  template <class Place>
  [[nodiscard]] bool may_see(const Place& place, double farthest, double around) const;

  Point eye_, forward_;
  std::array<Point, 5> beyond_; ///< out of the picture: behind the eye, and away from its four sides; of length 1
  double slack_;                ///< of a number along one of them, as a fraction of what goes into it
  double steepest_;             ///< pixels of a length of 1 at depth 1, at most
};

} // namespace ptet
