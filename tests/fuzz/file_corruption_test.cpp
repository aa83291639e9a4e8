// Damaged .ptet files: every truncation, flipped bits that the hashes must catch, and flipped bits under mended hashes,
// which must decode to a valid mesh or be refused.
#include "formats/ptet/layout.hpp"
#include "formats/ptet/reader.hpp"
#include "formats/ptet/writer.hpp"
#include "ptet/error.hpp"
#include "support/file_parts.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/stream_extras.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

using Bytes = std::vector<std::byte>;
using Parts = FileParts;

file::Content load_all(file::Reader& reader) {
  file::Content content = reader.read_base();
  std::vector<std::uint32_t> every(reader.blocks().size());
  for (std::uint32_t b = 0; b < every.size(); ++b)
    every[b] = b;
  reader.load(every, content);
  return content;
}

enum class Outcome { kRead, kRefused, kLimit };

/// Whatever else is thrown goes on and fails the test; so does a mesh that breaks an invariant.
Outcome try_to_read(Bytes bytes) {
  try {
    file::Reader reader(file::over_memory(std::move(bytes)));
    const file::Content content = load_all(reader);
    REQUIRE(content.refinement.validate().empty());
    return Outcome::kRead;
  } catch (const Error& error) {
    REQUIRE(std::string(error.what()).size() > 10);
    if (error.code() == ErrorCode::kLimit) return Outcome::kLimit;
    REQUIRE(error.code() == ErrorCode::kCorruptFile);
    CHECK(error.byte_offset().has_value());
    return Outcome::kRefused;
  }
}

Bytes sample_file(const TetMesh& mesh) {
  RecordStream records = simplify_naively(mesh);
  add_random_dependencies(records, 6);
  add_random_squared_errors(records, 6);
  return file::encode(mesh, records, {"0.1.0", "sample", "xxh64:0", {{"option", "value"}}, {"note"}});
}

Bytes golden_file(const std::string& name) {
  const auto source = file::open_file(PTET_SOURCE_DIR "/tests/golden/" + name + ".ptet");
  Bytes bytes(source->size());
  source->read(0, bytes);
  return bytes;
}

/// Whether damage is found without decoding a record: in what opening reads, or by the hash of a block.
bool is_found(const Bytes& bytes) {
  try {
    const file::Reader reader(file::over_memory(bytes));
    static_cast<void>(reader.read_base());
    std::vector<std::uint32_t> every(reader.blocks().size());
    for (std::uint32_t b = 0; b < every.size(); ++b)
      every[b] = b;
    bool found = false;
    static_cast<void>(reader.fetch(every, [&](std::uint32_t, const Error& error) {
      found |= error.code() == ErrorCode::kCorruptFile && error.byte_offset().has_value();
    }));
    return found;
  } catch (const Error& error) {
    return error.code() == ErrorCode::kCorruptFile && error.byte_offset().has_value();
  }
}

/// Every so many bits of a golden file are flipped: all of them when PTET_TEST_EVERYTHING is set, and where it is
/// quick.
std::size_t flip_step(std::size_t usual) {
  return std::getenv("PTET_TEST_EVERYTHING") != nullptr ? 1 : usual;
}

/// The file with a change in a row of its table, under right hashes.
Bytes with_row(const Bytes& bytes, std::size_t row, const std::function<void(file::BlockInfo&)>& change) {
  Parts parts(bytes);
  auto rows = parts.rows();
  change(rows.at(row).info);
  parts.set_rows(rows);
  return parts.join();
}

} // namespace

TEST_CASE("a file cut short at any length is refused") {
  for (const TetMesh& mesh : {two_tets_sharing_a_face(), grid({{3, 3, 3}, {}, 2, 1})}) {
    const Bytes bytes = sample_file(mesh);
    REQUIRE(try_to_read(bytes) == Outcome::kRead);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      const Outcome outcome = try_to_read({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)});
      if (outcome != Outcome::kRefused) FAIL("read at length " << length);
    }
  }
}

TEST_CASE("a file with bytes appended is refused") {
  Bytes bytes = sample_file(grid({{3, 3, 3}, {}, 2, 1}));
  bytes.push_back(std::byte{0});
  CHECK(try_to_read(bytes) == Outcome::kRefused);
}

TEST_CASE("2,000 flipped bits are all found") {
  std::mt19937_64 random(20);
  for (const TetMesh& mesh : {two_tets_sharing_a_face(), grid({{3, 3, 3}, {}, 2, 1})}) {
    const Bytes bytes = sample_file(mesh);
    for (int i = 0; i < 1000; ++i) {
      Bytes damaged = bytes;
      const std::size_t bit = random() % (8 * bytes.size());
      flip(damaged, bit);
      if (try_to_read(damaged) != Outcome::kRefused) FAIL("bit " << bit << " was not missed");
    }
  }
}

TEST_CASE("golden files cut short at any length are refused") {
  for (const char* name : {"tiny", "pinched", "double"}) {
    const Bytes bytes = golden_file(name);
    REQUIRE(!is_found(bytes));
    std::size_t missed = 0;
    for (std::size_t length = 0; length < bytes.size(); ++length)
      missed += is_found({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)}) ? 0 : 1;
    INFO(name << ": " << bytes.size() << " lengths");
    CHECK(missed == 0);
  }
}

TEST_CASE("every flipped bit of golden files is found") {
  const std::pair<const char*, std::size_t> files[] = {{"tiny", 1}, {"pinched", 5}, {"double", 11}};
  for (const auto& [name, usual_step] : files) {
    Bytes bytes = golden_file(name);
    const std::size_t step = flip_step(usual_step);
    std::size_t flips = 0, missed = 0;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += step) {
      flip(bytes, bit);
      missed += is_found(bytes) ? 0 : 1;
      flip(bytes, bit);
      ++flips;
    }
    INFO(name << ": " << flips << " bits");
    CHECK(missed == 0);
    REQUIRE(!is_found(bytes));
  }
}

TEST_CASE("a file taken apart and put together again is read") {
  const Bytes bytes = sample_file(grid({{4, 4, 4}, {}, 2, 1}));
  Parts parts(bytes);
  parts.mend_blocks();
  CHECK(try_to_read(parts.join()) == Outcome::kRead);
}

TEST_CASE("damage under right hashes decodes to a valid mesh or is refused") {
  const Bytes bytes = sample_file(grid({{4, 4, 4}, {}, 2, 1}));
  std::mt19937_64 random(21);
  std::size_t refused = 0;
  const auto damage = [&](Bytes& part) {
    for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips)
      flip(part, random() % (8 * part.size()));
  };
  for (int i = 0; i < 2000; ++i) {
    Parts parts(bytes);
    const std::size_t which = random() % (parts.raw.size() + 2);
    if (which >= parts.raw.size()) {
      // Half of all damage goes where most of the decoding is, the rest around it.
      if (which == parts.raw.size()) damage(parts.header);
      if (which > parts.raw.size()) {
        damage(parts.of(file::SectionKind::kBlocks));
        parts.mend_blocks();
      }
    } else {
      damage(parts.raw[which]);
      if (Parts::is(parts.sections[which], file::SectionKind::kBlocks)) parts.mend_blocks();
    }
    refused += try_to_read(parts.join()) == Outcome::kRead ? 0 : 1;
  }
  CHECK(refused > 500);
}

TEST_CASE("sections are told apart: unknown ones may be skipped unless they are mandatory") {
  const Bytes bytes = sample_file(grid({{3, 3, 3}, {}, 2, 1}));
  Parts parts(bytes);
  parts.sections.push_back({77, 0, 0, 0, 0, 0});
  parts.raw.push_back(Bytes(5, std::byte{42}));
  CHECK(try_to_read(parts.join()) == Outcome::kRead);
  parts.sections.back().flags = file::kMandatory;
  CHECK(try_to_read(parts.join()) == Outcome::kRefused);
  parts.sections.back().flags = 2;
  CHECK(try_to_read(parts.join()) == Outcome::kRefused);
}

TEST_CASE("order codes that are out of range or not those of the table are refused") {
  const Bytes bytes = sample_file(grid({{12, 12, 12}, {}, 2, 1}));
  const auto with = [&](std::size_t row, const std::function<void(file::BlockInfo&)>& change) {
    return try_to_read(with_row(bytes, row, change));
  };
  CHECK(with(0, [](file::BlockInfo&) {}) == Outcome::kRead);
  // Codes are less than this by what the records say, and those of finer blocks are less than their parents'.
  CHECK(with(0, [](file::BlockInfo& info) { info.max_order = 0; }) == Outcome::kRefused);
  CHECK(with(0, [](file::BlockInfo& info) { info.max_order = kMaxOrderCode + 1; }) == Outcome::kRefused);
  CHECK(with(2, [](file::BlockInfo& info) { info.max_order = kMaxOrderCode; }) == Outcome::kRefused);
}

TEST_CASE("largest own codes that are not those of the records are refused") {
  const Bytes bytes = sample_file(grid({{12, 12, 12}, {}, 2, 1}));
  const auto with = [&](const std::function<void(ErrorCode16&)>& change) {
    return try_to_read(with_row(bytes, 1, [&](file::BlockInfo& info) { change(info.max_own.front()); }));
  };
  CHECK(with([](ErrorCode16&) {}) == Outcome::kRead);
  CHECK(with([](ErrorCode16& code) { code = 0; }) == Outcome::kRefused);
  CHECK(with([](ErrorCode16& code) { code = kMaxErrorCode; }) == Outcome::kRefused);
}

TEST_CASE("sums of squared errors that are not those of the records are refused") {
  const Bytes bytes = sample_file(grid({{4, 4, 4}, {}, 2, 1}));
  const auto with = [&](const std::function<void(std::vector<double>&)>& change) {
    return try_to_read(with_row(bytes, 0, [&](file::BlockInfo& info) {
      REQUIRE(info.squared_error.size() == 3);
      change(info.squared_error);
    }));
  };
  CHECK(with([](std::vector<double>&) {}) == Outcome::kRead);
  CHECK(with([](std::vector<double>& sums) { sums[1] *= 1 + 0x1p-50; }) == Outcome::kRead);
  CHECK(with([](std::vector<double>& sums) { sums[0] += 1 + std::fabs(sums[0]); }) == Outcome::kRefused);
  CHECK(with([](std::vector<double>& sums) { sums[1] -= 1 + std::fabs(sums[1]); }) == Outcome::kRefused);
  CHECK(with([](std::vector<double>& sums) { sums[2] += 0.01; }) == Outcome::kRefused);
  CHECK(with([](std::vector<double>& sums) { sums[2] -= 0.01; }) == Outcome::kRefused);
}
