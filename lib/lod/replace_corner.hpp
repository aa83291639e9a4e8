// One vertex of a cell for another.
#pragma once

#include <array>
#include <cstddef>

namespace ptet {

/// std::replace without a branch for each corner: which of them it is cannot be foreseen.
template <class Vertex, std::size_t Corners>
void replace_corner(std::array<Vertex, Corners>& cell, Vertex from, Vertex to) {
  std::array<Vertex, Corners> changed = cell;
  for (Vertex& corner : changed)
    corner = corner == from ? to : corner;
  cell = changed;
}

} // namespace ptet
