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
  // 2^(k/8), k = 0..7, to the nearest double: written out because std::exp2 may differ from machine to machine.
  constexpr std::array<double, 8> kFraction = {0x1.0000000000000p+0, 0x1.172b83c7d517bp+0, 0x1.306fe0a31b715p+0,
                                               0x1.4bfdad5362a27p+0, 0x1.6a09e667f3bcdp+0, 0x1.8ace5422aa0dbp+0,
                                               0x1.ae89f995ad3adp+0, 0x1.d5818dcfba487p+0};
  constexpr unsigned kLeastExponent = 1023 - 200; // as a double has it
  const auto step = static_cast<unsigned>(std::min(std::abs(int{code}), int{kMaxSquaredErrorCode}));
  const auto power_of_two = std::bit_cast<double>(std::uint64_t{kLeastExponent + step / 8} << 52U);
  return step == 0 ? 0 : std::copysign(kFraction[step % 8] * power_of_two, code);
}

/// The code of the whole volume, and the greatest there is, where there are `records` records.
[[nodiscard]] int uncovered_code_of_all(std::uint32_t records);
[[nodiscard]] int greatest_uncovered_code(std::uint32_t records);
/// As for squared errors.
[[nodiscard]] SquaredErrorCode encode_uncovered(double fraction, std::uint32_t records);
[[nodiscard]] double decode_uncovered(SquaredErrorCode code, std::uint32_t records);

} // namespace ptet
