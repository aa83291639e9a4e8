// The verification finds what is wrong, all of it and where: files broken in every way that the format has rules for,
// several ways at once, and errors that are not true.
#include "build/builder.hpp"
#include "build/certify.hpp"
#include "formats/ptet/stated_errors.hpp"
#include "formats/ptet/verification.hpp"
#include "formats/ptet/writer.hpp"
#include "mesh/prepare.hpp"
#include "ptet/error.hpp"
#include "support/file_parts.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/stream_extras.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <functional>
#include <numeric>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

using Bytes = std::vector<std::byte>;
using Found = std::vector<file::Violation>;

const file::Manifest kExactManifest{"0.1.0", "sample", "xxh64:0", {{"evaluate", "exact"}}, {}};

/// Some blocks of small grids.
Bytes sample_file() {
  static const Bytes bytes = [] {
    const TetMesh mesh = grid({{6, 6, 6}, {}, 2, 1});
    RecordStream records = simplify_naively(mesh);
    add_random_squared_errors(records, 6);
    records.volume = build::volume_of(prepare(mesh));
    return file::encode(mesh, records, kExactManifest);
  }();
  return bytes;
}

Found verify(const Bytes& bytes, std::vector<std::string>* notes = nullptr) {
  Found found;
  const file::Verified verified =
      file::verify(file::over_memory(bytes), [&](const file::Violation& violation) { found.push_back(violation); });
  if (notes != nullptr) *notes = verified.notes;
  CHECK((verified.is_whole() || !found.empty()));
  return found;
}

std::string list_of(const Found& found) {
  std::string list = std::to_string(found.size()) + " found:";
  for (const file::Violation& violation : found)
    list += "\n  " + violation.what;
  return list;
}

const file::Violation* find(const Found& found, const std::string& what) {
  const auto at = std::find_if(found.begin(), found.end(),
                               [&](const file::Violation& v) { return v.what.find(what) != std::string::npos; });
  return at == found.end() ? nullptr : &*at;
}

/// Changes the header under a right hash.
Bytes with_header(const Bytes& bytes, const std::function<void(Bytes&)>& change) {
  FileParts parts(bytes);
  change(parts.header);
  return parts.join();
}
/// Changes the rows of the directory under a right hash.
Bytes with_directory(Bytes bytes, const std::function<void(std::vector<file::Section>&)>& change) {
  const auto count = get<std::uint32_t>(bytes, bytes.size() - 32);
  const auto offset = get<std::uint64_t>(bytes, bytes.size() - 40);
  file::ByteReader in(std::span<const std::byte>(bytes).subspan(offset, count * file::kSectionBytes), "directory", 0);
  auto sections = file::parse_directory(in, count);
  change(sections);
  file::ByteWriter out;
  file::put_directory(out, sections);
  std::copy(out.bytes().begin(), out.bytes().end(), bytes.begin() + static_cast<std::ptrdiff_t>(offset));
  put(bytes, bytes.size() - 24, file::hash_of(out.bytes()));
  return bytes;
}
Bytes with_rows(const Bytes& bytes, const std::function<void(std::vector<file::TableRow>&)>& change) {
  FileParts parts(bytes);
  auto rows = parts.rows();
  change(rows);
  parts.set_rows(rows);
  return parts.join();
}
file::Section& section(std::vector<file::Section>& sections, file::SectionKind kind) {
  return *std::find_if(sections.begin(), sections.end(), [&](const auto& s) { return FileParts::is(s, kind); });
}

/// A block that others need, and one that no other needs.
struct Chosen {
  std::uint32_t needed = 0, leaf = 0, dependents = 0;
};
Chosen choose(const Bytes& bytes) {
  const file::Reader reader(file::over_memory(bytes));
  Chosen chosen;
  std::vector<char> is_needed(reader.blocks().size());
  for (const file::BlockInfo& block : reader.blocks())
    for (const std::uint32_t b : block.needs)
      is_needed[b] = 1;
  REQUIRE(reader.blocks().size() > 2);
  for (std::uint32_t b = 0; b < is_needed.size(); ++b)
    if (is_needed[b] == 0) chosen.leaf = b;
  chosen.needed = static_cast<std::uint32_t>(std::find(is_needed.begin(), is_needed.end(), 1) - is_needed.begin());
  REQUIRE(chosen.needed < is_needed.size());
  return chosen;
}

/// What is wrong with a file of the records, all of whose errors are measured.
Found all_checked(const TetMesh& mesh, const RecordStream& records) {
  Found found;
  const auto tell = [&](const file::Violation& violation) { found.push_back(violation); };
  const file::Verified verified = file::verify(file::over_memory(file::encode(mesh, records, kExactManifest)), tell);
  (void)file::check_stated_errors(verified, 0, tell);
  return found;
}

} // namespace

TEST_CASE("verification: nothing is found in a sound file") {
  const Found found = verify(sample_file());
  INFO(list_of(found));
  CHECK(found.empty());
}

TEST_CASE("verification: a damaged header that is beyond a limit is damaged") {
  Bytes damaged = sample_file();
  put<std::uint8_t>(damaged, 19, 0x80); // 2^31 vertices more
  const Found found = verify(damaged);
  CHECK(find(found, "header's hash") != nullptr);
  CHECK(find(found, "more than the limit") != nullptr);
  const Bytes sound = with_header(sample_file(), [](Bytes& h) { put<std::uint8_t>(h, 19, 0x80); });
  CHECK_THROWS_MATCHES(verify(sound), Error,
                       Catch::Predicate<Error>([](const Error& error) { return error.code() == ErrorCode::kLimit; }));
}

TEST_CASE("verification: a box of the header that is not the mesh's") {
  // The boxes of the blocks are stated in it, so they are wrong, too.
  const Bytes wrong = with_header(sample_file(), [](Bytes& h) { put(h, 56, -1e6); });
  const Found found = verify(wrong);
  INFO(list_of(found));
  REQUIRE(found.size() > 1);
  CHECK(std::all_of(found.begin(), found.end() - 1,
                    [](const auto& v) { return v.what.find("a block's bounding box is not") == 0; }));
  CHECK(found.back().what.find("bounding box of the header") != std::string::npos);
  CHECK(found.back().offset == 56);
}

TEST_CASE("verification: a diagonal of the header that is not the box's") {
  for (const double factor : {2.0, 1 + 1e-9}) {
    const Bytes wrong = with_header(sample_file(), [&](Bytes& h) {
      double diagonal = 0;
      std::memcpy(&diagonal, h.data() + 104, sizeof diagonal);
      put(h, 104, factor * diagonal);
    });
    const Found found = verify(wrong);
    INFO(list_of(found));
    REQUIRE(found.size() == 1);
    CHECK(found[0].what == "the diagonal of the header is not that of the mesh");
    CHECK(found[0].offset == 104);
  }
}

TEST_CASE("verification: a range that is not that of the values, which scales the errors") {
  for (const double factor : {0.5, 2.0, 1 + 1e-9}) {
    const TetMesh mesh = grid({{6, 6, 6}, {}, 2, 1});
    RecordStream records = simplify_naively(mesh);
    records.volume = build::volume_of(prepare(mesh));
    CHECK(verify(file::encode(mesh, records, kExactManifest)).empty());
    records.fields[0].range *= factor;
    const Found found = verify(file::encode(mesh, records, kExactManifest));
    INFO(list_of(found));
    REQUIRE(found.size() == 1);
    CHECK(found[0].what == "the range of '" + mesh.point_arrays[records.fields[0].array].name +
                               "' in the header is not that of its values");
  }
}

TEST_CASE("verification: each way to break the layout is found, alone, with its place") {
  const Bytes good = sample_file();
  using Kind = file::SectionKind;
  struct Way {
    const char* says;
    std::optional<std::uint64_t> offset;
    Bytes bytes;
  };
  std::vector<Way> ways;
  Bytes damaged = good;
  put(damaged, 120, get<std::uint64_t>(good, 120) ^ 1);
  ways.push_back({"header's hash", 0, damaged});
  ways.push_back({"reserved is 5", {}, with_header(good, [](Bytes& h) { put<std::uint32_t>(h, 12, 5); })});
  ways.push_back({"reserved flag is set", {}, with_header(good, [](Bytes& h) { put<std::uint16_t>(h, 54, 0x11); })});
  ways.push_back({"number of tets of the header", 0,
                  with_header(good, [](Bytes& h) { put<std::uint32_t>(h, 28, get<std::uint32_t>(h, 28) - 1); })});
  damaged = good;
  put<std::uint32_t>(damaged, good.size() - 28, 7);
  ways.push_back({"reserved is 7", {}, damaged});
  damaged = good;
  put<std::uint64_t>(damaged, good.size() - 16, 1234);
  ways.push_back({"should have 1234", good.size(), damaged});
  damaged = good;
  put<std::uint64_t>(damaged, good.size() - 24, 1);
  ways.push_back({"directory's hash", get<std::uint64_t>(good, good.size() - 40), damaged});
  ways.push_back({"flag of a section", {}, with_directory(good, [](auto& s) { s[0].flags |= 8; })});
  ways.push_back({"not marked so", {}, with_directory(good, [](auto& s) { s[1].flags = 0; })});
  ways.push_back({"blocks' row", {}, with_directory(good, [](auto& s) { section(s, Kind::kBlocks).hash = 5; })});
  for (const Kind kind : {Kind::kArrays, Kind::kModel, Kind::kBase, Kind::kManifest, Kind::kTable}) {
    std::uint64_t offset = 0;
    Bytes bytes = with_directory(good, [&](auto& s) {
      section(s, kind).hash ^= 1;
      offset = section(s, kind).offset;
    });
    ways.push_back({file::name_of(kind), offset, std::move(bytes)});
  }
  FileParts parts(good);
  parts.sections.push_back({77, file::kMandatory, 0, 0, 0, 0});
  parts.raw.push_back(Bytes(5, std::byte{42}));
  ways.push_back({"section 77 is mandatory but unknown", {}, parts.join()});
  parts.sections.back().flags = 0;
  ways.push_back({"unknown section", {}, with_directory(parts.join(), [](auto& s) { s.back().hash ^= 1; })});
  parts = FileParts(good);
  parts.of(Kind::kManifest).push_back(std::byte{0});
  ways.push_back({"1 bytes too many", {}, parts.join()});
  for (const Way& way : ways) {
    const Found found = verify(way.bytes);
    INFO(way.says << "; " << list_of(found));
    REQUIRE(found.size() == 1);
    CHECK(find(found, way.says) != nullptr);
    CHECK(found[0].offset.has_value());
    if (way.offset) CHECK(found[0].offset == way.offset);
  }
}

TEST_CASE("verification: a volume that is not that of the mesh") {
  const TetMesh mesh = grid({{3, 3, 3}, {}, 2, 1});
  RecordStream records = simplify_naively(mesh);
  records.volume = build::volume_of(prepare(mesh));
  CHECK(verify(file::encode(mesh, records, kExactManifest)).empty());
  records.volume *= 1 + 1e-6;
  const Found found = verify(file::encode(mesh, records, kExactManifest));
  INFO(list_of(found));
  REQUIRE(found.size() == 1);
  CHECK(find(found, "volume of the header") != nullptr);
}

TEST_CASE("verification: records that are not in Morton order") {
  TetMesh mesh = grid({{6, 6, 6}, {}, 2, 1});
  const auto grid_vertices = static_cast<std::uint32_t>(mesh.vertex_count());
  mesh.positions.resize(grid_vertices + 4);
  for (PointArray& array : mesh.point_arrays)
    array.resize(grid_vertices + 4);
  const std::array<std::array<float, 3>, 4> alone{{{100, 0, 0}, {120, 0, 0}, {100, 16, 0}, {100, 0, 16}}};
  std::memcpy(mesh.positions.bytes.data() + grid_vertices * mesh.positions.row_bytes(), alone.data(), sizeof alone);
  mesh.tets.push_back(
      {VertexId{grid_vertices}, VertexId{grid_vertices + 1}, VertexId{grid_vertices + 2}, VertexId{grid_vertices + 3}});
  const Bytes good = file::encode(mesh, simplify_naively(mesh), kExactManifest);
  CHECK(verify(good).empty());

  // The outermost vertex, of a tet that no record touches, goes away along x, and with it the cells of all others.
  FileParts parts(good);
  const auto count = get<std::uint32_t>(parts.header, 16);
  Bytes& base = parts.of(file::SectionKind::kBase);
  std::vector<std::uint32_t> rank(count); // of x; stored as differences, in planes of bytes
  for (std::size_t row = 0; row < count; ++row)
    for (std::size_t plane = 0; plane < 4; ++plane)
      rank[row] += static_cast<std::uint32_t>(base[plane * count + row]) << (8 * plane);
  std::partial_sum(rank.begin(), rank.end(), rank.begin());
  const auto rank_of = [](float x) { return std::bit_cast<std::uint32_t>(x) | 0x80000000U; }; // of what is not negative
  const auto outermost = std::max_element(rank.begin(), rank.end());
  REQUIRE(*outermost == rank_of(120));
  *outermost = rank_of(300);
  std::adjacent_difference(rank.begin(), rank.end(), rank.begin());
  for (std::size_t row = 0; row < count; ++row)
    for (std::size_t plane = 0; plane < 4; ++plane)
      base[plane * count + row] = static_cast<std::byte>(rank[row] >> (8 * plane));
  const Bytes bad = parts.join();

  // Which records are out of place, bit by bit.
  file::Reader reader(file::over_memory(bad));
  file::Content content = reader.read_base();
  std::vector<std::uint32_t> all(reader.blocks().size());
  std::iota(all.begin(), all.end(), 0U);
  reader.load(all, content);
  Point least = mesh.position(VertexId{0}), greatest = least;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], content.positions.value(v, axis));
      greatest[axis] = std::max(greatest[axis], content.positions.value(v, axis));
    }
  }
  REQUIRE(greatest[0] == 300);
  const auto code_of = [&](std::uint32_t record) {
    std::uint64_t code = 0;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const double from_least = content.positions.value(count + record, axis) - least[axis];
      const auto cell = static_cast<std::uint64_t>(from_least / (greatest[0] - least[0]) * 0x1FFFFF);
      for (unsigned bit = 0; bit < 21; ++bit)
        code += (cell >> bit & 1) << (3 * bit + axis);
    }
    return code;
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> out_of_place; // block, its first such record
  for (std::uint32_t b = 0; b < all.size(); ++b) {
    const file::BlockInfo& block = reader.blocks()[b];
    for (std::uint32_t r = block.first_record + block.record_count - 1; r > block.first_record; --r) {
      if (content.generation[r] != content.generation[r - 1] || code_of(r) >= code_of(r - 1)) continue;
      if (!out_of_place.empty() && out_of_place.back().first == b) out_of_place.pop_back();
      out_of_place.emplace_back(b, r);
    }
  }
  REQUIRE(!out_of_place.empty());
  Found found = verify(bad);
  INFO(list_of(found));
  for (const char* const other : {"bounding box of the header", "diagonal of the header"})
    CHECK(std::erase_if(found, [&](const auto& of) { return of.what.find(other) != std::string::npos; }) == 1);
  REQUIRE(found.size() == out_of_place.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(find({found[i]}, "not in Morton order") != nullptr);
    CHECK(std::pair(found[i].block, found[i].record) ==
          std::pair(std::optional(out_of_place[i].first), std::optional(out_of_place[i].second)));
    CHECK(found[i].offset == reader.blocks()[out_of_place[i].first].offset);
  }
}

TEST_CASE("verification: a point of no tet, wherever it is, does not change the order of the records") {
  TetMesh mesh = grid({{6, 6, 6}, {}, 2, 1});
  const std::size_t used = mesh.vertex_count();
  mesh.positions.resize(used + 1);
  for (PointArray& array : mesh.point_arrays)
    array.resize(used + 1);
  const Bytes near = file::encode(mesh, simplify_naively(mesh), kExactManifest);
  const float far = 1e30F;
  std::memcpy(mesh.positions.bytes.data() + used * mesh.positions.row_bytes(), &far, sizeof far);
  const Bytes with_far = file::encode(mesh, simplify_naively(mesh), kExactManifest);
  CHECK(verify(with_far).empty());
  const auto positions_of_records = [](const Bytes& bytes) {
    file::Reader reader(file::over_memory(bytes));
    file::Content content = reader.read_base();
    std::vector<std::uint32_t> all(reader.blocks().size());
    std::iota(all.begin(), all.end(), 0U);
    reader.load(all, content);
    const std::size_t base = reader.header().base_vertex_count * content.positions.row_bytes();
    return Bytes(content.positions.bytes.begin() + static_cast<std::ptrdiff_t>(base), content.positions.bytes.end());
  };
  CHECK((positions_of_records(near) == positions_of_records(with_far)));
}

TEST_CASE("verification: a table that is not that of its blocks") {
  const Bytes good = sample_file();
  struct Way {
    const char* says;
    std::function<void(file::BlockInfo&)> change;
  };
  const Way ways[] = {
      {"bounding box is not", [](file::BlockInfo& b) { b.box_min[1] = b.box_max[1]; }},
      {"errors are not those", [](file::BlockInfo& b) { b.max_error[0] += 1; }},
      {"own errors are not those", [](file::BlockInfo& b) { b.max_own[0] -= 1; }},
      {"squared errors are not", [](file::BlockInfo& b) { b.squared_error[0] += 1; }},
  };
  for (const Way& way : ways) {
    const Found found = verify(with_rows(good, [&](auto& rows) { way.change(rows[1].info); }));
    INFO(way.says << "; " << list_of(found));
    REQUIRE(found.size() == 1);
    CHECK(find(found, way.says) != nullptr);
    CHECK(found[0].block == 1);
  }
  std::vector<std::string> notes;
  const Found found = verify(with_rows(good,
                                       [&](auto& rows) {
                                         REQUIRE(rows[0].info.needs.empty());
                                         rows[0].info.max_error[1] = 2048; // out of range, and not that of its records
                                       }),
                             &notes);
  INFO(list_of(found));
  CHECK(find(found, "max_error is out of range") != nullptr);
  CHECK(find(found, "errors are not those") != nullptr);
  CHECK(found.size() == 2);
}

TEST_CASE("verification: a block that makes fewer tets than the table says") {
  FileParts parts(sample_file());
  auto rows = parts.rows();
  rows[1].version_count += 1;
  parts.set_rows(rows);
  put(parts.header, 40, get<std::uint64_t>(parts.header, 40) + 1);
  const Found found = verify(parts.join());
  INFO(list_of(found));
  REQUIRE(found.size() == 1);
  CHECK(find(found, "makes fewer tets than the table says") != nullptr);
  CHECK(found[0].block == 1);
}

TEST_CASE("verification: a damaged block leaves the others to be looked at") {
  const Bytes good = sample_file();
  const Chosen chosen = choose(good);
  FileParts parts(good);
  const auto rows = parts.rows();
  const auto damage = [&](std::uint32_t block) {
    Bytes& blocks = parts.of(file::SectionKind::kBlocks);
    blocks[rows[block].info.offset + rows[block].info.stored_bytes / 2] ^= std::byte{255};
  };
  damage(chosen.leaf);
  Found found = verify(parts.join());
  INFO(list_of(found));
  REQUIRE(found.size() == 1);
  CHECK(find(found, "hash of a block") != nullptr);
  CHECK(found[0].block == chosen.leaf);
  CHECK(found[0].offset.has_value());

  // With another one that is needed, and the rest of a table row wrong.
  damage(chosen.needed);
  auto changed = rows;
  const auto other = static_cast<std::uint32_t>(
      std::find_if(rows.begin(), rows.end(), [&](const file::TableRow& row) { return row.info.needs.empty(); }) -
      rows.begin());
  if (other != chosen.needed && other != chosen.leaf) {
    changed[other].info.box_max[0] = changed[other].info.box_min[0];
    parts.set_rows(changed);
  }
  std::vector<std::string> notes;
  found = verify(parts.join(), &notes);
  INFO(list_of(found));
  CHECK(std::count_if(found.begin(), found.end(), [](const auto& v) { return v.what.find("hash of a block") == 4; }) ==
        2);
  CHECK(std::any_of(notes.begin(), notes.end(), [](const auto& n) { return n.find("not decoded") != n.npos; }));
  if (other != chosen.needed && other != chosen.leaf) CHECK(find(found, "bounding box is not") != nullptr);
}

TEST_CASE("verification: many findings in one file, all of them") {
  FileParts parts(sample_file());
  parts.of(file::SectionKind::kManifest).push_back(std::byte{0});
  parts.sections.push_back({77, file::kMandatory, 0, 0, 0, 0});
  parts.raw.push_back(Bytes(5, std::byte{42}));
  auto rows = parts.rows();
  rows[0].info.box_min[2] = rows[0].info.box_max[2];
  rows[1].info.squared_error[1] += 1;
  rows[2].info.max_error.back() += 1;
  parts.set_rows(rows);
  put<std::uint32_t>(parts.header, 12, 5);
  put<std::uint16_t>(parts.header, 54, 0x21);
  Bytes bytes = parts.join();
  put(bytes, 120, std::uint64_t{0});
  put<std::uint32_t>(bytes, bytes.size() - 28, 9);
  const Found found = verify(bytes);
  INFO(list_of(found));
  for (const char* const says :
       {"reserved is 5", "reserved flag is set", "header's hash", "reserved is 9", "section 77", "too many",
        "bounding box is not", "squared errors are not", "errors are not those"})
    CHECK(find(found, says) != nullptr);
  CHECK(found.size() == 9);
}

TEST_CASE("verification: what a reader refuses has a finding, whatever the damage") {
  const TetMesh mesh = grid({{4, 4, 4}, {}, 2, 1});
  RecordStream records = simplify_naively(mesh);
  add_random_dependencies(records, 6);
  add_random_squared_errors(records, 6);
  const Bytes good = file::encode(mesh, records, kExactManifest);
  std::mt19937_64 random(3);
  std::size_t refused = 0;
  for (int i = 0; i < 300; ++i) {
    FileParts parts(good);
    const std::size_t which = random() % (parts.raw.size() + 1);
    Bytes& part = which == parts.raw.size() ? parts.header : parts.raw[which];
    for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips)
      flip(part, random() % (8 * part.size()));
    try {
      if (which < parts.raw.size() && FileParts::is(parts.sections[which], file::SectionKind::kBlocks))
        parts.mend_blocks();
    } catch (const Error&) {
    }
    Bytes bytes = parts.join();
    if (i % 4 == 0) flip(bytes, random() % (8 * bytes.size()));
    bool is_refused = false;
    try {
      file::Reader reader(file::over_memory(bytes));
      file::Content content = reader.read_base();
      std::vector<std::uint32_t> all(reader.blocks().size());
      for (std::uint32_t b = 0; b < all.size(); ++b)
        all[b] = b;
      reader.load(all, content);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruptFile) continue;
      is_refused = true;
    }
    refused += is_refused ? 1 : 0;
    if (is_refused && verify(bytes).empty()) FAIL("try " << i);
  }
  CHECK(refused > 100);
}

TEST_CASE("verification: an inverted tet, and the record that makes it") {
  TetMesh mesh = grid({{4, 4, 4}, {}, 2, 1});
  RecordStream records = simplify_naively(mesh);
  // The first vertex that is removed goes far away: all of its tets but some are inverted.
  const std::uint32_t moved = records.removed[0].index();
  const float far[3] = {1000, 1000, 1000};
  std::memcpy(mesh.positions.bytes.data() + moved * std::size_t{12}, far, 12);
  const auto is_inverted = [](const PointArray& positions, const Tet& tet) {
    if (std::find(tet.begin(), tet.end(), kDummyVertex) != tet.end()) return false;
    float at[4][3];
    for (std::size_t i = 0; i < 4; ++i)
      std::memcpy(at[i], positions.bytes.data() + tet[i].index() * std::size_t{12}, 12);
    double m[3][3];
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        m[i][k] = double{at[i + 1][k]} - double{at[0][k]};
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]) <
           0;
  };
  std::size_t inverted = 0;
  const std::vector<Tet> original = records.original();
  for (const std::uint32_t slot : records.star(0))
    inverted += is_inverted(mesh.positions, original[slot]) ? 1 : 0;
  REQUIRE(inverted > 0);
  const Bytes bytes = file::encode(mesh, records, kExactManifest);
  const Found found = verify(bytes);
  INFO(list_of(found));
  const auto count = std::count_if(found.begin(), found.end(),
                                   [](const auto& v) { return v.what.find("is inverted") != v.what.npos; });
  CHECK(static_cast<std::size_t>(count) == inverted);
  const file::Violation* const first = find(found, "is inverted");
  REQUIRE(first != nullptr);
  CHECK(first->record.has_value());
  CHECK(first->version.has_value());

  // Versions are counted as the help of `ptet verify` says: those of the base, then what each record makes.
  const file::Verified verified = file::verify(file::over_memory(bytes), [](const file::Violation&) {});
  REQUIRE(verified.content);
  const file::Content& content = *verified.content;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> wanted, told; // record, version
  std::uint32_t number = content.refinement.base_place_count();
  for (std::uint32_t r = 0; r < content.refinement.record_count(); ++r)
    for (const Tet& tet : content.refinement.fine_tets(RecordId{r})) {
      if (is_inverted(content.positions, tet)) wanted.emplace_back(r, number);
      ++number;
    }
  for (const file::Violation& violation : found)
    if (violation.what.find("is inverted") != violation.what.npos && violation.record && violation.version)
      told.emplace_back(*violation.record, *violation.version);
  CHECK(told == wanted);
}

TEST_CASE("verification: stated errors are true where layers pinch out") {
  for (const unsigned seed : {1U, 77U, 131U}) {
    INFO(seed);
    PreparedMesh prepared = prepare(pinched_layers(seed));
    BuildOptions options;
    options.target_vertices = 0;
    BuildReport report;
    const RecordStream records = build::build_records(prepared, options, report, {});
    const Found found = all_checked(prepared.mesh, records);
    INFO(list_of(found));
    CHECK(found.empty());
  }
}

TEST_CASE("verification: stated errors that are not true") {
  PreparedMesh prepared = prepare(grid({{4, 4, 4}, {}, 3, 4}));
  BuildOptions options;
  options.fields = {"pressure", "flow"};
  options.target_vertices = 0.1;
  options.max_domain_error = {0.3, true};
  BuildReport report;
  const RecordStream records = build::build_records(prepared, options, report, {});
  const std::size_t fields = records.fields.size();
  REQUIRE(fields == 2);
  const auto check = [&](const RecordStream& stream, std::uint64_t samples, file::StatedErrors* result = nullptr,
                         const char* evaluate = "exact") {
    Found found;
    const auto tell = [&](const file::Violation& violation) { found.push_back(violation); };
    const file::Manifest manifest{"0.1.0", "sample", "", {{"evaluate", evaluate}}, {}};
    const file::Verified verified =
        file::verify(file::over_memory(file::encode(prepared.mesh, stream, manifest)), tell);
    REQUIRE(found.empty());
    const file::StatedErrors errors = file::check_stated_errors(verified, samples, tell);
    if (result != nullptr) *result = errors;
    return found;
  };
  file::StatedErrors all;
  Found found = check(records, 0, &all);
  INFO(list_of(found));
  CHECK(found.empty());
  CHECK(all.records == records.size());
  CHECK(all.errors[0].most > 0);
  CHECK(check(records, 10, &all).empty());
  CHECK(all.records == 10);

  // The largest of each kind is stated too small, the monotone ones following.
  const auto spoiled = [&](const std::function<void(RecordStream&)>& spoil) {
    RecordStream stream = records;
    spoil(stream);
    return stream;
  };
  std::size_t worst = 0;
  for (std::size_t r = 0; r < records.size(); ++r)
    if (records.field_error[r * fields] > records.field_error[worst * fields]) worst = r;
  const RecordStream lower = spoiled([&](RecordStream& s) { s.field_error[worst * fields] *= 0.5; });
  found = check(lower, 0, &all);
  REQUIRE(found.size() == 1);
  CHECK(find(found, "error of 'pressure' is above") != nullptr);
  CHECK(found[0].record.has_value());
  CHECK(all.errors[0].above == 1);
  CHECK(all.errors[0].most_above > 1.8);
  CHECK(all.errors[0].most_above < 2.2);
  CHECK(check(lower, 0, &all, "vertices").empty()); // no bounds, so no violation
  CHECK(all.errors[0].above == 1);

  // Seen is only how far the faces are from the original boundary; some stand for what is far from them.
  std::size_t moving = 0, noticed = 0;
  for (std::size_t r = 0; r < records.size(); ++r) {
    if (records.domain_error[r] == 0) continue;
    ++moving;
    found = check(spoiled([&](RecordStream& s) { s.domain_error[r] *= 0.25; }), 0);
    if (found.empty()) continue;
    INFO(list_of(found));
    REQUIRE(found.size() == 1);
    CHECK(find(found, "domain error is above") != nullptr);
    ++noticed;
  }
  CHECK(2 * noticed > moving);

  found = check(spoiled([&](RecordStream& s) { s.squared_error[worst * fields + 1] *= 1.5; }), 0);
  INFO(list_of(found));
  REQUIRE(found.size() == 1);
  CHECK(find(found, "squared error of 'flow' is not") != nullptr);

  const auto most =
      static_cast<std::size_t>(std::max_element(records.uncovered_volume.begin(), records.uncovered_volume.end()) -
                               records.uncovered_volume.begin());
  REQUIRE(records.uncovered_volume[most] > 0);
  for (const double factor : {0.5, 1.5}) {
    found = check(spoiled([&](RecordStream& s) { s.uncovered_volume[most] *= factor; }), 0);
    INFO(list_of(found));
    REQUIRE(found.size() == 1);
    CHECK(find(found, "what it uncovers is not the volume stated") != nullptr);
  }
}

TEST_CASE("verification: a huge value elsewhere hides no squared error") {
  TetMesh mesh = grid({{4, 4, 4}, {}, 3, 4});
  test::add_array(mesh, "filled", ScalarType::kFloat64, 1,
                  [](const Point& p) { return std::vector<double>{std::sin(0.05 * p[0]) + 1e-4 * p[1] * p[2]}; });
  const double fill = 1e15;
  std::memcpy(mesh.point_arrays.back().bytes.data(), &fill, sizeof fill);
  PreparedMesh prepared = prepare(mesh);
  BuildOptions options;
  options.fields = {"filled"};
  options.target_vertices = 0.1;
  options.max_domain_error = {0.3, true};
  BuildReport report;
  RecordStream records = build::build_records(prepared, options, report, {});
  const auto check = [&] { return all_checked(prepared.mesh, records); };
  const Found sound = check();
  INFO(list_of(sound));
  CHECK(sound.empty());
  std::size_t spoiled = 0;
  while (!(records.squared_error[spoiled] > 1 && records.squared_error[spoiled] < 1e6))
    ++spoiled;
  records.squared_error[spoiled] *= 1.5;
  const Found found = check();
  INFO(list_of(found));
  REQUIRE(found.size() == 1);
  CHECK(find(found, "squared error of 'filled' is not") != nullptr);
}

TEST_CASE("verification: of an original that overlaps itself, too, what is stated is what is measured") {
  TetMesh mesh = grid({{5, 5, 5}, {}, 3, 4});
  const std::uint32_t of_one = mesh.vertex_count();
  std::vector<float> coordinates;
  for (const float shift : {0.0F, 37.0F}) // two and a bit of five cells
    for (std::uint32_t v = 0; v < of_one; ++v)
      for (const double x : mesh.position(VertexId{v}))
        coordinates.push_back(static_cast<float>(x) + shift);
  mesh.positions.bytes.resize(coordinates.size() * sizeof(float));
  std::memcpy(mesh.positions.bytes.data(), coordinates.data(), mesh.positions.bytes.size());
  for (PointArray& array : mesh.point_arrays) {
    const std::vector<std::byte> once = array.bytes;
    array.bytes.insert(array.bytes.end(), once.begin(), once.end());
  }
  const std::vector<Tet> once = mesh.tets;
  for (Tet tet : once) {
    for (VertexId& v : tet)
      v = VertexId{v.index() + of_one};
    mesh.tets.push_back(tet);
  }
  PreparedMesh prepared = prepare(mesh);
  BuildOptions options;
  options.fields = {"pressure"};
  options.target_vertices = 0.05;
  options.max_domain_error = {0.3, true};
  for (const Prediction prediction : {Prediction::kExact, Prediction::kQuadric}) {
    options.prediction = prediction;
    BuildReport report;
    const RecordStream records = build::build_records(prepared, options, report, {});
    REQUIRE(records.size() > 100);
    const Found found = all_checked(prepared.mesh, records);
    INFO(list_of(found));
    CHECK(found.empty());
    CHECK(std::accumulate(records.uncovered_volume.begin(), records.uncovered_volume.end(), 0.0) >= 0);
  }
}

TEST_CASE("verification: rounding is no error, far from the origin and in flat tets") {
  const auto transformed = [](const std::function<Point(const Point&)>& to) {
    TetMesh mesh = grid({{5, 5, 4}, {}, 0, 4});
    std::vector<double> coordinates;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      for (const double x : to(mesh.position(VertexId{v})))
        coordinates.push_back(x);
    mesh.positions.type = ScalarType::kFloat64;
    mesh.positions.bytes.resize(coordinates.size() * sizeof(double));
    std::memcpy(mesh.positions.bytes.data(), coordinates.data(), mesh.positions.bytes.size());
    return mesh;
  };
  BuildOptions options;
  options.fields = {"pressure", "flow"};
  options.target_vertices = 0.1;
  options.max_domain_error = {0.3, true};
  options.min_quality = 0;
  // Easting and northing in metres; further still; a plate around the origin.
  const std::vector<std::function<Point(const Point&)>> placings = {
      [](const Point& p) {
        return Point{0.37 * p[0] + 4.5e5, 0.41 * p[1] + 5e6, 0.39 * p[2]};
      },
      [](const Point& p) {
        return Point{p[0] / 8 + 1e9, p[1] / 8 - 1e9, p[2] / 8 + 2e9};
      },
      [](const Point& p) {
        return Point{0.8 * p[0] - 0.6e-9 * p[2], p[1], 0.6 * p[0] + 0.8e-9 * p[2]};
      }};
  for (std::size_t i = 0; i < placings.size(); ++i) {
    INFO("placing " << i);
    PreparedMesh prepared = prepare(transformed(placings[i]));
    BuildReport report;
    const RecordStream records = build::build_records(prepared, options, report, {});
    REQUIRE(records.size() > 20);
    const Found found = all_checked(prepared.mesh, records);
    INFO(list_of(found));
    CHECK(found.empty());
  }
}
