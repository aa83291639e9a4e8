#include "mesh/box_tree.hpp"

#include <numeric>

namespace ptet {

namespace {

constexpr std::uint32_t kLeafSize = 4;

double center_of(const BoundingBox& box, std::size_t axis) {
  return box.low[axis] / 2 + box.high[axis] / 2;
}

} // namespace

BoxTree::BoxTree(std::span<const BoundingBox> boxes) : order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  if (!boxes.empty()) build(order_, 0, boxes);
  boxes_.reserve(boxes.size());
  for (const std::uint32_t item : order_)
    boxes_.push_back(boxes[item]);
}

std::uint32_t BoxTree::build(std::span<std::uint32_t> items, std::uint32_t begin, std::span<const BoundingBox> boxes) {
  BoundingBox box, centers;
  std::uint32_t last_item = 0;
  for (const std::uint32_t item : items) {
    box.join(boxes[item]);
    centers.add({center_of(boxes[item], 0), center_of(boxes[item], 1), center_of(boxes[item], 2)});
    last_item = std::max(last_item, item);
  }
  const auto id = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({box, begin, static_cast<std::uint32_t>(items.size()), last_item});
  if (items.size() <= kLeafSize) return id;

  std::size_t axis = 0;
  for (std::size_t other = 1; other < 3; ++other)
    if (centers.high[other] - centers.low[other] > centers.high[axis] - centers.low[axis]) axis = other;
  const std::size_t half = items.size() / 2;
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(),
                   [&](std::uint32_t s, std::uint32_t t) {
                     const double at_s = center_of(boxes[s], axis), at_t = center_of(boxes[t], axis);
                     return at_s != at_t ? at_s < at_t : s < t;
                   });
  build(items.first(half), begin, boxes);
  nodes_[id].first = build(items.subspan(half), begin + static_cast<std::uint32_t>(half), boxes);
  nodes_[id].count = 0;
  return id;
}

} // namespace ptet
