#include "lod/budget.hpp"

#include <algorithm>

namespace ptet {

bool Budget::fits(const AddedSize& size) const {
  const file::Header& header = hierarchy_.header();
  // The last split makes it the original, which has the vertices without tets too.
  const std::uint64_t base_vertices =
      size.records == header.record_count ? header.base_vertex_count : hierarchy_.used_base_vertex_count();
  return !(request_.max_tets && header.base_tet_count + size.tets > *request_.max_tets) &&
         !(request_.max_vertices && base_vertices + size.records > *request_.max_vertices);
}

std::uint64_t Budget::expected_records() const {
  constexpr std::uint64_t kTetsPerVertex = 5;
  std::uint64_t expected = ~std::uint64_t{0} / 4;
  const auto above = [](std::uint64_t value, std::uint64_t base) { return value > base ? value - base : 0; };
  if (request_.max_vertices)
    expected = std::min(expected, above(*request_.max_vertices, hierarchy_.used_base_vertex_count()));
  if (request_.max_tets)
    expected = std::min(expected, above(*request_.max_tets, hierarchy_.header().base_tet_count) / kTetsPerVertex);
  return expected + 1;
}

OrderCode Budget::key_of_rank(const BlocksByOrder& blocks, std::uint64_t rank) const {
  std::uint64_t records = 0;
  for (const auto& [key, b] : blocks)
    if ((records += hierarchy_.blocks()[b].record_count) >= rank) return key;
  return 0;
}

} // namespace ptet
