#include "lod/extraction.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace ptet {
namespace {

constexpr std::uint32_t kUnused = VertexId::kNone;

// What is known of a record that is not in the cut.
constexpr char kMadeTet = 1;  ///< a tet of the mesh is of its C(r)
constexpr char kMadeFace = 2; ///< a boundary face is

/// The versions of the mesh, in output order.
struct Present {
  std::vector<std::uint32_t> tets, ghosts;
  std::vector<char> made; ///< by record
};

Present find_present(const Refinement& refinement, const Cut& cut) {
  Present present;
  present.made.assign(cut.applied.size(), 0);
  std::size_t tet_count = refinement.base_tet_count();
  for (std::uint32_t r = 0; r < cut.applied.size(); ++r)
    if (cut.applied[r] != 0) tet_count += refinement.added_tet_count(RecordId{r});
  present.tets.reserve(tet_count);
  const auto add = [&](std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t t = first; t < first + count; ++t) {
      const RecordId creator = refinement.creator(VersionId{t});
      if (!creator.is_none() && cut.applied[creator.index()] != 0) continue;
      const bool is_ghost = refinement.is_ghost(VersionId{t});
      (is_ghost ? present.ghosts : present.tets).push_back(t);
      if (!creator.is_none()) present.made[creator.index()] |= is_ghost ? kMadeFace : kMadeTet;
    }
  };
  add(0, refinement.base_version_count());
  for (std::uint32_t r = 0; r < cut.applied.size(); ++r)
    if (cut.applied[r] != 0) add(refinement.first_fine(RecordId{r}).index(), refinement.fine_count(RecordId{r}));
  return present;
}

/// Numbers the vertices that are to be put out; returns their file ids.
std::vector<VertexId> number_vertices(const Refinement& refinement, const Present& present, bool all,
                                      std::vector<std::uint32_t>& row) {
  row.assign(refinement.base_vertex_count() + std::size_t{refinement.record_count()}, all ? 0 : kUnused);
  if (!all)
    for (const std::uint32_t t : present.tets)
      for (const VertexId v : refinement.vertices(VersionId{t}))
        row[v.index()] = 0;
  std::vector<VertexId> in_file;
  in_file.reserve(static_cast<std::size_t>(std::count(row.begin(), row.end(), 0U)));
  for (std::uint32_t v = 0; v < row.size(); ++v)
    if (row[v] != kUnused) {
      row[v] = static_cast<std::uint32_t>(in_file.size());
      in_file.emplace_back(v);
    }
  return in_file;
}

/// The rows of the vertices; runs of neighbours are copied at once.
PointArray gather(const PointArray& from, const std::vector<VertexId>& vertices) {
  PointArray to{from.name, from.type, from.components, {}};
  to.resize(vertices.size());
  const std::size_t row_bytes = from.row_bytes();
  for (std::size_t begin = 0; begin < vertices.size();) {
    std::size_t end = begin + 1;
    while (end < vertices.size() && vertices[end].index() == vertices[end - 1].index() + 1)
      ++end;
    std::memcpy(to.bytes.data() + begin * row_bytes, from.bytes.data() + vertices[begin].index() * row_bytes,
                (end - begin) * row_bytes);
    begin = end;
  }
  return to;
}

// Codes: of the records known to have made something of the mesh, their own; of blocks not read, the largest.
std::vector<ErrorCode16> achieved_codes(const Hierarchy& hierarchy, const Cut& cut, const Present& present) {
  const file::Content& content = hierarchy.content();
  const std::size_t count = content.errors_per_record, domain = count - 1;
  std::vector<ErrorCode16> achieved(count, 0);
  for (std::size_t b = 0; b < hierarchy.blocks().size(); ++b) {
    const file::BlockInfo& block = hierarchy.blocks()[b];
    if (cut.read[b] == 0) {
      for (std::size_t i = 0; i < count; ++i)
        achieved[i] = std::max(achieved[i], block.max_error[i]);
      continue;
    }
    for (std::uint32_t r = block.first_record; r < block.first_record + block.record_count; ++r) {
      const ErrorCode16* const own = content.own.data() + r * count;
      if ((present.made[r] & kMadeTet) != 0)
        for (std::size_t i = 0; i < domain; ++i)
          achieved[i] = std::max(achieved[i], own[i]);
      if ((present.made[r] & kMadeFace) != 0) achieved[domain] = std::max(achieved[domain], own[domain]);
    }
  }
  return achieved;
}

} // namespace

void SquaredErrorSum::add(double x) {
  sum_ += x;
  magnitude_ += std::fabs(x);
  ++count_;
}

SquaredErrorSum& SquaredErrorSum::operator+=(const SquaredErrorSum& other) {
  sum_ += other.sum_;
  magnitude_ += other.magnitude_;
  count_ += other.count_;
  return *this;
}

double SquaredErrorSum::root(double range) const {
  // However they were gathered, each number went through fewer additions than there are numbers.
  const double slack = magnitude_ * (static_cast<double>(count_) * std::numeric_limits<double>::epsilon());
  return range * std::sqrt(std::max(0.0, sum_ + slack));
}

// The collapses that are not undone, each by what it raised the integral. Where a block has none undone its sum is in
// the table, so the answer does not depend on what was read.
void sum_squared_errors(const Hierarchy& hierarchy, const std::vector<char>& applied, std::size_t block,
                        std::span<SquaredErrorSum> sums) {
  const file::BlockInfo& info = hierarchy.blocks()[block];
  const std::vector<SquaredErrorCode>& codes = hierarchy.content().squared_error;
  std::fill(sums.begin(), sums.end(), SquaredErrorSum{});
  const char* const first = applied.data() + info.first_record;
  const auto undone = static_cast<std::uint32_t>(std::count(first, first + info.record_count, 1));
  if (undone == info.record_count) return;
  if (undone == 0) {
    for (std::size_t i = 0; i < sums.size(); ++i)
      sums[i].add(info.squared_error[i]);
    return;
  }
  for (std::size_t r = info.first_record; r < info.first_record + info.record_count; ++r)
    for (std::size_t i = 0; i < sums.size() && applied[r] == 0; ++i)
      sums[i].add(decode_squared_error(codes[r * sums.size() + i]));
}

std::vector<double> rms_error(const Hierarchy& hierarchy, const std::vector<char>& applied) {
  if (!hierarchy.header().has_squared_errors) return {};
  std::vector<SquaredErrorSum> totals(hierarchy.errors_per_record() - std::size_t{1}), sums(totals.size());
  for (std::size_t b = 0; b < hierarchy.blocks().size(); ++b) {
    sum_squared_errors(hierarchy, applied, b, sums);
    for (std::size_t i = 0; i < sums.size(); ++i)
      totals[i] += sums[i];
  }
  std::vector<double> result;
  for (const file::ArrayInfo& array : hierarchy.header().arrays)
    if (array.governing) result.push_back(totals[result.size()].root(array.range));
  return result;
}

Extraction extract_cut(const Hierarchy& hierarchy, const Cut& cut, bool with_origins) {
  const file::Content& content = hierarchy.content();
  const Refinement& refinement = content.refinement;
  const Present present = find_present(refinement, cut);

  Extraction result;
  result.limited_by = cut.limited_by;
  std::vector<std::uint32_t> row;
  result.vertex_in_file = number_vertices(refinement, present, cut.count == cut.applied.size(), row);
  result.mesh.positions = gather(content.positions, result.vertex_in_file);
  for (const PointArray& array : content.arrays)
    result.mesh.point_arrays.push_back(gather(array, result.vertex_in_file));

  result.mesh.tets.resize(present.tets.size());
  for (std::size_t i = 0; i < present.tets.size(); ++i) {
    const Tet& tet = refinement.vertices(VersionId{present.tets[i]});
    for (std::size_t corner = 0; corner < 4; ++corner)
      result.mesh.tets[i][corner] = VertexId{row[tet[corner].index()]};
  }
  result.boundary_faces.reserve(present.ghosts.size());
  for (const std::uint32_t t : present.ghosts) {
    const Tet& ghost = refinement.vertices(VersionId{t});
    const auto at = static_cast<std::uint32_t>(std::find(ghost.begin(), ghost.end(), kDummyVertex) - ghost.begin());
    // (dummy, a, c, b) is an even permutation of the ghost, so (a, b, c) is seen from outside.
    result.boundary_faces.push_back({VertexId{row[ghost[at ^ 1U].index()]}, VertexId{row[ghost[at ^ 3U].index()]},
                                     VertexId{row[ghost[at ^ 2U].index()]}});
  }
  if (with_origins) {
    result.made_by.reserve(present.tets.size());
    for (const std::uint32_t t : present.tets)
      result.made_by.push_back(refinement.creator(VersionId{t}));
  }

  const std::vector<ErrorCode16> achieved = achieved_codes(hierarchy, cut, present);
  for (const file::ArrayInfo& array : hierarchy.header().arrays)
    if (array.governing) result.field_error.push_back(decode_error(achieved[result.field_error.size()], array.range));
  result.rms_error = rms_error(hierarchy, cut.applied);
  result.domain_error = decode_error(achieved.back(), hierarchy.header().diagonal);
  return result;
}

} // namespace ptet
