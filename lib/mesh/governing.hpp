// Which point arrays govern a build, and which can: errors of the others are not measured.
#pragma once

#include "ptet/mesh.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ptet {

/// The indices of those that govern where none are named: the floating-point ones; all, where there are none.
[[nodiscard]] std::vector<std::uint32_t> governing_by_default(const std::vector<PointArray>& arrays);

/// Largest minus least value, of a vector the diagonal of the box of its values. Infinite where that passes a double,
/// or where doubles do not tell integers that far apart: errors of such an array are not measured. `used`: one a row, 1
/// where it counts; values that are not finite do not.
[[nodiscard]] double range_of(const PointArray& array, const std::vector<char>& used);

/// Why the range of these values seems to be that of a fill value (-999 on land, 1e20) and not of the field, in words
/// for the user; nothing where it does not. `values`: finite ones of one component, which are reordered.
[[nodiscard]] std::optional<std::string> odd_range(std::vector<double>& values);
/// A note on the field that has them. `odd`: of odd_range().
[[nodiscard]] std::string fill_values_note(const std::string& name, const std::string& odd);

} // namespace ptet
