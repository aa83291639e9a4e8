#include "record/error_code.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace ptet;

TEST_CASE("error codes: zero is exact, every value is rounded up, by at most 4.5%") {
  CHECK(encode_error(0, 3) == 0);
  CHECK(decode_error(0, 3) == 0);
  for (const double scale : {1.0, 0.37, 1e6, 1e-9})
    for (double error = scale * 0x1p-79; error < scale * 0x1p46; error *= 1.37) {
      const ErrorCode16 code = encode_error(error, scale);
      CHECK(decode_error(code, scale) >= error);
      CHECK(decode_error(code, scale) <= error * 1.0443);
      CHECK(decode_error(static_cast<ErrorCode16>(code - 1), scale) < error);
    }
}

TEST_CASE("error codes: monotone, 16 an octave, and a decoded value has its own code") {
  CHECK(decode_error(1280, 5) == 5);
  CHECK(decode_error(1296, 5) == 10);
  CHECK(decode_error(1288, 1) == std::sqrt(2.0));
  for (ErrorCode16 code = 1; code <= kMaxErrorCode; ++code) {
    CHECK(decode_error(code, 0.7) > decode_error(static_cast<ErrorCode16>(code - 1), 0.7));
    CHECK(encode_error(decode_error(code, 0.7), 0.7) == code);
  }
}

TEST_CASE("error codes: saturate at both ends") {
  CHECK(encode_error(1e-300, 1) == 1);
  CHECK(encode_error(1e300, 1) == kMaxErrorCode);
  CHECK(encode_error(INFINITY, 1) == kMaxErrorCode);
  CHECK(encode_error(0, 0) == 0);
}

TEST_CASE("squared error codes: rounded up on either side of zero, eight an octave") {
  const double step = std::exp2(1.0 / 8);
  CHECK(encode_squared_error(0) == 0);
  CHECK(decode_squared_error(0) == 0);
  CHECK(decode_squared_error(1600) == 1);
  CHECK(decode_squared_error(1604) == std::sqrt(2.0));
  for (double value = 0x1p-199; value < 0x1p55; value *= 1.61) {
    const double above = decode_squared_error(encode_squared_error(value));
    CHECK(above >= value);
    CHECK(above <= value * step * 1.0001);
    const double below = decode_squared_error(encode_squared_error(-value));
    CHECK(below >= -value);
    CHECK(below <= -value / step * 0.9999);
  }
  for (int code = -kMaxSquaredErrorCode; code <= kMaxSquaredErrorCode; ++code) {
    const auto coded = static_cast<SquaredErrorCode>(code);
    CHECK(encode_squared_error(decode_squared_error(coded)) == code);
    if (code > -kMaxSquaredErrorCode)
      CHECK(decode_squared_error(coded) > decode_squared_error(static_cast<SquaredErrorCode>(code - 1)));
  }
}

TEST_CASE("codes of uncovered volumes: rounded up in the same steps, from a part on that is small for all records") {
  const double step = std::exp2(1.0 / 8);
  for (const std::uint32_t records : {1U, 2U, 3U, 255U, 256U, 100000U, 0x7FFFFFFFU}) {
    const auto decode = [&](int code) { return decode_uncovered(static_cast<SquaredErrorCode>(code), records); };
    const int greatest = greatest_uncovered_code(records);
    CHECK(encode_uncovered(0, records) == 0);
    CHECK(decode(0) == 0);
    CHECK(decode(uncovered_code_of_all(records)) == 1);
    CHECK(decode(1) * records <= 0x1p-8);
    CHECK(decode(1) * 2 * records > 0x1p-9);
    CHECK(decode(greatest) == decode_squared_error(kMaxSquaredErrorCode));
    for (double value = decode(1); value < 0x1p55; value *= 1.61) {
      const double above = decode(encode_uncovered(value, records)), below = decode(encode_uncovered(-value, records));
      CHECK(above >= value);
      CHECK(above <= value * step * 1.0001);
      CHECK(below >= -value);
      CHECK(below <= -value / step * 0.9999);
    }
    CHECK(encode_uncovered(decode(1) / 1000, records) == 1);
    CHECK(encode_uncovered(-decode(1) / 1.001, records) == 0);
    CHECK(encode_uncovered(INFINITY, records) == greatest);
    CHECK(encode_uncovered(-INFINITY, records) == -greatest);
    for (int code = -greatest; code <= greatest; ++code) {
      CHECK(encode_uncovered(decode(code), records) == code);
      if (code > -greatest) CHECK(decode(code) > decode(code - 1));
    }
  }
}

TEST_CASE("squared error codes: too small for any is rounded up, too large saturates") {
  CHECK(encode_squared_error(1e-300) == 1);
  CHECK(encode_squared_error(-1e-300) == 0);
  CHECK(encode_squared_error(INFINITY) == kMaxSquaredErrorCode);
  CHECK(encode_squared_error(-INFINITY) == -kMaxSquaredErrorCode);
}
