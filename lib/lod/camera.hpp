// A View made ready for questions: what it sees, and how large an error looks.
//
//   eye *----------- direction: depth -->      picture: |right| <= depth tan_h, |up| <= depth tan_v, depth >= 0
#pragma once

#include "ptet/request.hpp"

#include <span>

namespace ptet {

class Camera {
public:
  /// Of a view that is known to be sound.
  explicit Camera(const View& view);

  /// Whether the hull of the points may be seen in the picture; a "no" is certain.
  [[nodiscard]] bool meets(std::span<const Point> corners) const;
  /// Least depth of the points; not below 0.
  [[nodiscard]] double depth(std::span<const Point> corners) const;
  /// Distance from the eye to the box around the points.
  [[nodiscard]] double eye_distance(std::span<const Point> corners) const;

  /// The length that nowhere in the picture looks longer than `pixels` when the nearer end of it is at least so deep
  /// as `depth`, less that length: two points in the picture, e apart and deeper than z, are seen no more than
  /// focal e sqrt(1 + tan_h^2 + tan_v^2) / z apart, as the slope of the perspective is no steeper.
  [[nodiscard]] double length_of(double pixels, double depth) const;
  /// The other way round: how many pixels such a length is; infinity where it reaches the eye.
  [[nodiscard]] double pixels_of(double length, double depth) const;

  friend bool operator==(const Camera&, const Camera&) = default;

private:
  Point eye_, forward_, right_, up_;
  double tan_h_, tan_v_;
  double steepest_; ///< pixels of a length of 1 at depth 1, at most
};

} // namespace ptet
