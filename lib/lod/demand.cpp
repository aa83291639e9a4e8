#include "lod/demand.hpp"

#include "lod/region.hpp"

#include <algorithm>

namespace ptet {

BlockDemand Demand::focus_of(const file::BlockInfo& block) const {
  // Own errors are no larger than the monotone ones that the table knows.
  if (!request_.focus_limits.empty() && !exceeds(block.max_error.data(), request_.focus_limits))
    return BlockDemand::kNone;
  BlockDemand demand = BlockDemand::kNone;
  for (const FocusRegion& region : request_.focus) {
    if (!meets(region, block.box_min, block.box_max)) continue;
    if (request_.focus_limits.empty() && contains(region, block.box_min, block.box_max)) return BlockDemand::kAll;
    demand = BlockDemand::kSome;
  }
  return demand;
}

// Where no bound is given but a budget to spend, or nothing at all is asked, every record.
BlockDemand Demand::asked_of(const file::BlockInfo& block) const {
  if (request_.has_bounds())
    return exceeds(block.max_error.data(), request_.limits) ? BlockDemand::kSome : BlockDemand::kNone;
  return request_.has_budget() || request_.is_original() ? BlockDemand::kAll : BlockDemand::kNone;
}

bool Demand::is_in_focus(RecordId r) const {
  const file::Content& content = hierarchy_.content();
  if (!request_.focus_limits.empty() &&
      !exceeds(content.own.data() + r.index() * request_.focus_limits.size(), request_.focus_limits))
    return false;
  const auto [min, max] = hierarchy_.star_box(r);
  return std::any_of(request_.focus.begin(), request_.focus.end(), [&](const FocusRegion& region) {
    if (!meets(region, min, max)) return false;
    const Point v = hierarchy_.position(hierarchy_.content().refinement.vertex_of(r));
    return contains(region, v, v) || star_meets(region, r);
  });
}

// The tets that the collapse made, C(r), must not be in the region. Nor may those that it consumed, F(r), be missing
// there: where the boundary has moved they cover more.
bool Demand::star_meets(const FocusRegion& region, RecordId r) const {
  const Refinement& refinement = hierarchy_.content().refinement;
  const VertexId u = refinement.target(r), v = refinement.vertex_of(r);
  for (std::size_t k = 0; k < refinement.modified(r).size(); ++k) {
    const auto [a, b, c] = refinement.link_triangle(r, k);
    if (tet_meets(region, {v, a, b, c}) || tet_meets(region, {u, a, b, c})) return true;
  }
  const auto rim = refinement.rim(r);
  for (std::size_t i = 0; i < rim.size(); ++i)
    if (tet_meets(region, {v, u, rim[i], rim[i + 1 < rim.size() ? i + 1 : 0]})) return true;
  return false;
}

bool Demand::tet_meets(const FocusRegion& region, const Tet& tet) const {
  std::array<Point, 4> corners;
  std::size_t count = 0;
  for (const VertexId v : tet)
    if (v != kDummyVertex) corners[count++] = hierarchy_.position(v);
  return meets(region, std::span(corners.data(), count));
}

} // namespace ptet
