// Values as doubles, also those of 64-bit integers, of which a double holds the first 2^53 only: the value at one
// vertex is taken off, in integers, before the conversion. Differences of a field's values do not depend on it.
#pragma once

#include "mesh/scalar_dispatch.hpp"
#include "ptet/mesh.hpp"

#include <cstdint>
#include <type_traits>
#include <utility>

namespace ptet {

/// Integers from here on need not be doubles.
inline constexpr double kExactIntegers = 0x1p53;

template <class T>
inline constexpr bool kIsWideInteger = std::is_integral_v<T> && sizeof(T) == 8;

[[nodiscard]] inline bool has_wide_integers(const PointArray& array) {
  return array.type == ScalarType::kInt64 || array.type == ScalarType::kUInt64;
}

/// Whether differences of a component's values may pass what doubles tell apart; `span`: the greatest of them.
[[nodiscard]] inline bool spans_too_far(const PointArray& array, double span) {
  return has_wide_integers(array) && span >= kExactIntegers;
}

/// What is taken off one component of a field: of 64-bit integers the value in one row, of all others nothing.
class ValueOffset {
public:
  /// `array` has that row.
  ValueOffset(const PointArray& array, std::size_t row, std::uint32_t component) {
    dispatch(array.type, [&]<class T>(T) {
      if constexpr (kIsWideInteger<T>) {
        const T value = load<T>(array.bytes.data() + (row * array.components + component) * sizeof(T));
        is_negative_ = std::cmp_less(value, 0);
        bits_ = static_cast<std::uint64_t>(value);
      }
    });
  }

  /// Of the same array, or of one that is to be compared with it. Exact while the result is below kExactIntegers.
  [[nodiscard]] double value(const PointArray& array, std::size_t row, std::uint32_t component) const {
    return dispatch(array.type, [&]<class T>(T) {
      const T value = load<T>(array.bytes.data() + (row * array.components + component) * sizeof(T));
      if constexpr (kIsWideInteger<T>) {
        return is_negative_ ? difference(value, static_cast<std::int64_t>(bits_)) : difference(value, bits_);
      } else {
        return static_cast<double>(value) -
               (is_negative_ ? static_cast<double>(static_cast<std::int64_t>(bits_)) : static_cast<double>(bits_));
      }
    });
  }

private:
  /// Of one sign the subtraction is right modulo 2^64. Of two, each number is smaller than the difference: where that
  /// is below kExactIntegers a double tells both.
  template <class A, class B>
  static double difference(A a, B b) {
    if (std::cmp_less(a, 0) != std::cmp_less(b, 0)) return static_cast<double>(a) - static_cast<double>(b);
    const auto first = static_cast<std::uint64_t>(a);
    const auto second = static_cast<std::uint64_t>(b);
    return std::cmp_less(a, b) ? -static_cast<double>(second - first) : static_cast<double>(first - second);
  }

  bool is_negative_ = false;
  std::uint64_t bits_ = 0;
};

} // namespace ptet
