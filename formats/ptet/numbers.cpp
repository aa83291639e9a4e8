#include "formats/ptet/numbers.hpp"

#include <algorithm>
#include <bit>

namespace ptet::file {
namespace {

constexpr std::array<double, DecimalRanking::kMaxExponent + 1> kPowerOfTen = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

double scale_by_ten(double mantissa, int exponent) {
  return exponent < 0 ? mantissa / kPowerOfTen[static_cast<std::size_t>(-exponent)]
                      : mantissa * kPowerOfTen[static_cast<std::size_t>(exponent)];
}

constexpr int kExponents = 2 * DecimalRanking::kMaxExponent + 1;

} // namespace

DecimalRanking::DecimalRanking(ScalarType type, unsigned digits)
    : type_(type), first_(static_cast<std::int64_t>(kPowerOfTen[digits - 1])), decade_(9 * first_) {
  for (int exponent = -kMaxExponent; exponent <= kMaxExponent; ++exponent)
    beyond_[static_cast<std::size_t>(exponent + kMaxExponent)] = scale_by_ten(kPowerOfTen[digits], exponent);
}

const DecimalRanking& decimal_ranking(ScalarType type, unsigned digits) {
  const auto all_of = [](ScalarType of) {
    std::vector<DecimalRanking> rankings;
    for (unsigned s = 1; s <= DecimalRanking::max_digits(of); ++s)
      rankings.emplace_back(of, s);
    return rankings;
  };
  static const std::vector<DecimalRanking> kOfFloat = all_of(ScalarType::kFloat32);
  static const std::vector<DecimalRanking> kOfDouble = all_of(ScalarType::kFloat64);
  return (type == ScalarType::kFloat32 ? kOfFloat : kOfDouble)[digits - 1];
}

std::int64_t DecimalRanking::nearest(double value) const {
  const double magnitude = value < 0 ? -value : value;
  const auto first = static_cast<double>(first_);
  // Half the least decimal and all below is zero (and so is NaN).
  if (!(magnitude >= scale_by_ten(first, -kMaxExponent) / 2)) return 0;
  // The least exponent at which the mantissa has not too many digits: the power of two is within a step of telling it.
  const int octave = static_cast<int>(std::bit_cast<std::uint64_t>(magnitude / beyond_[kMaxExponent]) >> 52) - 1023;
  int place = std::clamp((octave * 1233 >> 12) + 1 + kMaxExponent, 0, kExponents - 1); // 1233 / 4096: log10(2)
  while (place > 0 && magnitude < beyond_[static_cast<std::size_t>(place - 1)])
    --place;
  while (place + 1 < kExponents && !(magnitude < beyond_[static_cast<std::size_t>(place)]))
    ++place;
  const int exponent = place - kMaxExponent;
  const double scaled = exponent < 0 ? magnitude * kPowerOfTen[static_cast<std::size_t>(-exponent)]
                                     : magnitude / kPowerOfTen[static_cast<std::size_t>(exponent)];
  const auto mantissa = static_cast<std::int64_t>(std::min(std::max(scaled + 0.5, first), 10 * first));
  std::int64_t rank = place * decade_ + (mantissa - first_) + 1;
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

std::optional<Precision> Precision::of_byte(ScalarType type, std::uint8_t byte) {
  if (byte == 0) return Precision{};
  if (!is_float(type)) return std::nullopt;
  if (byte <= DecimalRanking::max_digits(type)) return Precision{byte, 0};
  if (byte <= kZeroBits || byte > kZeroBits + fraction_bits(type)) return std::nullopt;
  return Precision{0, static_cast<std::uint8_t>(byte - kZeroBits)};
}

namespace {

/// Whether all but a few of a component's values have what the test, which gets their ranks, finds.
template <class Test>
bool nearly_all(const PointArray& array, std::uint32_t component, const Test& test) {
  const std::byte* at = array.bytes.data() + component * size_of(array.type);
  std::size_t failed = 0;
  const std::size_t allowed = array.size() / 50;
  for (std::size_t row = 0; row < array.size() && failed <= allowed; ++row, at += array.row_bytes())
    failed += test(load_rank(array.type, at)).has_value() ? 0 : 1;
  return failed <= allowed;
}

} // namespace

Precision find_precision(const PointArray& array, std::uint32_t component) {
  constexpr std::size_t kLeastValues = 16;
  constexpr double kBitsPerDigit = 3.3219;
  if (!is_float(array.type) || array.size() < kLeastValues) return {};
  unsigned zeros = fraction_bits(array.type);
  while (zeros > 0 &&
         !nearly_all(array, component, [&](std::uint64_t r) { return without_zeros(array.type, zeros, r); }))
    --zeros;
  const unsigned bits = fraction_bits(array.type) + 1 - zeros;
  for (unsigned digits = 1; digits <= DecimalRanking::max_digits(array.type); ++digits) {
    if (zeros > 0 && kBitsPerDigit * digits > bits) break;
    const DecimalRanking& ranking = decimal_ranking(array.type, digits);
    if (nearly_all(array, component, [&](std::uint64_t r) { return ranking.exact(r); }))
      return {static_cast<std::uint8_t>(digits), 0};
  }
  return {0, static_cast<std::uint8_t>(zeros)};
}

} // namespace ptet::file
