#include "lod/budget.hpp"

#include <algorithm>

namespace ptet {
namespace {

constexpr std::uint64_t kTetBytes = sizeof(Tet);
constexpr std::uint64_t kFaceBytes = sizeof(std::array<VertexId, 3>);

} // namespace

// What a split adds stands around its edge, a tet or a face for each vertex of the rim. Only counts are looked at.
AddedSize added_by(const Refinement& refinement, RecordId r) {
  const std::uint32_t tets = refinement.added_tet_count(r);
  return {1, tets, refinement.rim(r).size() - tets};
}

Budget::Budget(const Hierarchy& hierarchy, const Budgets& budgets)
    : hierarchy_(hierarchy), budgets_(budgets), vertex_bytes_(file::vertex_bytes(hierarchy.header())) {}

std::uint64_t Budget::tets(const AddedSize& size) const {
  return hierarchy_.header().base_tet_count + size.tets;
}

bool Budget::fits(const AddedSize& size) const {
  const file::Header& header = hierarchy_.header();
  // The last split makes it the original, which has the vertices without tets too.
  const std::uint64_t vertices =
      size.records +
      (size.records == header.record_count ? header.base_vertex_count : hierarchy_.used_base_vertex_count());
  return !(budgets_.max_tets && tets(size) > *budgets_.max_tets) &&
         !(budgets_.max_vertices && vertices > *budgets_.max_vertices) &&
         !(budgets_.max_bytes && vertices * vertex_bytes_ + tets(size) * kTetBytes +
                                         (hierarchy_.base_face_count() + size.faces) * kFaceBytes >
                                     *budgets_.max_bytes);
}

std::uint64_t Budget::expected_records(const AddedSize& spent) const {
  constexpr std::uint64_t kTetsPerVertex = 5;
  std::uint64_t expected = ~std::uint64_t{0} / 4;
  const auto above = [](std::uint64_t value, std::uint64_t base) { return value > base ? value - base : 0; };
  if (budgets_.max_vertices)
    expected = std::min(expected, above(*budgets_.max_vertices, hierarchy_.used_base_vertex_count() + spent.records));
  if (budgets_.max_tets) expected = std::min(expected, above(*budgets_.max_tets, tets(spent)) / kTetsPerVertex);
  if (budgets_.max_bytes)
    expected = std::min(expected, *budgets_.max_bytes / (vertex_bytes_ + kTetsPerVertex * kTetBytes));
  return expected + 1;
}

OrderCode Budget::key_of_rank(const BlocksByOrder& blocks, std::uint64_t rank) const {
  std::uint64_t records = 0;
  for (const auto& [key, b] : blocks)
    if ((records += hierarchy_.blocks()[b].record_count) >= rank) return key;
  return 0;
}

} // namespace ptet
