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
