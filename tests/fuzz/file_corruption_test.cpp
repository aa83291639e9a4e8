// Damaged .ptet files: every truncation, flipped bits that the hashes must catch, and flipped bits under mended hashes,
// which must decode to a valid mesh or be refused.
#include "formats/ptet/layout.hpp"
#include "formats/ptet/reader.hpp"
#include "formats/ptet/writer.hpp"
#include "ptet/error.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/stream_extras.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

using Bytes = std::vector<std::byte>;

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

void flip(Bytes& bytes, std::size_t bit) {
  bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
}

/// A file taken apart, so that a part can be damaged and everything hashed anew. Sections are put back uncompressed.
struct Parts {
  Bytes header;
  std::vector<file::Section> sections;
  std::vector<Bytes> raw; ///< by section

  explicit Parts(const Bytes& bytes) {
    file::ByteReader footer_reader(std::span{bytes}.last(file::kFooterBytes), "footer", 0);
    const file::Footer footer = file::parse_footer(footer_reader);
    file::ByteReader directory(
        std::span{bytes}.subspan(footer.directory_offset, footer.section_count * file::kSectionBytes), "directory", 0);
    sections = file::parse_directory(directory, footer.section_count);
    header.assign(bytes.begin(), bytes.begin() + file::kHeaderBytes);
    for (const file::Section& section : sections) {
      const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(section.offset);
      Bytes stored(first, first + static_cast<std::ptrdiff_t>(section.stored_bytes));
      raw.push_back(is(section, file::SectionKind::kBlocks) ? stored : file::expand(section, stored));
    }
  }
  static bool is(const file::Section& section, file::SectionKind kind) {
    return section.kind == static_cast<std::uint32_t>(kind);
  }
  Bytes& of(file::SectionKind kind) {
    const auto found = std::find_if(sections.begin(), sections.end(), [&](const auto& s) { return is(s, kind); });
    return raw[static_cast<std::size_t>(found - sections.begin())];
  }

  /// Hashes the blocks anew in the table, which must be sound.
  void mend_blocks() {
    file::ByteReader header_reader(header, "header", 0);
    auto fixed = file::parse_header(header_reader);
    file::ByteReader arrays(of(file::SectionKind::kArrays), "arrays", 0);
    static_cast<void>(file::parse_arrays(arrays, fixed));
    file::ByteReader table(of(file::SectionKind::kTable), "table", 0);
    const Bytes& blocks = of(file::SectionKind::kBlocks);
    auto rows = file::parse_table(table, fixed, {0, 0, 0, blocks.size(), blocks.size(), 0});
    for (file::TableRow& row : rows) {
      row.hash = file::hash_of(std::span(blocks).subspan(row.info.offset, row.info.stored_bytes));
    }
    file::ByteWriter out;
    file::put_table(out, rows);
    of(file::SectionKind::kTable) = out.take();
  }

  [[nodiscard]] Bytes join() const {
    file::ByteWriter out;
    out.put_bytes(std::span(header).first(file::kHeaderBytes - 8));
    out.put(file::hash_of(std::span(header).first(file::kHeaderBytes - 8)));
    auto placed = sections;
    for (std::size_t i = 0; i < placed.size(); ++i) {
      placed[i].offset = out.size();
      placed[i].stored_bytes = placed[i].raw_bytes = raw[i].size();
      if (!is(placed[i], file::SectionKind::kBlocks)) placed[i].hash = file::hash_of(raw[i]);
      out.put_bytes(raw[i]);
    }
    const std::uint64_t directory = out.size();
    file::put_directory(out, placed);
    const auto hash = file::hash_of(std::span(out.bytes()).subspan(directory));
    file::put_footer(out,
                     {directory, static_cast<std::uint32_t>(placed.size()), hash, out.size() + file::kFooterBytes});
    return out.take();
  }
};

/// The file with a change in a row of its table, under right hashes.
Bytes with_row(const Bytes& bytes, std::size_t row, const std::function<void(file::BlockInfo&)>& change) {
  Parts parts(bytes);
  file::ByteReader header_reader(parts.header, "header", 0);
  auto fixed = file::parse_header(header_reader);
  file::ByteReader arrays(parts.of(file::SectionKind::kArrays), "arrays", 0);
  static_cast<void>(file::parse_arrays(arrays, fixed));
  file::ByteReader table(parts.of(file::SectionKind::kTable), "table", 0);
  const std::size_t size = parts.of(file::SectionKind::kBlocks).size();
  auto rows = file::parse_table(table, fixed, {0, 0, 0, size, size, 0});
  change(rows.at(row).info);
  file::ByteWriter out;
  file::put_table(out, rows);
  parts.of(file::SectionKind::kTable) = out.take();
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

TEST_CASE("sums of squared errors that are not those of the records are refused") {
  const Bytes bytes = sample_file(grid({{4, 4, 4}, {}, 2, 1}));
  const auto with = [&](const std::function<void(std::vector<double>&)>& change) {
    return try_to_read(with_row(bytes, 0, [&](file::BlockInfo& info) {
      REQUIRE(info.squared_error.size() == 2);
      change(info.squared_error);
    }));
  };
  CHECK(with([](std::vector<double>&) {}) == Outcome::kRead);
  CHECK(with([](std::vector<double>& sums) { sums[1] *= 1 + 0x1p-50; }) == Outcome::kRead);
  CHECK(with([](std::vector<double>& sums) { sums[0] += 1 + std::fabs(sums[0]); }) == Outcome::kRefused);
  CHECK(with([](std::vector<double>& sums) { sums[1] -= 1 + std::fabs(sums[1]); }) == Outcome::kRefused);
}
