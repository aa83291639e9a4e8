// Integers of 64 bits as differences to one of them.
#include "mesh/value_offset.hpp"

#include <cstdint>
#include <cstring>
#include <limits>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

template <class T>
PointArray array_of(ScalarType type, T value) {
  PointArray array{"n", type, 1, std::vector<std::byte>(sizeof(T))};
  std::memcpy(array.bytes.data(), &value, sizeof(T));
  return array;
}

PointArray of(std::int64_t value) {
  return array_of(ScalarType::kInt64, value);
}
PointArray of(std::uint64_t value) {
  return array_of(ScalarType::kUInt64, value);
}

double difference(const PointArray& a, const PointArray& b) {
  return ValueOffset(b, 0, 0).value(a, 0, 0);
}

} // namespace

TEST_CASE("value offset: differences of large integers are exact, whatever their types") {
  const std::int64_t large = (std::int64_t{1} << 60U) + 1;
  CHECK(difference(of(large + 2), of(large)) == 2);
  CHECK(difference(of(-large - 2), of(-large)) == -2);
  CHECK(difference(of(static_cast<std::uint64_t>(large) + 7), of(large)) == 7);
  CHECK(difference(of(large), of(static_cast<std::uint64_t>(large) + 7)) == -7);
  CHECK(difference(of(std::uint64_t{5}), of(std::int64_t{-3})) == 8);
  CHECK(difference(of(std::int64_t{-3}), of(std::uint64_t{5})) == -8);
}

TEST_CASE("value offset: what is too far apart is never near") {
  constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  const auto far_apart = [](const PointArray& a, const PointArray& b) {
    CHECK(difference(a, b) >= kExactIntegers);
    CHECK(difference(b, a) <= -kExactIntegers);
  };
  far_apart(of(kMost), of(std::int64_t{-1})); // 2^64
  far_apart(of(std::uint64_t{1} << 63U), of(kLeast));
  far_apart(of(kMost), of(kLeast));
  far_apart(of(kMost), of(std::int64_t{0}));
  far_apart(of(std::numeric_limits<std::int64_t>::max()), of(kLeast));
}
