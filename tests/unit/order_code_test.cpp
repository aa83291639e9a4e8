#include "record/order_code.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace ptet;

TEST_CASE("order codes: 32 for each halving of the vertices, rounded up") {
  CHECK(encode_order(1000, 1000) == 0);
  CHECK(encode_order(1000, 999) == 1);
  CHECK(encode_order(1000, 500) == 32);
  CHECK(encode_order(1000, 499) == 33);
  CHECK(encode_order(1000, 250) == 64);
  CHECK(encode_order(1 << 20, 1) == 640);
  for (std::uint64_t left = 999; left > 0; --left) {
    const OrderCode code = encode_order(1000, left);
    CHECK(code >= encode_order(1000, left + 1));
    CHECK(std::exp2(code / 32.0) >= 1000.0 / static_cast<double>(left) * (1 - 1e-14));
    CHECK(std::exp2((code - 1) / 32.0) < 1000.0 / static_cast<double>(left));
  }
}

TEST_CASE("order codes: saturate where next to nothing is left of a very large mesh") {
  CHECK(encode_order(0xFFFFFFFD, 1) == kMaxOrderCode);
  CHECK(encode_order(0xFFFFFFFD, 0xFFFFFFFD) == 0);
  CHECK(encode_order(0xFFFFFFFD, 0xFFFFFFFC) == 1);
  CHECK(encode_order(0x80000000, 256) == 736);
}
