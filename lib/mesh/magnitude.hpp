#pragma once

#include "ptet/mesh.hpp"

#include <cmath>
#include <cstdint>

namespace ptet {

/// The value of a scalar array at a vertex; of an array of vectors, the length.
inline double magnitude(const PointArray& array, VertexId v) {
  if (array.components == 1) return array.value(v.index(), 0);
  double length = 0;
  for (std::uint32_t c = 0; c < array.components; ++c)
    length = std::hypot(length, array.value(v.index(), c));
  return length;
}

} // namespace ptet
