// Errors on disk: 16-bit codes on a logarithmic scale, always rounded up, so that coding never makes an error smaller.
//
//   code 0             exactly 0
//   code c in 1..2047  scale * 2^((c - 1280) / 16)        16 codes an octave: a stated error is at most 4.5% above
//
// Squared errors have a sign, and codes of the same step in the error itself:
//
//   code c in 1..2047  2^((c - 1600) / 8), code -c the same below 0, code 0 exactly 0
//
// What records uncover of the volume, too, in steps that begin at a part of it that is small by their number:
//
//   code c in 1..512 + 8 b  2^((c - 65) / 8 - b), code -c the same below 0, code 0 exactly 0; b bits say the number of
//                           records: rounded up to code 1 all together come to no more than 2^-8
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace ptet {

inline constexpr unsigned kCodesPerOctave = 16, kSquaredCodesPerOctave = 8;
inline constexpr int kFirstSquaredExponent = -200;
/// 2^(k/16), k = 0..15, to the nearest double: written out because std::exp2 may differ from machine to machine.
inline constexpr std::array<double, kCodesPerOctave> kStepOfOctave = {
    0x1.0000000000000p+0, 0x1.0b5586cf9890fp+0, 0x1.172b83c7d517bp+0, 0x1.2387a6e756238p+0,
    0x1.306fe0a31b715p+0, 0x1.3dea64c123422p+0, 0x1.4bfdad5362a27p+0, 0x1.5ab07dd485429p+0,
    0x1.6a09e667f3bcdp+0, 0x1.7a11473eb0187p+0, 0x1.8ace5422aa0dbp+0, 0x1.9c49182a3f090p+0,
    0x1.ae89f995ad3adp+0, 0x1.c199bdd85529cp+0, 0x1.d5818dcfba487p+0, 0x1.ea4afa2a490dap+0};
/// A normal double.
[[nodiscard]] inline double two_to_the(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52U);
}

using ErrorCode16 = std::uint16_t;
inline constexpr ErrorCode16 kMaxErrorCode = 2047;

/// The least code whose value is >= `error`. `error` >= 0 and not NaN; scale > 0. Saturates at kMaxErrorCode, whose
/// value (2^47 scales) no error of a valid mesh reaches.
[[nodiscard]] ErrorCode16 encode_error(double error, double scale);
/// The error that a code stands for; monotone in `code`. Computed from table and power of two, the same on every
/// machine.
[[nodiscard]] double decode_error(ErrorCode16 code, double scale);

using SquaredErrorCode = std::int16_t;
inline constexpr SquaredErrorCode kMaxSquaredErrorCode = 2047;

/// The least code whose value is >= `fraction`, not NaN. Saturates at both ends: the greatest value is 2^55.9.
[[nodiscard]] SquaredErrorCode encode_squared_error(double fraction);
/// The value that a code stands for; grows with `code`, the same on every machine. Summed up by the thousand.
[[nodiscard]] inline double decode_squared_error(SquaredErrorCode code) {
  const auto step = static_cast<unsigned>(std::min(std::abs(int{code}), int{kMaxSquaredErrorCode}));
  const double value = kStepOfOctave[step % kSquaredCodesPerOctave * (kCodesPerOctave / kSquaredCodesPerOctave)] *
                       two_to_the(kFirstSquaredExponent + static_cast<int>(step / kSquaredCodesPerOctave));
  return step == 0 ? 0 : std::copysign(value, code);
}

/// The code of the whole volume, and the greatest there is, where there are `records` records.
[[nodiscard]] int uncovered_code_of_all(std::uint32_t records);
[[nodiscard]] int greatest_uncovered_code(std::uint32_t records);
/// As for squared errors.
[[nodiscard]] SquaredErrorCode encode_uncovered(double fraction, std::uint32_t records);
[[nodiscard]] double decode_uncovered(SquaredErrorCode code, std::uint32_t records);

} // namespace ptet
