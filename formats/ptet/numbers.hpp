// Numbers as the codec sees them. Every scalar is mapped to an unsigned integer of its own width that sorts like the
// value ("rank"), so that the difference of two ranks is small when the values are near; nothing is lost, not even the
// sign of a zero or the bits of a NaN.
//
//   float32, float64   sign-magnitude to order: negative ones inverted, the others with the top bit set
//   signed integers    top bit inverted
//   unsigned integers  as they are
//
// Arrays whose values are decimal numbers of few significant digits (most text formats leave such arrays) have a
// second, much shorter ranking: of all decimals of s digits. Predictions are doubles; only + - * / are used, so every
// machine predicts the same.
#pragma once

#include "ptet/mesh.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace ptet::file {

[[nodiscard]] unsigned bits_of(ScalarType type);
[[nodiscard]] inline bool is_float(ScalarType type) {
  return type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
}

/// The rank of the scalar stored at `from`, and back.
[[nodiscard]] std::uint64_t load_rank(ScalarType type, const std::byte* from);
void store_rank(ScalarType type, std::uint64_t rank, std::byte* to);
/// The rank of the scalar nearest to `value` (half away from zero for integers, clamped to the type's range; 0 for
/// NaN).
[[nodiscard]] std::uint64_t rank_of(ScalarType type, double value);

/// The decimals of `digits` significant digits: 0, and +-m * 10^e with 10^(digits-1) <= m < 10^digits,
/// -kMaxExponent <= e <= kMaxExponent.
class DecimalRanking {
public:
  static constexpr int kMaxExponent = 22; ///< powers of ten that a double holds exactly

  /// `digits`: 1 to 7 for float32, 1 to 12 for float64.
  DecimalRanking(ScalarType type, unsigned digits);
  [[nodiscard]] static unsigned max_digits(ScalarType type) { return type == ScalarType::kFloat32 ? 7 : 12; }

  /// Number of bits that hold any difference of two ranks.
  [[nodiscard]] unsigned bits() const;
  /// The decimal rank of the nearest decimal to `value`; of the last one beyond the range, 0 for NaN.
  [[nodiscard]] std::int64_t nearest(double value) const;
  /// The value rank of a decimal rank. No value when the decimal rank is out of range.
  [[nodiscard]] std::optional<std::uint64_t> value_rank(std::int64_t decimal) const;
  /// The decimal rank of the scalar of this value rank, if it is exactly the one that value_rank() gives back.
  [[nodiscard]] std::optional<std::int64_t> exact(std::uint64_t value_rank) const;

private:
  ScalarType type_;
  std::int64_t first_;  ///< 10^(digits-1), the least mantissa
  std::int64_t decade_; ///< decimals of one sign and exponent
};

/// The least number of significant digits that represents at least 98% of a component's values exactly; 0 when none
/// does or fewer than 16 values are given.
[[nodiscard]] unsigned find_decimal_digits(const PointArray& array, std::uint32_t component);

} // namespace ptet::file
