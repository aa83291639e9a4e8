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
  [[nodiscard]] double at(std::size_t axis, std::uint32_t place) const {
    return place == kLast ? greatest_[axis] : std::min(greatest_[axis], least_[axis] + place * step_[axis]);
  }
  /// The last place that is not above x; 0 where there is none.
  [[nodiscard]] std::uint16_t below(std::size_t axis, double x) const {
    const std::uint32_t above = first([&](std::uint32_t place) { return at(axis, place) > x; });
    return static_cast<std::uint16_t>(above > 0 ? above - 1 : 0);
  }
  /// The first place that is not below x; the last one where there is none.
  [[nodiscard]] std::uint16_t above(std::size_t axis, double x) const {
    return static_cast<std::uint16_t>(
        std::min<std::uint32_t>(kLast, first([&](std::uint32_t place) { return at(axis, place) >= x; })));
  }

private:
  /// The first place of which something holds that holds of all behind it, or kLast + 1.
  template <class Holds>
  [[nodiscard]] static std::uint32_t first(Holds&& holds) {
    std::uint32_t low = 0, high = std::uint32_t{kLast} + 1;
    while (low < high) {
      const std::uint32_t middle = (low + high) / 2;
      if (holds(middle))
        high = middle;
      else
        low = middle + 1;
    }
    return low;
  }

  Point least_, greatest_;
  Point step_{};
};

} // namespace ptet::file
