// The bounds of PTET.md ("constraint, else reject"): each refuses the least value beyond it, under hashes that are
// right, and the greatest within it is not refused for it.
#include "formats/ptet/reader.hpp"
#include "formats/ptet/writer.hpp"
#include "ptet/error.hpp"
#include "support/file_parts.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/stream_extras.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

using Bytes = std::vector<std::byte>;
using Kind = file::SectionKind;

Bytes sample_file() {
  static const Bytes bytes = [] {
    const TetMesh mesh = grid({{6, 6, 6}, {}, 2, 1});
    RecordStream records = simplify_naively(mesh);
    add_random_squared_errors(records, 6);
    records.volume = 1;
    return file::encode(mesh, records, {});
  }();
  return bytes;
}

/// "" when all of the file can be read.
std::string refusal_of(const Bytes& bytes) {
  try {
    file::Reader reader(file::over_memory(bytes));
    file::Content content = reader.read_base();
    std::vector<std::uint32_t> blocks;
    for (std::uint32_t b = 0; b < reader.blocks().size(); ++b)
      blocks.push_back(b);
    reader.load(blocks, content);
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kCorruptFile);
    return error.what();
  }
  return {};
}

template <class T>
std::string with_header(std::size_t offset, T value) {
  FileParts parts(sample_file());
  put(parts.header, offset, value);
  return refusal_of(parts.join());
}

template <class T>
std::string with_arrays(std::size_t offset, T value) {
  FileParts parts(sample_file());
  put(parts.of(Kind::kArrays), offset, value);
  return refusal_of(parts.join());
}

using Catch::Contains;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

} // namespace

TEST_CASE("bounds of the header") {
  const Bytes good = sample_file();
  REQUIRE(refusal_of(FileParts(good).join()).empty());
  REQUIRE((get<std::uint16_t>(good, 54) & 1) == 1); // squared errors

  SECTION("the box") {
    for (std::size_t i = 0; i < 6; ++i)
      for (const double none : {kNaN, kInfinite, -kInfinite})
        CHECK_THAT(with_header(56 + 8 * i, none), Contains("is not finite"));
    for (std::size_t i = 0; i < 3; ++i) {
      const auto low = get<double>(good, 56 + 8 * i), high = get<double>(good, 80 + 8 * i);
      CHECK_THAT(with_header(56 + 8 * i, std::nextafter(high, kInfinite)), Contains("ends before it begins"));
      CHECK_THAT(with_header(80 + 8 * i, std::nextafter(low, -kInfinite)), Contains("ends before it begins"));
    }
    FileParts parts(good);
    put(parts.header, 56, -1e308);
    put(parts.header, 80, 1e308);
    CHECK_THAT(refusal_of(parts.join()), Contains("a side of the bounding box is not finite"));
  }
  SECTION("the diagonal") {
    for (const double none : {kNaN, kInfinite})
      CHECK_THAT(with_header(104, none), Contains("diagonal is not finite"));
    CHECK_THAT(with_header(104, -std::numeric_limits<double>::denorm_min()), Contains("diagonal is negative"));
    CHECK(with_header(104, 0.0).empty());
  }
  SECTION("the volume") {
    for (const double none : {kNaN, kInfinite})
      CHECK_THAT(with_header(112, none), Contains("volume is not finite"));
    CHECK_THAT(with_header(112, -1e-300), Contains("volume is not positive"));
    CHECK_THAT(with_header(112, 0.0), Contains("volume is not positive"));
    CHECK_THAT(with_header(112, 1e-300), !Contains("volume"));
  }
  SECTION("counts") {
    const auto records = get<std::uint32_t>(good, 24);
    CHECK_THAT(with_header(16, std::uint32_t{0xFFFFFFFE} - records), Contains("too many vertices"));
    CHECK_THAT(with_header(24, std::uint32_t{1} << 31), Contains("record_count is out of range"));
    CHECK_THAT(with_header(36, std::uint32_t{1025}), Contains("array_count is out of range"));
    CHECK_THAT(with_header(40, std::uint64_t{0xFFFFFFFE}), Contains("version_count is out of range"));
    CHECK_THAT(with_header(48, std::uint16_t{0}), Contains("records_per_block is out of range"));
    CHECK_THAT(with_header(48, std::uint16_t{4097}), Contains("records_per_block is out of range"));
    CHECK(with_header(48, std::uint16_t{4096}).empty());
    const auto base_tets = get<std::uint32_t>(good, 20);
    const auto versions = get<std::uint64_t>(good, 40);
    CHECK_THAT(with_header(28, base_tets - 1), Contains("tet_count does not fit"));
    CHECK_THAT(with_header(28, static_cast<std::uint32_t>(base_tets + versions + 1)),
               Contains("tet_count does not fit"));
  }
  SECTION("types") {
    CHECK_THAT(with_header(50, std::uint8_t{10}), Contains("position_type is unknown"));
    for (std::size_t axis = 0; axis < 3; ++axis)
      CHECK_THAT(with_header(51 + axis, std::uint8_t{8}), Contains("precision")); // of float32
  }
}

TEST_CASE("bounds of the arrays") {
  const Bytes good = FileParts(sample_file()).of(Kind::kArrays);
  const std::size_t type = 1 + get<std::uint8_t>(good, 0); // behind the name of the first
  CHECK_THAT(with_arrays(type, std::uint8_t{10}), Contains("type is unknown"));
  CHECK_THAT(with_arrays(type + 1, std::uint8_t{0}), Contains("an array has no component"));
  CHECK_THAT(with_arrays(type + 2, std::uint8_t{2}), Contains("governing"));
  for (const double none : {kNaN, kInfinite})
    CHECK_THAT(with_arrays(type + 3, none), Contains("range is not finite"));
  CHECK_THAT(with_arrays(type + 3, -1e-300), Contains("range is negative"));
  CHECK_THAT(with_arrays(type + 3, 0.0), !Contains("range is"));
}

TEST_CASE("bounds of the table") {
  FileParts parts(sample_file());
  REQUIRE(parts.rows().size() > 1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto rows = parts.rows();
    std::swap(rows[0].info.box_min[axis], rows[0].info.box_max[axis]);
    FileParts turned(sample_file());
    turned.set_rows(rows);
    CHECK_THAT(refusal_of(turned.join()), Contains("a block's bounding box ends before it begins"));
  }
}

TEST_CASE("bounds of the directory") {
  FileParts parts(sample_file());
  parts.sections.push_back({99, 0, 0, 0, 0, 0}); // of a kind to come: skipped
  parts.raw.emplace_back(5, std::byte{42});
  CHECK(refusal_of(parts.join()).empty());
  parts.sections.back().flags = file::kMandatory;
  CHECK_THAT(refusal_of(parts.join()), Contains("section 99 is mandatory but unknown"));
  FileParts optional(sample_file());
  optional.sections.push_back({static_cast<std::uint32_t>(Kind::kInputOrder), file::kMandatory, 0, 0, 0, 0});
  optional.raw.emplace_back(5, std::byte{42});
  CHECK_THAT(refusal_of(optional.join()), Contains("marked as mandatory that is not"));
}
