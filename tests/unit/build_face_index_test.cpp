// The index of boundary faces against a look at all of them, while faces move and go.
#include "build/face_index.hpp"
#include "build_fixture.hpp"

#include <algorithm>
#include <array>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using build::SlotId;
using build::Vertex;
using build::test::Fixture;

namespace {

/// Tets that share nothing: four faces each, anywhere in the unit cube.
Fixture scattered(std::uint32_t tets, std::mt19937& random) {
  std::uniform_real_distribution<double> place(0, 1), size(0.01, 0.1);
  std::vector<Point> points;
  std::vector<std::array<Vertex, 4>> corners;
  for (Vertex i = 0; i < tets; ++i) {
    const Point p{place(random), place(random), place(random)};
    const double a = size(random);
    points.insert(points.end(), {p, {p[0] + a, p[1], p[2]}, {p[0], p[1] + a, p[2]}, {p[0], p[1], p[2] + a}});
    corners.push_back({4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3});
  }
  return Fixture(points, corners);
}

} // namespace

TEST_CASE("face index: finds what a look at all faces finds, down to the last one", "[build][boundary]") {
  std::mt19937 random(7);
  const Fixture f = scattered(60, random);
  std::vector<SlotId> ghosts;
  for (SlotId s = 0; s < f.complex.slot_count(); ++s)
    if (f.complex.is_ghost(f.complex.slot(s))) ghosts.push_back(s);
  REQUIRE(ghosts.size() == 240);
  build::FaceIndex index;
  index.build(f.complex, f.points, ghosts);
  std::vector<BoundingBox> boxes(f.complex.slot_count());
  for (const SlotId s : ghosts)
    boxes[s] = index.box(s);

  std::uniform_real_distribution<double> place(0, 1);
  const auto somewhere = [&] { return Point{place(random), place(random), place(random)}; };
  std::vector<char> moved(boxes.size());
  const auto compare = [&] {
    const Point p = somewhere();
    const BoundingBox wanted = box_of(std::array{p, Point{p[0] + 0.2, p[1] + 0.2, p[2] + 0.2}});
    std::vector<SlotId> hits, expected;
    index.query(wanted, hits);
    std::sort(hits.begin(), hits.end());
    bool any_moved = false;
    for (const SlotId s : ghosts)
      if (boxes[s].meets(wanted)) {
        expected.push_back(s);
        any_moved |= moved[s] != 0;
      }
    CHECK(hits == expected);
    // That nothing has moved is never said wrongly; the opposite may be, where the tree was made anew.
    if (any_moved) CHECK(index.has_moved(wanted));
  };
  std::vector<SlotId> left = ghosts;
  std::shuffle(left.begin(), left.end(), random);
  while (!left.empty()) {
    if (left.size() % 10 == 0) {
      index.begin_changes();
      std::fill(moved.begin(), moved.end(), 0);
      const Point low{-1, -1, -1}, high{2, 2, 2};
      CHECK_FALSE(index.has_moved(box_of(std::array{low, high})));
    }
    const SlotId goes = left.back();
    left.pop_back();
    index.erase(goes);
    boxes[goes] = {};
    if (!left.empty()) {
      const SlotId moves = left[random() % left.size()];
      const std::array<Point, 3> corners{somewhere(), somewhere(), somewhere()};
      index.replace(moves, box_of(corners));
      boxes[moves] = box_of(corners);
      moved[moves] = 1;
      CHECK(index.box(moves).low == boxes[moves].low);
    }
    compare();
  }
}
