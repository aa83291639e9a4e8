// Which point arrays govern a build, and which can: errors of the others are not measured.
#pragma once

#include "ptet/mesh.hpp"

#include <cstdint>
#include <vector>

namespace ptet {

/// The indices of those that govern where none are named: the floating-point ones; all, where there are none.
[[nodiscard]] std::vector<std::uint32_t> governing_by_default(const std::vector<PointArray>& arrays);

/// Whether doubles hold the range of the array, the diagonal of the box of its values, and tell its values apart.
/// `used`: one a row, whether it counts; values that are not finite do not.
[[nodiscard]] bool has_measurable_range(const PointArray& array, const std::vector<char>& used);

} // namespace ptet
