#include "record/error_code.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace ptet {
namespace {

constexpr unsigned kCodesPerOctave = 16;
// Code 0 of the scale 2^((c - 1280) / 16) stands at 2^-80.
constexpr int kFirstExponent = -80;
constexpr unsigned kSquaredCodesPerOctave = 8;
constexpr int kFirstSquaredExponent = -200;

// 2^(k/16), k = 0..15, to the nearest double: written out because std::exp2 may differ from machine to machine.
constexpr std::array<double, kCodesPerOctave> kFraction = {
    0x1.0000000000000p+0, 0x1.0b5586cf9890fp+0, 0x1.172b83c7d517bp+0, 0x1.2387a6e756238p+0,
    0x1.306fe0a31b715p+0, 0x1.3dea64c123422p+0, 0x1.4bfdad5362a27p+0, 0x1.5ab07dd485429p+0,
    0x1.6a09e667f3bcdp+0, 0x1.7a11473eb0187p+0, 0x1.8ace5422aa0dbp+0, 0x1.9c49182a3f090p+0,
    0x1.ae89f995ad3adp+0, 0x1.c199bdd85529cp+0, 0x1.d5818dcfba487p+0, 0x1.ea4afa2a490dap+0};

double power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}

} // namespace

double decode_error(ErrorCode16 code, double scale) {
  if (code == 0) return 0;
  const unsigned step = std::min(code, kMaxErrorCode);
  // The factor is exact, so there is one rounding, and the value grows with the code.
  const double factor =
      kFraction[step % kCodesPerOctave] * power_of_two(kFirstExponent + static_cast<int>(step / kCodesPerOctave));
  return scale * factor;
}

double decode_squared_error(SquaredErrorCode code) {
  if (code < 0) return -decode_squared_error(static_cast<SquaredErrorCode>(-code));
  if (code == 0) return 0;
  const unsigned step = static_cast<unsigned>(std::min(code, kMaxSquaredErrorCode));
  return kFraction[step % kSquaredCodesPerOctave * (kCodesPerOctave / kSquaredCodesPerOctave)] *
         power_of_two(kFirstSquaredExponent + static_cast<int>(step / kSquaredCodesPerOctave));
}

SquaredErrorCode encode_squared_error(double fraction) {
  int least = -kMaxSquaredErrorCode, most = kMaxSquaredErrorCode;
  while (least < most) {
    const int middle = least + (most - least) / 2;
    if (decode_squared_error(static_cast<SquaredErrorCode>(middle)) >= fraction)
      most = middle;
    else
      least = middle + 1;
  }
  return static_cast<SquaredErrorCode>(least);
}

ErrorCode16 encode_error(double error, double scale) {
  ErrorCode16 least = 0, most = kMaxErrorCode;
  while (least < most) {
    const auto middle = static_cast<ErrorCode16>((least + most) / 2);
    if (decode_error(middle, scale) >= error)
      most = middle;
    else
      least = static_cast<ErrorCode16>(middle + 1);
  }
  return least;
}

} // namespace ptet
