// Numbers as captions, sliders and the legend show them.
#pragma once

#include <string>

namespace ptet::view {

/// In three significant digits.
[[nodiscard]] std::string brief(double number);
/// So many significant digits tell numbers up to `magnitude` apart that differ by a hundredth of `range`: 4 to 15. An
/// absolute pressure varies by little beside what it is. `range` that is not > 0: 7.
[[nodiscard]] int digits_within(double range, double magnitude);
/// In digits_within(range, |number|).
[[nodiscard]] std::string brief_within(double range, double number);

} // namespace ptet::view
