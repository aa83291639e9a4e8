// The pieces of the codec: range coder, ranks of numbers, decimals, archive.
#include "formats/ptet/archive.hpp"
#include "formats/ptet/layout.hpp"
#include "formats/ptet/manifest.hpp"
#include "formats/ptet/numbers.hpp"
#include "formats/ptet/range_coder.hpp"
#include "formats/ptet/transcript.hpp"
#include "ptet/error.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::file;

namespace {

std::uint64_t rank_of_float(float value) {
  std::array<std::byte, 4> bytes;
  std::memcpy(bytes.data(), &value, 4);
  return load_rank(ScalarType::kFloat32, bytes.data());
}

} // namespace

TEST_CASE("what the range coder writes, it reads") {
  std::mt19937_64 random(1);
  for (int round = 0; round < 200; ++round) {
    const InitialProbabilities initial = {0, 1, 128, 255};
    struct Event {
      std::uint32_t context;
      bool bit;
      unsigned count;
      std::uint64_t value;
    };
    std::vector<Event> events(random() % 500);
    RangeEncoder encoder(initial);
    for (Event& event : events) {
      const auto count = static_cast<unsigned>(random() % 65);
      const std::uint64_t value = count == 0 ? 0 : random() >> (64 - count);
      // Long runs of one bit drive the probabilities and the carry to their ends.
      event = {static_cast<std::uint32_t>(random() % 4), random() % 64 < (round % 3 == 0 ? 1U : 32U), count, value};
      encoder.bit(event.context, event.bit);
      if (round % 2 == 0) encoder.raw(event.count, event.value);
    }
    RangeDecoder decoder(initial, encoder.finish(), 0);
    bool same = true;
    for (const Event& event : events) {
      same = same && decoder.bit(event.context) == event.bit;
      if (round % 2 == 0) same = same && decoder.raw(event.count) == event.value;
    }
    CHECK(same);
  }
}

TEST_CASE("a transcript tells all that was told, whatever the number of contexts") {
  std::mt19937_64 random(5);
  InitialProbabilities initial(70000);
  for (std::uint8_t& byte : initial)
    byte = static_cast<std::uint8_t>(random());
  RangeEncoder at_once(initial);
  Transcript transcript;
  for (int i = 0; i < 20000; ++i) {
    // Around 2^15 and 2^16, where what stands for a context and a bit takes more room.
    const auto context = static_cast<std::uint32_t>(
        std::array<std::uint64_t, 3>{random() % 70000, 32740 + random() % 40, 65530 + random() % 10}[random() % 3]);
    const bool bit = random() % 2 == 0;
    at_once.bit(context, bit);
    transcript.bit(context, bit);
    const auto count = static_cast<unsigned>(random() % 65);
    const std::uint64_t value = count == 0 ? 0 : random() >> (64 - count);
    at_once.raw(count, value);
    transcript.raw(count, value);
  }
  RangeEncoder told(initial);
  transcript.tell(told);
  const std::vector<std::byte> expected = at_once.finish();
  CHECK(told.finish() == expected);

  const std::size_t before = transcript.bytes();
  transcript.pack();
  CHECK(transcript.bytes() < before);
  RangeEncoder told_again(initial);
  transcript.tell(told_again);
  CHECK(told_again.finish() == expected);
}

TEST_CASE("ranks sort like the numbers and keep every bit") {
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> ascending = {-inf, -3.5F, -1e-40F, -0.0F, 0.0F, 1e-40F, 2, 3.5F, inf};
  for (std::size_t i = 1; i < ascending.size(); ++i)
    CHECK(rank_of_float(ascending[i - 1]) < rank_of_float(ascending[i]));
  CHECK(rank_of_float(0.0F) == rank_of_float(-0.0F) + 1);
  std::mt19937_64 random(2);
  for (int type = 0; type <= 9; ++type) {
    const auto scalar_type = static_cast<ScalarType>(type);
    for (int i = 0; i < 1000; ++i) {
      std::array<std::byte, 8> bytes{}, back{};
      for (std::size_t b = 0; b < size_of(scalar_type); ++b)
        bytes[b] = static_cast<std::byte>(random());
      store_rank(scalar_type, load_rank(scalar_type, bytes.data()), back.data());
      CHECK(bytes == back);
    }
  }
}

TEST_CASE("the nearest rank to a prediction never leaves the type") {
  const double inf = std::numeric_limits<double>::infinity();
  CHECK(rank_of(ScalarType::kUInt8, 300) == 255);
  CHECK(rank_of(ScalarType::kUInt8, -1) == 0);
  CHECK(rank_of(ScalarType::kInt8, -inf) == 0);
  CHECK(rank_of(ScalarType::kInt8, 2.5) == 128 + 3);
  CHECK(rank_of(ScalarType::kInt64, inf) == ~std::uint64_t{0});
  CHECK(rank_of(ScalarType::kUInt64, 1e300) == ~std::uint64_t{0});
  CHECK(rank_of(ScalarType::kFloat32, 1e300) == rank_of_float(std::numeric_limits<float>::max()));
  CHECK(rank_of(ScalarType::kFloat32, std::nan("")) == rank_of_float(0));
}

TEST_CASE("decimal ranks are dense, ordered, and exact about what they hold") {
  const DecimalRanking ranking(ScalarType::kFloat32, 3);
  CHECK(ranking.exact(rank_of_float(1.23F)).has_value());
  CHECK(ranking.exact(rank_of_float(-45600.0F)).has_value());
  CHECK(ranking.exact(rank_of_float(0.0F)) == 0);
  CHECK(!ranking.exact(rank_of_float(-0.0F)).has_value());
  CHECK(!ranking.exact(rank_of_float(1.234F)).has_value());
  CHECK(!ranking.exact(rank_of_float(std::numeric_limits<float>::infinity())).has_value());
  CHECK(*ranking.exact(rank_of_float(1.24F)) == *ranking.exact(rank_of_float(1.23F)) + 1);
  CHECK(*ranking.exact(rank_of_float(10.0F)) == *ranking.exact(rank_of_float(9.99F)) + 1);
  CHECK(ranking.nearest(9.999) == ranking.nearest(10));
  CHECK(ranking.nearest(std::nan("")) == 0);
  CHECK(!ranking.value_rank(std::numeric_limits<std::int64_t>::max()).has_value());
  for (std::int64_t rank = -2000; rank < 2000; ++rank) {
    const auto value = ranking.value_rank(rank);
    REQUIRE(value.has_value());
  }
}

TEST_CASE("decimal arrays are recognised, others are not") {
  PointArray array{"a", ScalarType::kFloat32, 1, {}};
  array.resize(1000);
  const auto fill = [&](double scale) {
    for (int i = 0; i < 1000; ++i) {
      const auto value = static_cast<float>((i * 7919 % 99991) / scale);
      std::memcpy(array.bytes.data() + 4 * i, &value, 4);
    }
  };
  fill(1000);
  CHECK(find_precision(array, 0) == Precision{5, 0});
  fill(1024.7);
  CHECK(find_precision(array, 0) == Precision{});
}

TEST_CASE("floats whose lowest bits are 0 are recognised") {
  PointArray array{"a", ScalarType::kFloat64, 2, {}};
  array.resize(1000);
  for (std::size_t i = 0; i < 1000; ++i) {
    const auto a = static_cast<double>(static_cast<float>(std::sin(static_cast<double>(i)))), b = std::ldexp(i, -10);
    store(array.bytes.data() + 16 * i, a);
    store(array.bytes.data() + 16 * i + 8, b);
  }
  CHECK(find_precision(array, 0) == Precision{0, 52 - 23});
  CHECK(find_precision(array, 1) == Precision{0, 52 - 9}); // 1 to 999, by a power of two: up to ten bits
  for (std::size_t i = 0; i < 20; ++i)
    store(array.bytes.data() + 16 * 7 * i, 1.0 / 3);
  CHECK(find_precision(array, 0) == Precision{0, 52 - 23});
  store(array.bytes.data() + 16, 1.0 / 3);
  CHECK(find_precision(array, 0) == Precision{});

  for (const ScalarType type : {ScalarType::kFloat32, ScalarType::kFloat64}) {
    const unsigned most = type == ScalarType::kFloat32 ? 23 : 52;
    for (const unsigned zeros : {1U, 13U, most})
      for (const double value : {0.0, -0.0, 1.0, -1.0, 0.75, -1e300, HUGE_VAL, -HUGE_VAL, 1.0 / 3, -1.0 / 3}) {
        const std::uint64_t rank = type == ScalarType::kFloat32 ? to_rank(static_cast<float>(value)) : to_rank(value);
        const auto shorter = without_zeros(type, zeros, rank);
        if (shorter) CHECK(with_zeros(type, zeros, *shorter) == rank);
        if (std::abs(value) != 1.0 / 3 && std::abs(value) != 1e300 && (value != 0.75 || zeros < most))
          CHECK(shorter.has_value());
      }
    CHECK(!without_zeros(type, most, to_rank(1.5)).has_value());
  }
}

TEST_CASE("the byte of a precision") {
  for (const ScalarType type : {ScalarType::kFloat32, ScalarType::kFloat64, ScalarType::kInt64}) {
    const bool is_short = type == ScalarType::kFloat32;
    for (unsigned byte = 0; byte < 256; ++byte) {
      const auto precision = Precision::of_byte(type, static_cast<std::uint8_t>(byte));
      const bool is_one =
          byte == 0 ||
          (is_float(type) && (byte <= (is_short ? 7 : 12) || (byte > 64 && byte <= 64 + (is_short ? 23 : 52))));
      REQUIRE(precision.has_value() == is_one);
      if (precision) CHECK(precision->byte() == byte);
    }
  }
}

TEST_CASE("an archive asks for no more memory than its bytes can fill") {
  ByteWriter out;
  out.put_varint(1);
  out.put_text("x");
  out.put_varint(std::uint64_t{1} << 40);
  ByteReader in(out.bytes(), "test", 0);
  InputArchive archive(in);
  Manifest manifest;
  CHECK_THROWS_AS(archive & manifest, Error);
}

TEST_CASE("a varint has an end") {
  const std::vector<std::byte> bytes(20, std::byte{0xFF});
  ByteReader in(bytes, "test", 0);
  CHECK_THROWS_AS(in.get_varint("number"), Error);
}

TEST_CASE("other parents of a block: read back, and refused where they name what is not there") {
  std::vector<BlockInfo> blocks(3);
  for (std::uint32_t b = 0; b < 3; ++b) {
    blocks[b].first_record = 10 * b;
    blocks[b].record_count = 10;
  }
  blocks[2].needs = {1};
  const auto parse = [&](std::vector<std::uint64_t> numbers) {
    ByteWriter out;
    for (const std::uint64_t number : numbers)
      out.put_varint(number);
    ByteReader in(out.bytes(), "block", 0);
    return parse_others(in, 2, blocks);
  };
  OtherParents others;
  others.records = {RecordId{23}, RecordId{29}};
  others.begin = {0, 2, 3};
  others.parents = {RecordId{11}, RecordId{22}, RecordId{10}};
  ByteWriter out;
  put_others(out, 2, blocks, others);
  ByteReader in(out.bytes(), "block", 0);
  const OtherParents read = parse_others(in, 2, blocks);
  CHECK(in.remaining() == 0);
  CHECK(read.records == others.records);
  CHECK(read.begin == others.begin);
  CHECK(read.parents == others.parents);
  CHECK(read.of(RecordId{29}).size() == 1);
  CHECK(read.of(RecordId{24}).empty());

  CHECK(parse({0}).records.empty());
  CHECK(parse({1, 9, 1, 0, 5}).of(RecordId{29}).front() == RecordId{25});
  for (const auto& wrong : std::vector<std::vector<std::uint64_t>>{
           {11},                        // more records than the block has
           {1},                         // ends
           {1, 10, 1, 0, 5},            // no record of the block
           {2, 9, 1, 0, 5, 0, 1, 0, 5}, // the second one is none
           {1, 3, 0, 0, 0},             // no parent
           {1, 3, 1ULL << 40, 0, 5},    // more parents than bytes
           {1, 3, 1, 2, 5},             // a block that is not needed
           {1, 3, 1, 1, 10},            // no record of that block
           {1, 3, 2, 0, 5, 0, 5},       // twice the same
           {1, 3, 2, 0, 5, 1, 5},       // descending
       })
    CHECK_THROWS_AS(parse(wrong), Error);
}
