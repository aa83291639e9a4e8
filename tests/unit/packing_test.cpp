#include "formats/ptet/packing.hpp"
#include "formats/ptet/schema.hpp"
#include "ptet/error.hpp"

#include <random>
#include <vector>

#include <catch2/catch.hpp>
#include <zstd.h>

namespace ptet::file {
namespace {

std::vector<std::byte> constant(std::size_t size) {
  return std::vector<std::byte>(size, std::byte{128});
}

/// Every `every`-th byte is any, the others are the same.
std::vector<std::byte> random(std::size_t size, std::size_t every) {
  std::mt19937 engine(5);
  std::vector<std::byte> bytes = constant(size);
  for (std::size_t i = 0; i < size; i += every)
    bytes[i] = static_cast<std::byte>(engine() & 0xFF);
  return bytes;
}

} // namespace

TEST_CASE("packed bytes come back, from one frame that expands no further than a reader takes") {
  for (const std::size_t size : {0, 1, 100, 4095, 4096, 4097, 24'000, 5'000'000}) {
    for (const auto& raw : {constant(size), random(size, 1), random(size, 100), random(size, 100'000)}) {
      const std::vector<std::byte> stored = packed(raw, [](std::size_t) {});
      REQUIRE(stored.size() <= raw.size());
      CHECK(raw.size() <= stored.size() * kMaxExpansion);
      if (stored.size() == raw.size()) {
        CHECK(stored == raw);
        continue;
      }
      CHECK(ZSTD_findFrameCompressedSize(stored.data(), stored.size()) == stored.size());
      std::vector<std::byte> back(raw.size());
      REQUIRE(ZSTD_decompress(back.data(), back.size(), stored.data(), stored.size()) == raw.size());
      CHECK(back == raw);
    }
  }
  CHECK(packed(constant(24'000), [](std::size_t) {}).size() < 100); // and not as it is
}

TEST_CASE("packing can be given up") {
  const auto raw = constant(20'000'000);
  std::size_t looks = 0;
  CHECK_THROWS_AS(packed(raw,
                         [&](std::size_t done) {
                           CHECK(done < raw.size());
                           if (++looks == 2) throw Error(ErrorCode::kCancelled, "enough");
                         }),
                  Error);
  CHECK(looks == 2);
}

} // namespace ptet::file
