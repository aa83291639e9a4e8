#include "build/collapse_check.hpp"

#include "mesh/predicates.hpp"
#include "mesh/shape.hpp"

#include <algorithm>
#include <cmath>

namespace ptet::build {
namespace {

/// Beyond this a star is not taken apart in one record.
constexpr std::size_t kMaxRemovedStar = 1024;

} // namespace

CollapseCheck::CollapseCheck(const WorkingComplex& complex, const std::vector<Point>& positions, double min_quality,
                             std::uint32_t max_star)
    : complex_(complex), positions_(positions), min_quality_(static_cast<float>(min_quality)), max_star_(max_star),
      mark_(complex.vertex_count() + 1) {}

void CollapseCheck::classify(Vertex vs, Vertex vd) {
  deleted_.clear();
  modified_.clear();
  link_edges_.clear();
  for (const SlotId s : complex_.star(vs)) {
    const auto& v = complex_.slot(s).v;
    const bool holds_vd = v[0] == vd || v[1] == vd || v[2] == vd || v[3] == vd;
    (holds_vd ? deleted_ : modified_).push_back(s);
    for (const Vertex x : v)
      mark_[x] = std::max(mark_[x], stamp_ + kInLinkOfVs);
    if (!holds_vd) continue;
    Edge edge{};
    std::size_t i = 0;
    for (const Vertex x : v)
      if (x != vs && x != vd) {
        mark_[x] = stamp_ + kInLinkOfVs + kInLinkOfEdge;
        edge[i++] = x;
      }
    link_edges_.push_back(edge);
  }
  moves_boundary_ = in_link_of_vs(complex_.dummy());
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

bool CollapseCheck::link_condition(Vertex vs, Vertex vd) {
  const auto has_link_triangle = [&](const Slot& slot, Vertex apex) {
    return std::all_of(slot.v.begin(), slot.v.end(), [&](Vertex x) { return x == apex || in_link_of_edge(x); });
  };
  chords_.clear();
  // A triangle in both links with no common chord has all its edges in Lk(e), which then is its border.
  bool vs_has_triangle = false;
  for (const SlotId s : modified_) {
    common_edges(complex_.slot(s), vs, chords_);
    vs_has_triangle |= link_edges_.size() == 3 && has_link_triangle(complex_.slot(s), vs);
  }
  for (const SlotId s : complex_.star(vd)) {
    const Slot& slot = complex_.slot(s);
    const auto& v = slot.v;
    if (v[0] == vs || v[1] == vs || v[2] == vs || v[3] == vs) continue;
    for (const Vertex x : v)
      if (x != vd && mark_[x] == stamp_ + kInLinkOfVs) return false;
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

bool CollapseCheck::inverts(Vertex vs, Vertex vd) const {
  for (const SlotId s : modified_) {
    const Slot& slot = complex_.slot(s);
    if (complex_.is_ghost(slot)) continue;
    const auto at = [&](std::size_t i) -> const Point& { return positions_[slot.v[i] == vs ? vd : slot.v[i]]; };
    const int sign = orientation(at(0), at(1), at(2), at(3));
    if (sign > 0) continue;
    // A flat tet of the input may stay flat; it never gets worse, and no other tet becomes flat.
    const bool was_flat = sign == 0 && orientation(positions_[slot.v[0]], positions_[slot.v[1]], positions_[slot.v[2]],
                                                   positions_[slot.v[3]]) == 0;
    if (!was_flat) return true;
  }
  return false;
}

bool CollapseCheck::spoils_shapes(Vertex vs, Vertex vd) {
  new_quality_.clear();
  float worst_old = 1;
  for (const std::span<const SlotId> part : {deleted(), modified()})
    for (const SlotId s : part)
      if (!complex_.is_ghost(complex_.slot(s))) worst_old = std::min(worst_old, complex_.slot(s).quality);
  for (const SlotId s : modified_) {
    const Slot& slot = complex_.slot(s);
    float quality = 0;
    if (!complex_.is_ghost(slot)) {
      const auto at = [&](std::size_t i) -> const Point& { return positions_[slot.v[i] == vs ? vd : slot.v[i]]; };
      quality = static_cast<float>(shape_quality(at(0), at(1), at(2), at(3)));
      if (quality < min_quality_ && quality < worst_old) return true;
    }
    new_quality_.push_back(quality);
  }
  return false;
}

CollapseStatus CollapseCheck::examine(Vertex vs, Vertex vd) {
  stamp_ += kMarkStep;
  if (stamp_ < kMarkStep) { // the stamps have gone round
    std::fill(mark_.begin(), mark_.end(), 0);
    stamp_ = kMarkStep;
  }
  const std::size_t size_vs = complex_.star(vs).size();
  const std::size_t size_vd = complex_.star(vd).size();
  if (size_vs > kMaxRemovedStar) return CollapseStatus::kStarTooLarge;
  classify(vs, vd);
  // A boundary vertex leaves the boundary as it is only along an edge of it.
  if (moves_boundary_ && !in_link_of_edge(complex_.dummy())) return CollapseStatus::kBoundaryVertex;
  const std::size_t new_size = size_vs + size_vd - 2 * deleted_.size();
  if (new_size > max_star_ && new_size > size_vd) return CollapseStatus::kStarTooLarge;
  const auto loses_all_tets = [&] {
    return std::all_of(modified_.begin(), modified_.end(),
                       [&](SlotId s) { return complex_.is_ghost(complex_.slot(s)); });
  };
  if (loses_all_tets()) return CollapseStatus::kLinkCondition;
  // Orientation before the link condition: it refuses most, and does not visit the star of vd.
  if (inverts(vs, vd)) return CollapseStatus::kInverted;
  if (!link_condition(vs, vd)) return CollapseStatus::kLinkCondition;
  return spoils_shapes(vs, vd) ? CollapseStatus::kQuality : CollapseStatus::kAccepted;
}

} // namespace ptet::build
