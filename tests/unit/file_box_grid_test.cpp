// The grid on which the table states the boxes of blocks: always around what it is asked for, and no place further out.
#include "formats/ptet/box_grid.hpp"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using file::BoxGrid;

TEST_CASE("box grid: the nearest places outwards", "[file]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(0, 1);
  // Usual, tiny, far from 0 and hardly wider than its rounding, huge, a line of points.
  for (const auto& [low, high] : {std::pair{-1.5, 3.0}, std::pair{1e-300, 3e-300}, std::pair{1e9, 1e9 + 4e-6},
                                  std::pair{-1e50, 1e50}, std::pair{7.0, 7.0}}) {
    INFO(low << " to " << high);
    const BoxGrid grid({low, -1, 0}, {high, 1, 0});
    CHECK(grid.at(0, 0) == low);
    CHECK(grid.at(0, BoxGrid::kLast) == high);
    for (int i = 0; i < 2000; ++i) {
      const double x = i == 0 ? low : i == 1 ? high : std::min(high, std::max(low, low + part(random) * (high - low)));
      const std::uint16_t below = grid.below(0, x), above = grid.above(0, x);
      REQUIRE(grid.at(0, below) <= x);
      REQUIRE(grid.at(0, above) >= x);
      if (below < BoxGrid::kLast) REQUIRE(grid.at(0, static_cast<std::uint16_t>(below + 1)) > x);
      if (above > 0) REQUIRE(grid.at(0, static_cast<std::uint16_t>(above - 1)) < x);
    }
    for (std::uint32_t place = 1; place <= BoxGrid::kLast; ++place)
      REQUIRE(grid.at(0, static_cast<std::uint16_t>(place - 1)) <= grid.at(0, static_cast<std::uint16_t>(place)));
  }
}

TEST_CASE("box grid: what is not in the box, or no number, gets a place nevertheless", "[file]") {
  const BoxGrid grid({0, 0, 0}, {1, 1, 1});
  CHECK(grid.below(1, -5) == 0);
  CHECK(grid.above(1, 5) == BoxGrid::kLast);
  for (const double x : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    (void)grid.below(2, x);
    (void)grid.above(2, x);
  }
  CHECK(grid.below(2, HUGE_VAL) == BoxGrid::kLast);
  CHECK(grid.above(2, -HUGE_VAL) == 0);
}
