// Rows of a point array, picked by vertex.
#pragma once

#include "mesh/large_pages.hpp"
#include "ptet/mesh.hpp"

#include <cstring>
#include <span>

namespace ptet {

/// The rows of `vertices`, in their order; runs of neighbours are copied at once.
[[nodiscard]] inline PointArray gather(const PointArray& from, std::span<const VertexId> vertices) {
  PointArray to{from.name, from.type, from.components, {}};
  resize_large(to.bytes, vertices.size() * from.row_bytes());
  const std::size_t row_bytes = from.row_bytes();
  for (std::size_t begin = 0; begin < vertices.size();) {
    std::size_t end = begin + 1;
    while (end < vertices.size() && vertices[end].index() == vertices[end - 1].index() + 1)
      ++end;
    std::memcpy(to.bytes.data() + begin * row_bytes, from.bytes.data() + vertices[begin].index() * row_bytes,
                (end - begin) * row_bytes);
    begin = end;
  }
  return to;
}

} // namespace ptet
