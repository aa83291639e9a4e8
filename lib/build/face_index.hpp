// A dynamic index of boundary faces by bounding box: which faces may a triangle meet?
//
//   boxes_   [ - | 1 | 2 3 | 4 5 6 7 | ... leaves ]     node i holds what its children 2i and 2i + 1 hold
//
// The tree keeps the shape it got from the original faces. A face that moves stays near and keeps its leaf, one that
// goes leaves an empty box; the nodes above are fitted again, up to the first that stays as it was.
#pragma once

#include "build/working_complex.hpp"
#include "mesh/box_tree.hpp"

#include <algorithm>
#include <bit>
#include <vector>

namespace ptet::build {

class FaceIndex {
public:
  using Corners = std::array<Point, 3>;

  /// `ghosts`: all of the complex, ascending; none has gone.
  void build(const WorkingComplex& complex, const std::vector<Point>& positions, std::span<const SlotId> ghosts) {
    if (ghosts.empty()) return;
    first_ghost_ = ghosts.front();
    std::vector<BoundingBox> boxes;
    boxes.reserve(ghosts.size());
    for (const SlotId s : ghosts) {
      BoundingBox& box = boxes.emplace_back();
      for (const Vertex v : complex.slot(s).v)
        if (v != complex.dummy()) box.add(positions[v]);
    }
    leaf_count_ = std::bit_ceil(ghosts.size());
    boxes_.resize(2 * leaf_count_);
    slot_of_leaf_.resize(leaf_count_);
    leaf_.resize(ghosts.back() - first_ghost_ + 1);
    // Faces in an order that halves them in space again and again, and the free leaves spread among them.
    const std::vector<std::uint32_t> order = BoxTree(boxes).order();
    for (std::size_t i = 0; i < order.size(); ++i) {
      const SlotId s = ghosts[order[i]];
      const std::size_t leaf = i * leaf_count_ / order.size();
      leaf_[s - first_ghost_] = static_cast<std::uint32_t>(leaf);
      slot_of_leaf_[leaf] = s;
      boxes_[leaf_count_ + leaf] = boxes[order[i]];
    }
    for (std::size_t node = leaf_count_ - 1; node > 0; --node)
      boxes_[node] = joined(node);
  }
  [[nodiscard]] const BoundingBox& box(SlotId s) const { return boxes_[leaf_count_ + leaf_[s - first_ghost_]]; }
  /// Appends the faces whose box meets this one.
  void query(const BoundingBox& wanted, std::vector<SlotId>& hits) const {
    std::array<std::size_t, 64> pending; // one for each level, and there are 32 at most
    std::size_t count = 0;
    if (!boxes_.empty()) pending[count++] = 1;
    while (count > 0) {
      const std::size_t node = pending[--count];
      if (!boxes_[node].meets(wanted)) continue;
      if (node >= leaf_count_) {
        hits.push_back(slot_of_leaf_[node - leaf_count_]);
        continue;
      }
      pending[count++] = 2 * node + 1;
      pending[count++] = 2 * node;
    }
  }
  void erase(SlotId s) { put(s, {}); }
  void replace(SlotId s, const Corners& corners) { put(s, box_of(corners)); }

private:
  [[nodiscard]] BoundingBox joined(std::size_t node) const {
    BoundingBox box = boxes_[2 * node];
    const BoundingBox& other = boxes_[2 * node + 1];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], other.low[axis]);
      box.high[axis] = std::max(box.high[axis], other.high[axis]);
    }
    return box;
  }
  void put(SlotId s, const BoundingBox& box) {
    std::size_t node = leaf_count_ + leaf_[s - first_ghost_];
    boxes_[node] = box;
    while ((node /= 2) > 0) {
      const BoundingBox fitted = joined(node);
      if (fitted.low == boxes_[node].low && fitted.high == boxes_[node].high) return;
      boxes_[node] = fitted;
    }
  }

  SlotId first_ghost_ = 0;
  std::size_t leaf_count_ = 0;       ///< a power of 2
  std::vector<BoundingBox> boxes_;   ///< by node; an empty one meets nothing
  std::vector<SlotId> slot_of_leaf_; ///< where there is one
  std::vector<std::uint32_t> leaf_;  ///< by slot, from the first ghost on
};

} // namespace ptet::build
