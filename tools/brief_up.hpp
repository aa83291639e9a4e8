// A bound as people read it: never below it.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace ptet {

/// The least number of `digits` significant digits that is not below `bound`, but for what rounding may have added to
/// it (1e-12 of it). As printf's %g writes it. `bound` >= 0; `digits`: 1 to 15.
[[nodiscard]] inline std::string brief_up(double bound, int digits = 4) {
  char text[40];
  const auto write = [&](const char* format, double number, int precision) {
    std::snprintf(text, sizeof text, format, precision, number);
    return std::strtod(text, nullptr);
  };
  const double nearest = write("%.*e", bound, digits - 1);
  double up = nearest;
  if (std::isfinite(bound) && nearest < bound * (1 - 1e-12)) {
    const std::string scientific = text; // its last digit counts 10^(exponent - digits + 1)
    const int exponent = std::atoi(scientific.c_str() + scientific.find('e') + 1);
    up = nearest + std::pow(10.0, exponent - digits + 1);
  }
  write("%.*g", up, digits);
  return text;
}

} // namespace ptet
