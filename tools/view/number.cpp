#include "number.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace ptet::view {
namespace {

std::string in_digits(double number, int digits) {
  std::array<char, 40> text{};
  (void)std::snprintf(text.data(), text.size(), "%.*g", digits, number);
  return text.data();
}

} // namespace

std::string brief(double number) {
  return in_digits(number, 3);
}

int digits_within(double range, double magnitude) {
  constexpr int kLeast = 4, kMost = 15;
  if (!(range > 0)) return 7;
  const double more = std::floor(std::log10(magnitude / range));
  return more > 0 ? static_cast<int>(std::min<double>(kLeast + more, kMost)) : kLeast;
}

std::string brief_within(double range, double number) {
  return in_digits(number, digits_within(range, std::fabs(number)));
}

} // namespace ptet::view
