// The values of a field's components as the measures of errors see them.
#pragma once

#include "ptet/mesh.hpp"

#include <cstdint>

namespace ptet {

/// Writes component `component` of the first `vertices` rows of `array` to out[0], out[stride], ..., as fractions of
/// `range` (> 0). Where they are far from 0 against their spread, such as pressures that differ in the sixth digit,
/// they count from the least of them: errors are differences, and those of numbers near 0 keep their digits. The values
/// must be finite.
void write_channel(const PointArray& array, std::uint32_t component, std::uint32_t vertices, double range, double* out,
                   std::size_t stride);

} // namespace ptet
