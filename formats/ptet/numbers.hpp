// Numbers as the codec sees them. Every scalar is mapped to an unsigned integer of its own width that sorts like the
// value ("rank"), so that the difference of two ranks is small when the values are near; nothing is lost, not even the
// sign of a zero or the bits of a NaN.
//
//   float32, float64   sign-magnitude to order: negative ones inverted, the others with the top bit set
//   signed integers    top bit inverted
//   unsigned integers  as they are
//
// Arrays whose values are decimal numbers of few significant digits (most text formats leave such arrays) have a
// second, much shorter ranking: of all decimals of s digits. So have floats the lowest bits of which are 0, as those of
// doubles that were made of floats: without these bits. Predictions are doubles; only + - * / are used, so every
// machine predicts the same.
#pragma once

#include "mesh/scalar_dispatch.hpp"
#include "ptet/mesh.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>
#include <vector>

namespace ptet::file {

[[nodiscard]] inline unsigned bits_of(ScalarType type) {
  return static_cast<unsigned>(8 * size_of(type));
}
[[nodiscard]] inline bool is_float(ScalarType type) {
  return type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
}

template <class T>
using Bits = std::conditional_t<sizeof(T) == 1, std::uint8_t,
                                std::conditional_t<sizeof(T) == 2, std::uint16_t,
                                                   std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;

template <class T>
[[nodiscard]] Bits<T> to_rank(T value) {
  constexpr Bits<T> kTop = static_cast<Bits<T>>(Bits<T>{1} << (sizeof(T) * 8 - 1));
  const auto bits = std::bit_cast<Bits<T>>(value);
  if constexpr (std::is_floating_point_v<T>) {
    return (bits & kTop) != 0 ? static_cast<Bits<T>>(~bits) : static_cast<Bits<T>>(bits | kTop);
  } else {
    return std::is_signed_v<T> ? static_cast<Bits<T>>(bits ^ kTop) : bits;
  }
}

template <class T>
[[nodiscard]] T from_rank(Bits<T> rank) {
  constexpr Bits<T> kTop = static_cast<Bits<T>>(Bits<T>{1} << (sizeof(T) * 8 - 1));
  if constexpr (std::is_floating_point_v<T>) {
    return std::bit_cast<T>((rank & kTop) != 0 ? static_cast<Bits<T>>(rank ^ kTop) : static_cast<Bits<T>>(~rank));
  } else {
    return std::bit_cast<T>(std::is_signed_v<T> ? static_cast<Bits<T>>(rank ^ kTop) : rank);
  }
}

template <class T>
[[nodiscard]] T nearest_scalar(double value) {
  if (std::isnan(value)) return T{0};
  if constexpr (std::is_floating_point_v<T>) {
    // A double beyond the range of float is no value of it: clamp first.
    constexpr double kMost = std::numeric_limits<T>::max();
    return static_cast<T>(std::min(std::max(value, -kMost), kMost));
  } else {
    constexpr auto kLeast = static_cast<double>(std::numeric_limits<T>::min());
    // 2^bits or 2^(bits-1), exactly: the least double that is too large.
    constexpr auto kHalf = static_cast<T>(std::numeric_limits<T>::max() / 2 + 1);
    constexpr double kBeyond = 2.0 * static_cast<double>(kHalf);
    const double rounded = value < 0 ? value - 0.5 : value + 0.5;
    if (rounded >= kBeyond) return std::numeric_limits<T>::max();
    if (rounded <= kLeast) return std::numeric_limits<T>::min();
    return static_cast<T>(rounded);
  }
}

/// The rank of the scalar stored at `from`, and back.
[[nodiscard]] inline std::uint64_t load_rank(ScalarType type, const std::byte* from) {
  if (type == ScalarType::kFloat32) return to_rank(load<float>(from)); // the usual one
  return dispatch(type, [&]<class T>(T) -> std::uint64_t { return to_rank(load<T>(from)); });
}
inline void store_rank(ScalarType type, std::uint64_t rank, std::byte* to) {
  if (type == ScalarType::kFloat32) return store(to, from_rank<float>(static_cast<std::uint32_t>(rank)));
  dispatch(type, [&]<class T>(T) { store(to, from_rank<T>(static_cast<Bits<T>>(rank))); });
}
/// The rank of the scalar nearest to `value` (half away from zero for integers, clamped to the type's range; 0 for
/// NaN).
[[nodiscard]] inline std::uint64_t rank_of(ScalarType type, double value) {
  if (type == ScalarType::kFloat32) return to_rank(nearest_scalar<float>(value));
  return dispatch(type, [&]<class T>(T) -> std::uint64_t { return to_rank(nearest_scalar<T>(value)); });
}

/// The decimals of `digits` significant digits: 0, and +-m * 10^e with 10^(digits-1) <= m < 10^digits,
/// -kMaxExponent <= e <= kMaxExponent.
class DecimalRanking {
public:
  static constexpr int kMaxExponent = 22; ///< powers of ten that a double holds exactly

  /// `digits`: 1 to 7 for float32, 1 to 12 for float64.
  DecimalRanking(ScalarType type, unsigned digits);
  [[nodiscard]] static unsigned max_digits(ScalarType type) { return type == ScalarType::kFloat32 ? 7 : 12; }

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
  /// By exponent, from -kMaxExponent: the least magnitude whose mantissa has too many digits.
  std::array<double, 2 * kMaxExponent + 1> beyond_;
};

/// The bits of a float's fraction.
[[nodiscard]] inline unsigned fraction_bits(ScalarType type) {
  return type == ScalarType::kFloat32 ? 23 : 52;
}

/// That of a type and a number of digits, made once. Thread rule: any.
[[nodiscard]] const DecimalRanking& decimal_ranking(ScalarType type, unsigned digits);

/// The value rank of a float without the lowest bits of the fraction, which are 0: those of a rank are then all alike.
[[nodiscard]] inline std::optional<std::uint64_t> without_zeros(ScalarType type, unsigned zero_bits,
                                                                std::uint64_t value_rank) {
  const std::uint64_t low = (std::uint64_t{1} << zero_bits) - 1;
  const bool is_negative = (value_rank >> (bits_of(type) - 1) & 1) == 0;
  if ((value_rank & low) != (is_negative ? low : 0)) return std::nullopt;
  return value_rank >> zero_bits;
}
/// Back.
[[nodiscard]] inline std::uint64_t with_zeros(ScalarType type, unsigned zero_bits, std::uint64_t rank) {
  const bool is_negative = (rank >> (bits_of(type) - 1 - zero_bits) & 1) == 0;
  return rank << zero_bits | (is_negative ? (std::uint64_t{1} << zero_bits) - 1 : 0);
}

/// How exact nearly all values of a component are; at most one of the two is not 0.
struct Precision {
  std::uint8_t decimal_digits = 0; ///< significant ones; 0: no decimal ranking
  std::uint8_t zero_bits = 0;      ///< lowest ones of the fraction, all 0

  /// As it stands in the file.
  [[nodiscard]] std::uint8_t byte() const {
    return zero_bits != 0 ? static_cast<std::uint8_t>(kZeroBits + zero_bits) : decimal_digits;
  }
  /// Nothing where no column of that type has it.
  [[nodiscard]] static std::optional<Precision> of_byte(ScalarType type, std::uint8_t byte);

  friend bool operator==(const Precision&, const Precision&) = default;

private:
  static constexpr std::uint8_t kZeroBits = 64;
};
/// Of each component of a number table.
using Precisions = std::vector<Precision>;

/// The one that takes the fewest bits and has at least 98% of a component's values exactly; none when there is none or
/// fewer than 16 values are given.
[[nodiscard]] Precision find_precision(const PointArray& array, std::uint32_t component);

} // namespace ptet::file
