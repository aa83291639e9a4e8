#pragma once

#include <cmath>

namespace ptet {

/// The greatest power of two that is at most `x`, which is > 0 and finite. Dividing by it loses no digit, but where the
/// quotient is subnormal or beyond the doubles.
inline double power_of_two_below(double x) {
  return std::ldexp(1.0, std::ilogb(x));
}

} // namespace ptet
