#include "support/file_checks.hpp"

#include "formats/ptet/writer.hpp"
#include "record/ghost.hpp"
#include "support/brute_force.hpp"
#include "support/mesh_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include <catch2/catch.hpp>

namespace ptet::test {
namespace {

using Row = std::string;

/// All bits of a vertex.
Row row_of(const TetMesh& mesh, VertexId v) {
  Row row;
  const auto append = [&](const PointArray& array) {
    const auto* from = reinterpret_cast<const char*>(array.bytes.data()) + v.index() * array.row_bytes();
    row.append(from, array.row_bytes());
  };
  append(mesh.positions);
  for (const PointArray& array : mesh.point_arrays)
    append(array);
  return row;
}

/// The rows of all vertices, ascending; and each tet by the places of its vertices there. Vertices that have all bits
/// in common cannot be told apart and need not be.
struct Canonical {
  std::vector<Row> rows;
  std::vector<Tet> tets;
  friend bool operator==(const Canonical&, const Canonical&) = default;
};

Canonical canonical(const TetMesh& mesh) {
  Canonical result;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    result.rows.push_back(row_of(mesh, VertexId{v}));
  std::vector<Row> sorted = result.rows;
  std::sort(sorted.begin(), sorted.end());
  for (Tet tet : mesh.tets) {
    for (VertexId& v : tet) {
      const auto place = std::lower_bound(sorted.begin(), sorted.end(), result.rows[v.index()]);
      v = VertexId{static_cast<std::uint32_t>(place - sorted.begin())};
    }
    result.tets.push_back(sorted_keeping_orientation(tet));
  }
  result.rows = std::move(sorted);
  std::sort(result.tets.begin(), result.tets.end());
  return result;
}

/// For each record of the stream that of the file; none where vertices repeat all bits and cannot be told apart.
std::vector<RecordId> match_records(const TetMesh& mesh, const RecordStream& records, const file::Header& header,
                                    const file::Content& content) {
  const TetMesh full = present_mesh(content);
  std::vector<std::pair<Row, std::uint32_t>> by_row;
  for (std::uint32_t r = 0; r < header.record_count; ++r) {
    by_row.emplace_back(row_of(full, content.refinement.vertex_of(RecordId{r})), r);
  }
  std::sort(by_row.begin(), by_row.end());
  std::vector<RecordId> in_file(records.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Row row = row_of(mesh, records.removed[i]);
    const auto found = std::lower_bound(by_row.begin(), by_row.end(), std::pair(row, std::uint32_t{0}));
    if (found == by_row.end() || found->first != row) continue;
    if (found + 1 != by_row.end() && (found + 1)->first == row) continue;
    in_file[i] = RecordId{found->second};
  }
  return in_file;
}

void check_parents(const RecordStream& records, const std::vector<RecordId>& in_file, const file::Content& content) {
  if (std::find(in_file.begin(), in_file.end(), RecordId{}) != in_file.end()) return;
  std::vector<std::vector<RecordId>> expected(records.size());
  std::vector<std::size_t> maker(records.slot_count(), records.size()); // by slot, of what it holds
  for (std::size_t i = 0; i < records.size(); ++i) {
    for (const std::uint32_t slot : records.star(i))
      if (maker[slot] != records.size()) expected[maker[slot]].push_back(in_file[i]);
    for (const std::uint32_t slot : records.modified(i))
      maker[slot] = i;
  }
  std::size_t different = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    for (const std::uint32_t other : records.others_needed(i))
      expected[i].push_back(in_file[other]);
    std::sort(expected[i].begin(), expected[i].end());
    expected[i].erase(std::unique(expected[i].begin(), expected[i].end()), expected[i].end());
    const auto parents = content.refinement.parents(in_file[i]);
    different += std::equal(parents.begin(), parents.end(), expected[i].begin(), expected[i].end()) ? 0 : 1;
  }
  CHECK(different == 0);
}

void check_errors(const RecordStream& records, const std::vector<RecordId>& in_file, const file::Header& header,
                  const file::Content& content) {
  std::size_t below = 0, far_above = 0;
  const std::size_t fields = records.fields.size();
  REQUIRE(content.squared_error.size() == records.squared_error.size() + records.uncovered_volume.size());
  REQUIRE(header.has_squared_errors == records.has_squared_errors());
  CHECK(header.volume == records.volume);
  const auto compare_squared = [&](double squared, SquaredErrorCode code, double range) {
    const double read = decode_squared_error(code) * range * range * records.volume;
    const double ulps = 1e-14 * std::fabs(squared);
    below += read < squared - ulps ? 1 : 0;
    far_above += read > (squared > 0 ? squared * 1.0906 : squared / 1.0906) + ulps ? 1 : 0;
  };
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (in_file[i].is_none()) continue;
    const ErrorCode16* codes = content.own.data() + in_file[i].index() * std::size_t{content.errors_per_record};
    const auto compare = [&](double error, ErrorCode16 code, double scale) {
      const double read = decode_error(code, scale);
      below += read < error ? 1 : 0;
      far_above += read > 1.05 * error ? 1 : 0;
    };
    std::size_t place = 0;
    for (std::uint32_t a = 0; a < header.arrays.size(); ++a) {
      for (std::size_t f = 0; f < fields; ++f) {
        if (records.fields[f].array != a) continue;
        if (!records.squared_error.empty())
          compare_squared(records.squared_error[i * fields + f],
                          content.squared_error[in_file[i].index() * (fields + 1) + place], header.arrays[a].range);
        below += decode_error(content.monotone[static_cast<std::size_t>(codes - content.own.data()) + place],
                              header.arrays[a].range) < records.largest_error(i, f)
                     ? 1
                     : 0;
        compare(records.field_error[i * fields + f], codes[place++], header.arrays[a].range);
      }
    }
    compare(records.domain_error[i], codes[place], header.diagonal);
    if (records.uncovered_volume.empty()) continue;
    const double uncovered = records.uncovered_volume[i];
    const auto code = content.squared_error[in_file[i].index() * (fields + 1) + fields];
    const double read = file::decode_sum(header, fields, fields + 1, code) * records.volume;
    const double ulps = 1e-14 * std::fabs(uncovered),
                 least = records.volume / 256 / static_cast<double>(records.size());
    below += read < uncovered - ulps ? 1 : 0;
    far_above +=
        read > std::max(uncovered > 0 ? uncovered * 1.0906 : uncovered / 1.0906, uncovered + least) + ulps ? 1 : 0;
  }
  CHECK(below == 0);
  CHECK(far_above == 0);
}

/// Order codes by their definition, where rounding does not decide.
void check_order(const RecordStream& records, const std::vector<RecordId>& in_file, std::size_t vertices,
                 const file::Content& content) {
  const std::vector<std::size_t> place = places_in_budgets(records);
  std::size_t different = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (in_file[i].is_none()) continue;
    const std::size_t split = vertices - records.size() + place[i] + 1;
    const double octaves = std::log2(static_cast<double>(vertices) / static_cast<double>(split));
    const int code = content.order[in_file[i].index()];
    different += code < 32 * octaves - 1e-9 || code >= 32 * octaves + 1 + 1e-9 ? 1 : 0;
  }
  CHECK(different == 0);
}

} // namespace

TetMesh present_mesh(const file::Content& content) {
  TetMesh mesh;
  mesh.positions = content.positions;
  mesh.point_arrays = content.arrays;
  for (std::uint32_t place = 0; place < content.refinement.place_count(); ++place)
    if (const Tet& tet = content.refinement.tet(place); !is_ghost(tet)) mesh.tets.push_back(tet);
  return mesh;
}

std::vector<std::uint32_t> closed_under_needs(const file::Reader& reader, std::vector<std::uint32_t> blocks) {
  std::vector<char> in(reader.blocks().size());
  for (const std::uint32_t b : blocks)
    in[b] = 1;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    for (const std::uint32_t needed : reader.blocks()[blocks[i]].needs) {
      if (in[needed] != 0) continue;
      in[needed] = 1;
      blocks.push_back(needed);
    }
  }
  std::sort(blocks.begin(), blocks.end());
  return blocks;
}

void check_round_trip(const TetMesh& mesh, const RecordStream& records) {
  const auto bytes = file::encode(mesh, records, {});
  file::Reader reader(file::over_memory(bytes));
  const file::Header& header = reader.header();
  REQUIRE(header.record_count == records.size());
  REQUIRE(header.tet_count == mesh.tets.size());
  REQUIRE(header.base_vertex_count + header.record_count == mesh.vertex_count());
  file::Content content = reader.read_base();
  CHECK(content.refinement.validate().empty());
  std::vector<std::uint32_t> every(header.block_count);
  for (std::uint32_t b = 0; b < every.size(); ++b)
    every[b] = b;
  reader.load(every, content);
  CHECK(content.refinement.validate().empty());
  CHECK(reader.bytes_read() == bytes.size());

  const TetMesh read = present_mesh(content);
  REQUIRE(read.point_arrays.size() == mesh.point_arrays.size());
  CHECK(read.positions.type == mesh.positions.type);
  for (std::size_t i = 0; i < read.point_arrays.size(); ++i) {
    CHECK(read.point_arrays[i].name == mesh.point_arrays[i].name);
    CHECK(read.point_arrays[i].type == mesh.point_arrays[i].type);
    CHECK(read.point_arrays[i].components == mesh.point_arrays[i].components);
  }
  CHECK(canonical(read) == canonical(mesh));
  const std::vector<RecordId> in_file = match_records(mesh, records, header, content);
  check_parents(records, in_file, content);
  check_errors(records, in_file, header, content);
  check_order(records, in_file, mesh.vertex_count(), content);
}

void check_same_records(const file::Reader& reader, const file::Content& all, const file::Content& some) {
  const auto same_row = [](const PointArray& a, const PointArray& b, std::size_t row) {
    return std::memcmp(a.bytes.data() + row * a.row_bytes(), b.bytes.data() + row * b.row_bytes(), a.row_bytes()) == 0;
  };
  std::size_t different = 0;
  for (std::uint32_t i = 0; i < reader.header().record_count; ++i) {
    const RecordId r{i};
    if (!some.refinement.applied(r)) continue;
    bool same = some.refinement.target(r) == all.refinement.target(r) &&
                some.refinement.fine_count(r) == all.refinement.fine_count(r) &&
                some.generation[i] == all.generation[i] && some.order[i] == all.order[i];
    same = same && all.refinement.fine_tets(r) == some.refinement.fine_tets(r);
    const auto all_parents = all.refinement.parents(r), some_parents = some.refinement.parents(r);
    same = same && std::equal(all_parents.begin(), all_parents.end(), some_parents.begin(), some_parents.end());
    const std::size_t row = all.refinement.vertex_of(r).index();
    same = same && same_row(all.positions, some.positions, row);
    for (std::size_t a = 0; a < all.arrays.size(); ++a)
      same = same && same_row(all.arrays[a], some.arrays[a], row);
    for (std::size_t c = i * std::size_t{all.errors_per_record}; c < (i + 1) * std::size_t{all.errors_per_record};
         ++c) {
      same = same && all.own[c] == some.own[c] && all.monotone[c] == some.monotone[c];
    }
    const std::size_t fields = all.squared_error.size() / reader.header().record_count;
    for (std::size_t c = i * fields; c < (i + 1) * fields; ++c)
      same = same && all.squared_error[c] == some.squared_error[c];
    different += same ? 0 : 1;
  }
  CHECK(different == 0);
}

} // namespace ptet::test
