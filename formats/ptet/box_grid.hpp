// The boxes of blocks, as the table states them: on a grid of 65,536 places along each axis of the mesh's box, rounded
// outwards. PTET.md, "Table".
#pragma once

#include "ptet/mesh.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace ptet::file {

class BoxGrid {
public:
  static constexpr std::uint16_t kLast = 65535;

  BoxGrid(const Point& least, const Point& greatest) : least_(least), greatest_(greatest) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      step_[axis] = (greatest[axis] - least[axis]) / kLast;
  }
  /// Coordinate of a place: never less than that of the place before.
  [[nodiscard]] double at(std::size_t axis, std::uint16_t place) const {
    return place == kLast ? greatest_[axis] : least_[axis] + place * step_[axis];
  }
  /// The last place that is not above x; 0 where there is none.
  [[nodiscard]] std::uint16_t below(std::size_t axis, double x) const {
    std::uint16_t place = near(axis, x);
    while (place > 0 && at(axis, place) > x)
      --place;
    while (place < kLast && at(axis, static_cast<std::uint16_t>(place + 1)) <= x)
      ++place;
    return place;
  }
  /// The first place that is not below x; the last one where there is none.
  [[nodiscard]] std::uint16_t above(std::size_t axis, double x) const {
    std::uint16_t place = near(axis, x);
    while (place < kLast && at(axis, place) < x)
      ++place;
    while (place > 0 && at(axis, static_cast<std::uint16_t>(place - 1)) >= x)
      --place;
    return place;
  }

private:
  [[nodiscard]] std::uint16_t near(std::size_t axis, double x) const {
    const double place = (x - least_[axis]) / step_[axis];
    return place > 0 ? static_cast<std::uint16_t>(std::min<double>(place, kLast)) : std::uint16_t{0}; // NaN: 0
  }

  Point least_, greatest_;
  Point step_{};
};

} // namespace ptet::file
