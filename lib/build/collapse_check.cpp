#include "build/collapse_check.hpp"

#include "build/collapse_geometry.hpp"
#include "mesh/predicates.hpp"
#include "mesh/shape.hpp"

#include <algorithm>
#include <cmath>

namespace ptet::build {

CollapseCheck::CollapseCheck(const WorkingComplex& complex, const std::vector<Point>& positions, double min_quality,
                             std::uint32_t max_star)
    : complex_(complex), positions_(positions), min_quality_(static_cast<float>(min_quality)), max_star_(max_star),
      mark_(complex.vertex_count() + 1) {}

/// False as soon as a tet is found that vs -> vd would invert: most of what is refused is refused for that.
bool CollapseCheck::classify() {
  plan_.deleted.clear();
  plan_.modified.clear();
  plan_.moves_boundary = moves_along_boundary_ = false;
  plan_.height = 0;
  worst_old_ = 1;
  for (const SlotId s : complex_.star(plan_.vs)) {
    const Slot& slot = complex_.slot(s);
    const bool holds_vd = has_corner(slot.v, plan_.vd);
    (holds_vd ? plan_.deleted : plan_.modified).push_back(s);
    plan_.height = std::max(plan_.height, slot.height + 1);
    if (complex_.is_ghost(slot)) {
      plan_.moves_boundary = true;
      moves_along_boundary_ |= holds_vd;
    } else {
      if (!holds_vd && inverts(slot)) return false;
      worst_old_ = std::min(worst_old_, slot.quality);
    }
  }
  return true;
}

void CollapseCheck::mark_links() {
  plan_.link.clear();
  link_edges_.clear();
  const auto mark = [&](const Slot& slot, std::uint32_t as) {
    for (const Vertex x : slot.v) {
      if (x == plan_.vs) continue;
      if (!in_link_of_vs(x)) {
        mark_[x] = stamp_;
        if (x != complex_.dummy()) plan_.link.push_back({x, false, false});
      }
      mark_[x] |= as;
    }
  };
  for (const SlotId s : plan_.modified) {
    const Slot& slot = complex_.slot(s);
    mark(slot, plan_.moves_boundary && complex_.is_ghost(slot) ? kOnBoundary : 0);
  }
  for (const SlotId s : plan_.deleted) {
    const Slot& slot = complex_.slot(s);
    mark(slot, complex_.is_ghost(slot) ? kInLinkOfEdge | kOnBoundaryOfEdge : kInLinkOfEdge);
    Edge edge{};
    std::size_t i = 0;
    for (const Vertex x : slot.v)
      if (x != plan_.vs && x != plan_.vd) edge[i++] = x;
    link_edges_.push_back(edge);
  }
  mark_[plan_.vd] = stamp_; // not in the link of the edge
}

void CollapseCheck::find_joining() {
  for (LinkVertex& x : plan_.link) {
    const std::uint32_t mark = mark_[x.vertex];
    x.joins = (mark & kInLinkOfEdge) == 0;
    x.joins_on_boundary = (mark & (kOnBoundary | kOnBoundaryOfEdge)) == kOnBoundary;
  }
}

void CollapseCheck::common_edges(const Slot& slot, Vertex apex, std::vector<Edge>& into) const {
  // Edges of the slot's face opposite `apex` whose ends are both in Lk(e), but which are not themselves in Lk(e).
  Edge ends{};
  std::size_t count = 0;
  std::array<Vertex, 3> found{};
  for (const Vertex x : slot.v)
    if (x != apex && in_link_of_edge(x)) found[count++] = x;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = i + 1; j < count; ++j) {
      ends = {found[i], found[j]};
      const bool in_link = std::any_of(link_edges_.begin(), link_edges_.end(), [&](const Edge& e) {
        return (e[0] == ends[0] && e[1] == ends[1]) || (e[0] == ends[1] && e[1] == ends[0]);
      });
      if (!in_link) into.push_back({std::min(ends[0], ends[1]), std::max(ends[0], ends[1])});
    }
}

bool CollapseCheck::link_condition() {
  const Vertex vs = plan_.vs, vd = plan_.vd;
  const auto has_link_triangle = [&](const Slot& slot, Vertex apex) {
    return std::all_of(slot.v.begin(), slot.v.end(), [&](Vertex x) { return x == apex || in_link_of_edge(x); });
  };
  chords_.clear();
  // A triangle in both links with no common chord has all its edges in Lk(e), which then is its border.
  bool vs_has_triangle = false;
  for (const SlotId s : plan_.modified) {
    common_edges(complex_.slot(s), vs, chords_);
    vs_has_triangle |= link_edges_.size() == 3 && has_link_triangle(complex_.slot(s), vs);
  }
  for (const SlotId s : complex_.star(vd)) {
    const Slot& slot = complex_.slot(s);
    if (has_corner(slot.v, vs)) continue;
    for (const Vertex x : slot.v)
      if (x != vd && in_link_of_vs(x) && !in_link_of_edge(x)) return false;
    if (!chords_.empty()) {
      scratch_.clear();
      common_edges(slot, vd, scratch_);
      for (const Edge& e : scratch_)
        if (std::find(chords_.begin(), chords_.end(), e) != chords_.end()) return false;
    }
    if (vs_has_triangle && has_link_triangle(slot, vd)) return false;
  }
  return true;
}

/// Of a modified tet.
bool CollapseCheck::inverts(const Slot& slot) const {
  const Vertex vs = plan_.vs, vd = plan_.vd;
  const auto at = [&](std::size_t i) -> const Point& { return positions_[slot.v[i] == vs ? vd : slot.v[i]]; };
  const int sign = orientation(at(0), at(1), at(2), at(3));
  if (sign > 0) return false;
  // A flat tet of the input may stay flat, and no other tet becomes flat. Its faces may turn over in their plane: those
  // on the boundary are looked at there.
  return sign < 0 ||
         orientation(positions_[slot.v[0]], positions_[slot.v[1]], positions_[slot.v[2]], positions_[slot.v[3]]) != 0;
}

bool CollapseCheck::spoils_shapes() {
  const Vertex vs = plan_.vs, vd = plan_.vd;
  plan_.new_quality.clear();
  for (const SlotId s : plan_.modified) {
    const Slot& slot = complex_.slot(s);
    float quality = 0;
    if (!complex_.is_ghost(slot)) {
      const auto at = [&](std::size_t i) -> const Point& { return positions_[slot.v[i] == vs ? vd : slot.v[i]]; };
      quality = std::max(0.0F, static_cast<float>(shape_quality(at(0), at(1), at(2), at(3)))); // flat: but for rounding
      if (quality < min_quality_ && quality < worst_old_) return true;
    }
    plan_.new_quality.push_back(quality);
  }
  return false;
}

CollapseStatus CollapseCheck::examine(Vertex vs, Vertex vd) {
  stamp_ += kMarkStep;
  if (stamp_ < kMarkStep) { // the stamps have gone round
    std::fill(mark_.begin(), mark_.end(), 0);
    stamp_ = kMarkStep;
  }
  plan_.vs = vs;
  plan_.vd = vd;
  const std::size_t size_vs = complex_.star(vs).size();
  const std::size_t size_vd = complex_.star(vd).size();
  if (size_vs > kMaxRemovedStar) return CollapseStatus::kRemovedStarTooLarge;
  if (!classify()) return CollapseStatus::kInverted;
  // A boundary vertex leaves the boundary as it is only along an edge of it.
  if (plan_.moves_boundary && !moves_along_boundary_) return CollapseStatus::kBoundaryVertex;
  const std::size_t new_size = size_vs + size_vd - 2 * plan_.deleted.size();
  if (new_size > max_star_ && new_size > size_vd) return CollapseStatus::kStarTooLarge;
  const auto loses_all_tets = [&] {
    return std::all_of(plan_.modified.begin(), plan_.modified.end(),
                       [&](SlotId s) { return complex_.is_ghost(complex_.slot(s)); });
  };
  if (loses_all_tets()) return CollapseStatus::kLinkCondition;
  // The link condition last: it refuses least, and visits the star of vd.
  if (spoils_shapes()) return CollapseStatus::kQuality;
  mark_links();
  if (!link_condition()) return CollapseStatus::kLinkCondition;
  find_joining();
  return CollapseStatus::kAccepted;
}

} // namespace ptet::build
