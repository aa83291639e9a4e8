// Which point arrays govern a build, and which can: errors of the others are not measured.
#pragma once

#include "ptet/mesh.hpp"

#include <cstdint>
#include <vector>

namespace ptet {

/// The indices of those that govern where none are named: the floating-point ones; all, where there are none.
[[nodiscard]] std::vector<std::uint32_t> governing_by_default(const std::vector<PointArray>& arrays);

/// Largest minus least value, of a vector the diagonal of the box of its values. Infinite where that passes a double,
/// or where doubles do not tell integers that far apart: errors of such an array are not measured. `used`: one a row, 1
/// where it counts; values that are not finite do not.
[[nodiscard]] double range_of(const PointArray& array, const std::vector<char>& used);

} // namespace ptet
