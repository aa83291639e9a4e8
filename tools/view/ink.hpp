// What text, lines and handles are drawn with.
#pragma once

#include <array>

namespace ptet::view {

inline constexpr std::array<double, 3> kInk = {0.13, 0.14, 0.16};
inline constexpr std::array<double, 3> kGrey = {0.62, 0.64, 0.68};
inline constexpr std::array<double, 3> kAccent = {0.00, 0.38, 0.75};

} // namespace ptet::view
