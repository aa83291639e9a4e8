// Errors on disk: 16-bit codes on a logarithmic scale, always rounded up, so that coding never makes an error smaller.
//
//   code 0             exactly 0
//   code c in 1..2047  scale * 2^((c - 1280) / 16)        16 codes an octave: a stated error is at most 4.5% above
//
// Squared errors have a sign, and codes of the same step in the error itself:
//
//   code c in 1..2047  2^((c - 1600) / 8), code -c the same below 0, code 0 exactly 0
#pragma once

#include <cstdint>

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
/// The value that a code stands for; grows with `code`, the same on every machine.
[[nodiscard]] double decode_squared_error(SquaredErrorCode code);

} // namespace ptet
