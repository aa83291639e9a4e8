#include "formats/ptet/numbers.hpp"

#include "mesh/scalar_dispatch.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <type_traits>

namespace ptet::file {
namespace {

template <class T>
using Bits = std::conditional_t<sizeof(T) == 1, std::uint8_t,
                                std::conditional_t<sizeof(T) == 2, std::uint16_t,
                                                   std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;

template <class T>
Bits<T> to_rank(T value) {
  constexpr Bits<T> kTop = static_cast<Bits<T>>(Bits<T>{1} << (sizeof(T) * 8 - 1));
  const auto bits = std::bit_cast<Bits<T>>(value);
  if constexpr (std::is_floating_point_v<T>) {
    return (bits & kTop) != 0 ? static_cast<Bits<T>>(~bits) : static_cast<Bits<T>>(bits | kTop);
  } else {
    return std::is_signed_v<T> ? static_cast<Bits<T>>(bits ^ kTop) : bits;
  }
}

template <class T>
T from_rank(Bits<T> rank) {
  constexpr Bits<T> kTop = static_cast<Bits<T>>(Bits<T>{1} << (sizeof(T) * 8 - 1));
  if constexpr (std::is_floating_point_v<T>) {
    return std::bit_cast<T>((rank & kTop) != 0 ? static_cast<Bits<T>>(rank ^ kTop) : static_cast<Bits<T>>(~rank));
  } else {
    return std::bit_cast<T>(std::is_signed_v<T> ? static_cast<Bits<T>>(rank ^ kTop) : rank);
  }
}

template <class T>
T nearest_scalar(double value) {
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

constexpr std::array<double, DecimalRanking::kMaxExponent + 1> kPowerOfTen = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

double scale_by_ten(double mantissa, int exponent) {
  return exponent < 0 ? mantissa / kPowerOfTen[static_cast<std::size_t>(-exponent)]
                      : mantissa * kPowerOfTen[static_cast<std::size_t>(exponent)];
}

constexpr int kExponents = 2 * DecimalRanking::kMaxExponent + 1;

} // namespace

unsigned bits_of(ScalarType type) {
  return static_cast<unsigned>(8 * size_of(type));
}

std::uint64_t load_rank(ScalarType type, const std::byte* from) {
  return dispatch(type, [&]<class T>(T) -> std::uint64_t { return to_rank(load<T>(from)); });
}

void store_rank(ScalarType type, std::uint64_t rank, std::byte* to) {
  dispatch(type, [&]<class T>(T) { store(to, from_rank<T>(static_cast<Bits<T>>(rank))); });
}

std::uint64_t rank_of(ScalarType type, double value) {
  return dispatch(type, [&]<class T>(T) -> std::uint64_t { return to_rank(nearest_scalar<T>(value)); });
}

DecimalRanking::DecimalRanking(ScalarType type, unsigned digits)
    : type_(type), first_(static_cast<std::int64_t>(kPowerOfTen[digits - 1])), decade_(9 * first_) {}

unsigned DecimalRanking::bits() const {
  return static_cast<unsigned>(std::bit_width(static_cast<std::uint64_t>(2 * kExponents * decade_))) + 1;
}

std::int64_t DecimalRanking::nearest(double value) const {
  const double magnitude = value < 0 ? -value : value;
  const auto first = static_cast<double>(first_);
  // Half the least decimal and all below is zero (and so is NaN).
  if (!(magnitude >= scale_by_ten(first, -kMaxExponent) / 2)) return 0;
  // The least exponent at which the mantissa has not too many digits.
  int low = -kMaxExponent, high = kMaxExponent;
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (magnitude < scale_by_ten(10 * first, middle)) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  const double scaled = low < 0 ? magnitude * kPowerOfTen[static_cast<std::size_t>(-low)]
                                : magnitude / kPowerOfTen[static_cast<std::size_t>(low)];
  const double mantissa = std::min(std::max(std::floor(scaled + 0.5), first), 10 * first);
  std::int64_t rank = (low + kMaxExponent) * decade_ + (static_cast<std::int64_t>(mantissa) - first_) + 1;
  rank = std::min(rank, kExponents * decade_);
  return value < 0 ? -rank : rank;
}

std::optional<std::uint64_t> DecimalRanking::value_rank(std::int64_t decimal) const {
  if (decimal < -kExponents * decade_ || decimal > kExponents * decade_) return std::nullopt;
  const std::int64_t magnitude = decimal < 0 ? -decimal : decimal;
  double value = 0;
  if (magnitude != 0) {
    const int exponent = static_cast<int>((magnitude - 1) / decade_) - kMaxExponent;
    value = scale_by_ten(static_cast<double>(first_ + (magnitude - 1) % decade_), exponent);
  }
  return rank_of(type_, decimal < 0 ? -value : value);
}

std::optional<std::int64_t> DecimalRanking::exact(std::uint64_t wanted) const {
  std::array<std::byte, 8> scalar{};
  store_rank(type_, wanted, scalar.data());
  const double value = type_ == ScalarType::kFloat32 ? load<float>(scalar.data()) : load<double>(scalar.data());
  const std::int64_t decimal = nearest(value);
  if (value_rank(decimal) != wanted) return std::nullopt;
  return decimal;
}

unsigned find_decimal_digits(const PointArray& array, std::uint32_t component) {
  constexpr std::size_t kLeastValues = 16;
  if (!is_float(array.type) || array.size() < kLeastValues) return 0;
  for (unsigned digits = 1; digits <= DecimalRanking::max_digits(array.type); ++digits) {
    const DecimalRanking ranking(array.type, digits);
    std::size_t missed = 0;
    const std::size_t allowed = array.size() / 50;
    for (std::size_t row = 0; row < array.size() && missed <= allowed; ++row) {
      const std::byte* at = array.bytes.data() + row * array.row_bytes() + component * size_of(array.type);
      missed += ranking.exact(load_rank(array.type, at)).has_value() ? 0 : 1;
    }
    if (missed <= allowed) return digits;
  }
  return 0;
}

} // namespace ptet::file
