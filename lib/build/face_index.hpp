// A dynamic index of boundary faces by bounding box: which faces may a triangle meet?
//
//   boxes_   [ - | 1 | 2 3 | 4 5 6 7 | ... leaves ]     node i holds what its children 2i and 2i + 1 hold
//
// A face that moves stays near and keeps its leaf, one that goes leaves an empty box; the nodes above are fitted again,
// up to the first that stays as it was. Once half of the faces have gone, the rest get a tree of their own.
#pragma once

#include "build/working_complex.hpp"
#include "mesh/box_tree.hpp"

#include <bit>
#include <vector>

namespace ptet::build {

class FaceIndex {
public:
  /// `ghosts`: all of the complex, ascending; none has gone.
  void build(const WorkingComplex& complex, const std::vector<Point>& positions, std::span<const SlotId> ghosts) {
    if (ghosts.empty()) return;
    first_ghost_ = ghosts.front();
    leaf_.resize(ghosts.back() - first_ghost_ + 1);
    std::vector<BoundingBox> boxes;
    boxes.reserve(ghosts.size());
    for (const SlotId s : ghosts) {
      BoundingBox& box = boxes.emplace_back();
      for (const Vertex v : complex.slot(s).v)
        if (v != complex.dummy()) box.add(positions[v]);
    }
    arrange(ghosts, boxes);
  }
  [[nodiscard]] const BoundingBox& box(SlotId s) const { return boxes_[leaf_count_ + leaf_[s - first_ghost_]]; }
  /// Of all faces; empty where there are none.
  [[nodiscard]] BoundingBox bounds() const { return boxes_.empty() ? BoundingBox{} : boxes_[1]; }
  /// Appends the faces whose box meets this one.
  void query(const BoundingBox& wanted, std::vector<SlotId>& hits) const {
    visit(
        wanted, [](std::size_t) { return true; },
        [&](SlotId s) {
          hits.push_back(s);
          return true;
        });
  }
  /// From now on changes are told from those made before.
  void begin_changes() { ++now_; }
  /// Whether the box of a face that has moved since then meets this one.
  [[nodiscard]] bool has_moved(const BoundingBox& wanted) const {
    return !visit(
        wanted, [&](std::size_t node) { return moved_[node] == now_; }, [](SlotId) { return false; });
  }
  void erase(SlotId s) {
    put(s, {});
    if (2 * --count_ < arranged_) arrange_anew();
  }
  /// The face has moved into this box.
  void replace(SlotId s, const BoundingBox& box) { put(s, box); }

private:
  /// Shows the faces whose box meets this one, below nodes that are `of_interest`, to `look`, while that is true.
  template <class Interest, class Look>
  bool visit(const BoundingBox& wanted, Interest&& of_interest, Look&& look) const {
    std::array<std::size_t, 64> pending; // one for each level, and there are 32 at most
    std::size_t count = 0;
    if (!boxes_.empty()) pending[count++] = 1;
    while (count > 0) {
      const std::size_t node = pending[--count];
      if (!of_interest(node) || !boxes_[node].meets(wanted)) continue;
      if (node >= leaf_count_) {
        if (!look(slot_of_leaf_[node - leaf_count_])) return false;
        continue;
      }
      pending[count++] = 2 * node + 1;
      pending[count++] = 2 * node;
    }
    return true;
  }
  void arrange(std::span<const SlotId> ghosts, const std::vector<BoundingBox>& boxes) {
    count_ = arranged_ = ghosts.size();
    leaf_count_ = std::bit_ceil(ghosts.size());
    boxes_.assign(2 * leaf_count_, {});
    moved_.assign(2 * leaf_count_, now_);
    slot_of_leaf_.resize(leaf_count_);
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
  /// Those that are left.
  void arrange_anew() {
    std::vector<SlotId> ghosts;
    std::vector<BoundingBox> boxes;
    for (std::size_t leaf = 0; leaf < leaf_count_; ++leaf)
      if (const BoundingBox& box = boxes_[leaf_count_ + leaf]; box.low[0] <= box.high[0]) {
        ghosts.push_back(slot_of_leaf_[leaf]);
        boxes.push_back(box);
      }
    if (!ghosts.empty()) arrange(ghosts, boxes);
  }
  [[nodiscard]] BoundingBox joined(std::size_t node) const {
    BoundingBox box = boxes_[2 * node];
    box.join(boxes_[2 * node + 1]);
    return box;
  }
  void put(SlotId s, const BoundingBox& box) {
    std::size_t node = leaf_count_ + leaf_[s - first_ghost_];
    boxes_[node] = box;
    for (std::size_t above = node; above > 0 && moved_[above] != now_; above /= 2)
      moved_[above] = now_;
    while ((node /= 2) > 0) {
      const BoundingBox fitted = joined(node);
      if (fitted.low == boxes_[node].low && fitted.high == boxes_[node].high) return;
      boxes_[node] = fitted;
    }
  }

  SlotId first_ghost_ = 0;
  std::size_t count_ = 0;            ///< faces that are left
  std::size_t arranged_ = 0;         ///< faces that the tree was made of
  std::size_t leaf_count_ = 0;       ///< a power of 2
  std::vector<BoundingBox> boxes_;   ///< by node; an empty one meets nothing
  std::uint32_t now_ = 1;            ///< counts calls of begin_changes()
  std::vector<std::uint32_t> moved_; ///< by node: its value when a face below it moved last
  std::vector<SlotId> slot_of_leaf_; ///< where there is one
  std::vector<std::uint32_t> leaf_;  ///< by slot, from the first ghost on
};

} // namespace ptet::build
