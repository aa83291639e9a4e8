#include "mesh/box_tree.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

namespace ptet {
namespace {

/// Corners on a coarse grid, so that boxes touch, coincide and are flat.
BoundingBox random_box(std::mt19937& random, int largest) {
  std::uniform_int_distribution<int> place(0, 20), size(0, largest);
  BoundingBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] = place(random);
    box.high[axis] = box.low[axis] + size(random);
  }
  return box;
}

std::vector<std::uint32_t> found(const BoxTree& tree, const BoundingBox& query, std::uint32_t first_item) {
  std::vector<std::uint32_t> items;
  tree.each_meeting(query, first_item, [&](std::uint32_t item) { items.push_back(item); });
  std::sort(items.begin(), items.end());
  return items;
}

} // namespace

TEST_CASE("a tree of boxes finds what meets a box, from an item on") {
  std::mt19937 random(7);
  for (const std::size_t count : {0, 1, 4, 5, 63, 700}) {
    std::vector<BoundingBox> boxes;
    for (std::size_t i = 0; i < count; ++i)
      boxes.push_back(random_box(random, i % 10 == 0 ? 12 : 2));
    const BoxTree tree(boxes);
    for (int trial = 0; trial < 200; ++trial) {
      const BoundingBox query = random_box(random, 6);
      const auto first_item = static_cast<std::uint32_t>(trial % 2 == 0 ? 0 : random() % (count + 2));
      std::vector<std::uint32_t> expected;
      for (std::uint32_t item = first_item; item < count; ++item)
        if (boxes[item].meets(query)) expected.push_back(item);
      REQUIRE(found(tree, query, first_item) == expected);
      std::vector<std::uint32_t> in_half, expected_in_half;
      const auto near = [&](const BoundingBox& box) { return box.low[0] + box.low[1] <= query.low[0]; };
      tree.each_where(near, first_item, [&](std::uint32_t item) { in_half.push_back(item); });
      std::sort(in_half.begin(), in_half.end());
      for (std::uint32_t item = first_item; item < count; ++item)
        if (near(boxes[item])) expected_in_half.push_back(item);
      REQUIRE(in_half == expected_in_half);
    }
  }
}

} // namespace ptet
