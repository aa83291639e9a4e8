// An origin near a mesh that lies far from that of its coordinates. Taken off all of them no digit is lost, and what is
// computed with the rest rounds relative to the size of the mesh, not to its distance from 0:
//
//     0 . . . . . . . . . . . . . . . . . . o[ mesh ]      x - o is exact for every x in [o, o + size]
//
// Source: Sterbenz, Floating-point computation, 1974: x - y is exact where y / 2 <= x <= 2 y.
#pragma once

#include "ptet/mesh.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {

/// Of what lies in the box from `low` to `high` (finite): on each axis along which it is further than 16 times its
/// size from 0 the end that is nearer to 0, else 0.
[[nodiscard]] inline Point local_origin(const Point& low, const Point& high) {
  constexpr double kFar = 16;
  const double size = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  Point origin{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double nearest = std::abs(low[axis]) < std::abs(high[axis]) ? low[axis] : high[axis];
    const bool holds_zero = low[axis] <= 0 && high[axis] >= 0;
    if (!holds_zero && std::abs(nearest) > kFar * size) origin[axis] = nearest;
  }
  return origin;
}

} // namespace ptet
