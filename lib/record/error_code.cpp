#include "record/error_code.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace ptet {
namespace {

// Code 0 of the scale 2^((c - 1280) / 16) stands at 2^-80.
constexpr int kFirstExponent = -80;
constexpr int kSquaredCodeOfOne = -kFirstSquaredExponent * static_cast<int>(kSquaredCodesPerOctave);
/// From the least uncovered volume to that which as many records as there may be would make the whole of: 2^8.
constexpr int kUncoveredCodesBelow = 8 * static_cast<int>(kSquaredCodesPerOctave);

/// The least code from -greatest to `greatest` that is enough; the greatest if none is.
template <class IsEnough>
SquaredErrorCode least_code(int greatest, IsEnough&& is_enough) {
  int least = -greatest, most = greatest;
  while (least < most) {
    const int middle = least + (most - least) / 2;
    if (is_enough(static_cast<SquaredErrorCode>(middle)))
      most = middle;
    else
      least = middle + 1;
  }
  return static_cast<SquaredErrorCode>(least);
}

} // namespace

double decode_error(ErrorCode16 code, double scale) {
  if (code == 0) return 0;
  const unsigned step = std::min(code, kMaxErrorCode);
  // The factor is exact, so there is one rounding, and the value grows with the code.
  const double factor =
      kStepOfOctave[step % kCodesPerOctave] * two_to_the(kFirstExponent + static_cast<int>(step / kCodesPerOctave));
  return scale * factor;
}

SquaredErrorCode encode_squared_error(double fraction) {
  return least_code(kMaxSquaredErrorCode,
                    [&](SquaredErrorCode code) { return decode_squared_error(code) >= fraction; });
}

int uncovered_code_of_all(std::uint32_t records) {
  return kUncoveredCodesBelow + static_cast<int>(kSquaredCodesPerOctave) * std::bit_width(records) + 1;
}

int greatest_uncovered_code(std::uint32_t records) {
  return uncovered_code_of_all(records) + kMaxSquaredErrorCode - kSquaredCodeOfOne;
}

double decode_uncovered(SquaredErrorCode code, std::uint32_t records) {
  const int shift = kSquaredCodeOfOne - uncovered_code_of_all(records);
  return decode_squared_error(static_cast<SquaredErrorCode>(code == 0 ? 0 : code > 0 ? code + shift : code - shift));
}

SquaredErrorCode encode_uncovered(double fraction, std::uint32_t records) {
  return least_code(greatest_uncovered_code(records),
                    [&](SquaredErrorCode code) { return decode_uncovered(code, records) >= fraction; });
}

ErrorCode16 encode_error(double error, double scale) {
  ErrorCode16 least = 0, most = kMaxErrorCode;
  // The octave is told by the exponents, up to one.
  if (const double fraction = error / scale; fraction > 0 && std::isfinite(fraction)) {
    const int octave = std::ilogb(fraction) - kFirstExponent;
    const auto code_at = [](int steps, int least_code) {
      return static_cast<ErrorCode16>(
          std::clamp(steps * static_cast<int>(kCodesPerOctave), least_code, int{kMaxErrorCode}));
    };
    least = code_at(octave - 1, 0);
    most = code_at(octave + 2, 1);
  }
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
