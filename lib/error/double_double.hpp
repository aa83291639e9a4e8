// Numbers of twice a double's digits, some 31 decimal ones: the unevaluated sum of two doubles.
//
//     high  |1.xxxxxxxx|            what is left of a sum or a product of doubles is a double itself, so nothing is
//     low             |x.xxxxxxx|   lost of one; longer computations are off by some 2^-102 of their terms
//
// Source: Dekker, A floating-point technique for extending the available precision, 1971; Knuth, The Art of Computer
// Programming, volume 2, 4.2.2 (the sum).
#pragma once

#include <array>
#include <cmath>
#include <compare>
#include <cstddef>

namespace ptet {

struct DoubleDouble {
  double high = 0;
  double low = 0;

  DoubleDouble() = default;
  DoubleDouble(double x) : high(x) {} // NOLINT(google-explicit-constructor)
  DoubleDouble(double h, double l) : high(h), low(l) {}
  [[nodiscard]] double rounded() const { return high + low; }
  explicit operator double() const { return rounded(); }
};

/// Exact.
[[nodiscard]] inline DoubleDouble sum_of(double a, double b) {
  const double sum = a + b;
  const double of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}
[[nodiscard]] inline DoubleDouble difference_of(double a, double b) {
  return sum_of(a, -b);
}
/// Exact unless it underflows.
[[nodiscard]] inline DoubleDouble product_of(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

[[nodiscard]] inline DoubleDouble operator-(const DoubleDouble& a) {
  return {-a.high, -a.low};
}
[[nodiscard]] inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble high = sum_of(a.high, b.high);
  const DoubleDouble low = sum_of(a.low, b.low);
  const DoubleDouble sum = sum_of(high.high, high.low + low.high);
  return sum_of(sum.high, sum.low + low.low);
}
[[nodiscard]] inline DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) {
  return a + (-b);
}
[[nodiscard]] inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble product = product_of(a.high, b.high);
  return sum_of(product.high, product.low + (a.high * b.low + a.low * b.high));
}
[[nodiscard]] inline DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b) {
  const double first = a.high / b.high;
  const DoubleDouble rest = a - b * DoubleDouble(first);
  const double second = rest.high / b.high;
  const double third = (rest - b * DoubleDouble(second)).high / b.high;
  return sum_of(first, second) + DoubleDouble(third);
}

inline DoubleDouble& operator+=(DoubleDouble& a, const DoubleDouble& b) {
  return a = a + b;
}
inline DoubleDouble& operator/=(DoubleDouble& a, const DoubleDouble& b) {
  return a = a / b;
}

// Of those that the operations above make: their low part is less than half a unit of the high one's last place.
[[nodiscard]] inline bool operator==(const DoubleDouble& a, const DoubleDouble& b) {
  return a.high == b.high && a.low == b.low;
}
[[nodiscard]] inline std::partial_ordering operator<=>(const DoubleDouble& a, const DoubleDouble& b) {
  return a.high != b.high ? a.high <=> b.high : a.low <=> b.low;
}

using FineVec3 = std::array<DoubleDouble, 3>;

[[nodiscard]] inline FineVec3 fine_difference(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return {difference_of(a[0], b[0]), difference_of(a[1], b[1]), difference_of(a[2], b[2])};
}
[[nodiscard]] inline DoubleDouble dot(const FineVec3& a, const FineVec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
[[nodiscard]] inline FineVec3 cross(const FineVec3& a, const FineVec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
[[nodiscard]] inline FineVec3 operator*(const DoubleDouble& s, const FineVec3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}

} // namespace ptet
