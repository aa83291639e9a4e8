// A tree of axis-parallel boxes: which items come near a box or a point.
//
//   nodes   [ 0 | first half of 0 ... | second half of 0 ... ]   depth first, halved at the median centre along the
//   order   [ items of the first leaf | of the second ... ]      longest axis; a leaf holds a run of the order
#pragma once

#include "ptet/mesh.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace ptet {

struct BoundingBox {
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Point low{kInfinity, kInfinity, kInfinity};
  Point high{-kInfinity, -kInfinity, -kInfinity};

  void add(const Point& p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  void join(const BoundingBox& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], other.low[axis]);
      high[axis] = std::max(high[axis], other.high[axis]);
    }
  }
  /// Closed boxes: touching counts.
  [[nodiscard]] bool meets(const BoundingBox& other) const {
    return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] && other.low[1] <= high[1] &&
           low[2] <= other.high[2] && other.low[2] <= high[2];
  }
  [[nodiscard]] bool contains(const BoundingBox& other) const { return contains(other.low) && contains(other.high); }
  [[nodiscard]] bool contains(const Point& p) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!(low[axis] <= p[axis] && p[axis] <= high[axis])) return false;
    return true;
  }
};

/// The box of a triangle's or a tet's corners.
template <std::size_t N>
[[nodiscard]] BoundingBox box_of(const std::array<Point, N>& corners) {
  BoundingBox box;
  for (const Point& p : corners)
    box.add(p);
  return box;
}

class BoxTree {
public:
  /// A leaf when count > 0: the items order()[first .. first + count). Else its children are the next node and node
  /// `first`. Halving 2^32 items goes 32 levels deep.
  struct Node {
    BoundingBox box;
    std::uint32_t first, count;
    std::uint32_t last_item; ///< the greatest below it
  };

  /// Same boxes, same tree. Fewer than 2^32 - 1 boxes, finite. Cost: n log n.
  explicit BoxTree(std::span<const BoundingBox> boxes);

  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
  [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }

  /// Calls `visit(item)` for each item whose box meets `query`; always in the same order. Thread rule: const.
  template <class Visit>
  void each_meeting(const BoundingBox& query, Visit&& visit) const {
    each_meeting(query, 0, visit);
  }
  /// The same for items from `first_item` on.
  template <class Visit>
  void each_meeting(const BoundingBox& query, std::uint32_t first_item, Visit&& visit) const {
    each_where([&](const BoundingBox& box) { return box.meets(query); }, first_item, visit);
  }
  /// The same for each item for whose box `near` is true. What it is false for it must be false for all parts of.
  template <class Near, class Visit>
  void each_where(Near&& near, std::uint32_t first_item, Visit&& visit) const {
    std::array<std::uint32_t, 64> pending;
    std::size_t count = 0;
    if (!nodes_.empty()) pending[count++] = 0;
    while (count > 0) {
      const std::uint32_t id = pending[--count];
      const Node& node = nodes_[id];
      if (node.last_item < first_item || !near(node.box)) continue;
      if (node.count == 0) {
        pending[count++] = node.first;
        pending[count++] = id + 1;
        continue;
      }
      for (std::uint32_t slot = node.first; slot < node.first + node.count; ++slot)
        if (order_[slot] >= first_item && near(boxes_[slot])) visit(order_[slot]);
    }
  }

private:
  std::uint32_t build(std::span<std::uint32_t> items, std::uint32_t begin, std::span<const BoundingBox> boxes);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
  std::vector<BoundingBox> boxes_; ///< in that order
};

} // namespace ptet
