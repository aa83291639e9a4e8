// Places along a Morton curve.
#pragma once

#include "ptet/mesh.hpp"

#include <algorithm>
#include <cstdint>

namespace ptet {

/// Every third bit of the result is one of the low 21 bits of `x`: those of one axis.
[[nodiscard]] constexpr std::uint64_t morton_spread(std::uint64_t x) {
  x &= 0x1FFFFF;
  x = (x | x << 32) & 0x001F00000000FFFF;
  x = (x | x << 16) & 0x001F0000FF0000FF;
  x = (x | x << 8) & 0x100F00F00F00F00F;
  x = (x | x << 4) & 0x10C30C30C30C30C3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

/// The place of a point in the cube of this size from `low` on; what lies outside counts as on its surface.
[[nodiscard]] inline std::uint64_t morton_code(const Point& p, const Point& low, double size) {
  std::uint64_t code = 0;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double fraction = (p[axis] - low[axis]) / size; // NaN in a cube without size
    code |= morton_spread(fraction > 0 ? static_cast<std::uint64_t>(std::min(fraction, 1.0) * 0x1FFFFF) : 0) << axis;
  }
  return code;
}

} // namespace ptet
