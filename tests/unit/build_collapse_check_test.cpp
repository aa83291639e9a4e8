// Every reason to refuse a collapse, each on the smallest complex that shows it, and next to it one that is let
// through.
#include "build_fixture.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::build;
using build::test::Fixture;
using build::test::Ghosts;
using build::test::tent;

using Status = CollapseStatus;

namespace {

// 6 sqrt(2) V / Lmax^3 by the book.
double quality(const Fixture& f, const std::array<Vertex, 4>& tet) {
  return shape_quality(f.points[tet[0]], f.points[tet[1]], f.points[tet[2]], f.points[tet[3]]);
}

} // namespace

TEST_CASE("shape quality: 1 for a regular tet, 0 for a flat one, the same in any size", "[build][check]") {
  const Point a = {1, 1, 1}, b = {1, -1, -1}, c = {-1, 1, -1}, d = {-1, -1, 1};
  CHECK(std::abs(shape_quality(a, b, c, d)) == Approx(1));
  CHECK(shape_quality(a, b, c, d) == Approx(-shape_quality(b, a, c, d)));
  CHECK(shape_quality(a, b, c, {0, 0, 0}) == Approx(shape_quality(a, b, c, d) * 0.25)); // V / 4, same longest edge
  CHECK(shape_quality(a, b, c, {1, 0, 0}) == 0);
  CHECK(shape_quality(a, a, a, a) == 0);
}

TEST_CASE("check: the tent's tip goes to the ring, and what that deletes and modifies", "[build][check]") {
  const Fixture f = tent(0.5);
  CollapseCheck check(f.complex, f.points, 0, 64);
  REQUIRE(check.examine(0, 2) == Status::kAccepted);
  CHECK(check.moves_boundary());
  CHECK(check.deleted().size() == 2 + 2);
  CHECK(check.modified().size() == 2 + 2);
  REQUIRE(check.plan().new_quality.size() == 4);
  for (std::size_t m = 0; m < 4; ++m) {
    std::array<Vertex, 4> v = f.complex.slot(check.modified()[m]).v;
    if (f.complex.is_ghost(f.complex.slot(check.modified()[m]))) {
      CHECK(check.plan().new_quality[m] == 0);
      continue;
    }
    for (Vertex& x : v)
      if (x == 0) x = 2;
    CHECK(check.plan().new_quality[m] == Approx(quality(f, v)));
  }
}

TEST_CASE("check: single_tet has no collapse that leaves a tet", "[build][check]") {
  const Fixture f({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}});
  for (Vertex vs = 0; vs < 4; ++vs)
    for (Vertex vd = 0; vd < 4; ++vd)
      if (vs != vd) CHECK(f.examine(vs, vd) == Status::kLinkCondition);
}

TEST_CASE("check: bipyramid, an apex may not go: it would leave no tet of its own", "[build][check]") {
  const Fixture f({{0, 0, 3}, {0, 0, -3}, {2, 0, 0}, {-1, 2, 0}, {-1, -2, 0}}, {{0, 2, 3, 4}, {1, 2, 3, 4}});
  for (const Vertex apex : {0U, 1U})
    for (const Vertex vd : {2U, 3U, 4U})
      CHECK(f.examine(apex, vd) == Status::kLinkCondition);
}

// 0 -- 1 is the edge, 2 and 3 close its link, 4 is a neighbour of both ends but not of the edge:
//
//      4             0 1 2 3   the tet on the edge
//    /   \           0 2 3 4   moves
//   0 --- 1          1 2 4 5   gives 1 the neighbour 4
TEST_CASE("check: common_neighbour, a vertex in both links that is not in the edge's", "[build][check]") {
  const std::vector<Point> points = {{0, 0, 0}, {1, 0, 0}, {0.5, 0, 1}, {0.5, 1, 0}, {-3, 2, 2}, {2, -1, 3}};
  const std::vector<std::array<Vertex, 4>> tets = {{0, 1, 2, 3}, {0, 2, 3, 4}};
  CHECK(Fixture(points, tets, Ghosts::kNone).examine(0, 1) == Status::kAccepted);
  auto closed = tets;
  closed.push_back({1, 2, 4, 5});
  CHECK(Fixture(points, closed, Ghosts::kNone).examine(0, 1) == Status::kLinkCondition);
}

// A hollow: its four faces 0 1 2, 0 1 3, 0 2 3, 1 2 3 belong to one outer tet each. The collapse would flatten it, and
// the chord 2 - 3, which is not in the link of 0 - 1, tells.
TEST_CASE("check: hollow_tet, an edge in both links that is not in the edge's", "[build][check]") {
  const std::vector<Point> points = {{0, 0, 0},      {1, 0, 0},  {0.5, 1, 1}, {0.5, -1, 1},
                                     {0.5, 0, -1.0}, {-2, 0, 2}, {3, 0, 2}};
  const std::vector<std::array<Vertex, 4>> three = {{0, 1, 2, 4}, {0, 1, 3, 4}, {0, 2, 3, 5}};
  CHECK(Fixture(points, three, Ghosts::kNone).examine(0, 1) == Status::kAccepted);
  auto four = three;
  four.push_back({1, 2, 3, 6});
  CHECK(Fixture(points, four, Ghosts::kNone).examine(0, 1) == Status::kLinkCondition);
}

// Two tets on the face 1 2 3 and a third that keeps vertex 1 in the mesh. The edges 1 3 and 2 3 are of the boundary,
// the face 1 2 3 is not: (3, dummy) is in both links but not in the edge's.
TEST_CASE("check: waist, a chord that only the dummy vertex sees", "[build][check]") {
  const std::vector<Point> points = {{1, 1, 1.5}, {0, 0, 0}, {2, 0, 0}, {1, 2, 0}, {1, 1, -1.5}, {-2, 2, 2}};
  const std::vector<std::array<Vertex, 4>> tets = {{0, 1, 2, 3}, {4, 1, 2, 3}, {0, 1, 3, 5}};
  CHECK(Fixture(points, tets, Ghosts::kNone).examine(1, 2) == Status::kAccepted);
  CHECK(Fixture(points, tets, Ghosts::kAll).examine(1, 2) == Status::kLinkCondition);
}

// Two tets that share the vertex 0. With 0 -> 1 the first would fold into the face 1 2 3, whose triangle 2 3 dummy
// is in both links with no chord missing: it is the border of the edge's link.
TEST_CASE("check: pinched_vertex, a triangle in both links", "[build][check]") {
  const std::vector<Point> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  const std::vector<std::array<Vertex, 4>> tets = {{0, 1, 2, 3}, {0, 4, 5, 6}};
  CHECK(Fixture(points, tets, Ghosts::kNone).examine(0, 1) == Status::kAccepted);
  CHECK(Fixture(points, tets, Ghosts::kAll).examine(0, 1) == Status::kLinkCondition);
}

TEST_CASE("check: a boundary vertex moves along boundary edges only", "[build][check]") {
  // The tent's axis lies inside, both its ends on the boundary.
  const Fixture f = tent(1);
  CHECK(f.examine(0, 1) == Status::kBoundaryVertex);
  CHECK(f.examine(1, 0) == Status::kBoundaryVertex);
  CHECK(f.examine(0, 3) == Status::kAccepted);

  // An octahedron with its centre, vertex 6.
  const Fixture g(
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {0, 0, 0}},
      {{0, 2, 4, 6}, {0, 2, 5, 6}, {0, 3, 4, 6}, {0, 3, 5, 6}, {1, 2, 4, 6}, {1, 2, 5, 6}, {1, 3, 4, 6}, {1, 3, 5, 6}});
  CHECK(g.examine(0, 6) == Status::kBoundaryVertex);
  CollapseCheck check(g.complex, g.points, 0, 64);
  CHECK(check.examine(6, 0) == Status::kAccepted); // an inner vertex may go to the boundary
  CHECK_FALSE(check.moves_boundary());
}

// 0 -- 1 with the tet 0 1 2 3, and 0 4 5 6 that moves: through the plane x = 2 it may not go, nor into it.
TEST_CASE("check: inverted, and made flat", "[build][check]") {
  const auto with_plane_at = [](double x) {
    return Fixture({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 0, 1}, {x, -1, -1}, {x, 1, -1}, {x, 0, 1}},
                   {{0, 1, 2, 3}, {0, 4, 5, 6}}, Ghosts::kNone);
  };
  CHECK(with_plane_at(2).examine(0, 1) == Status::kAccepted);
  CHECK(with_plane_at(0.5).examine(0, 1) == Status::kInverted);
  CHECK(with_plane_at(1).examine(0, 1) == Status::kInverted);
  // Exactly: one ulp on either side.
  CHECK(with_plane_at(std::nextafter(1.0, 2.0)).examine(0, 1) == Status::kAccepted);
  CHECK(with_plane_at(std::nextafter(1.0, 0.0)).examine(0, 1) == Status::kInverted);
}

// 0 4 5 6 is flat in the input, with its vertices in an order of which 1 sees either side.
TEST_CASE("check: a flat tet of the input may stay flat or open, but not turn over", "[build][check]") {
  const auto flat = [](const Point& target, bool turned) {
    // All four in z = 0. Unlike the fixture's other tets it is taken as it stands.
    Fixture f({{0, 0, 0}, target, {1, 1, 5}, {1, 0, 6}, {-1, -1, 0}, {-2, 1, 0}, {-3, 0, 0}},
              {turned ? std::array<Vertex, 4>{0, 4, 6, 5} : std::array<Vertex, 4>{0, 4, 5, 6}, {0, 1, 2, 3}},
              Ghosts::kNone);
    REQUIRE(f.complex.slot(0).quality == 0);
    return f.examine(0, 1, 1e-3);
  };
  CHECK(flat({1, 0, 0}, false) == Status::kAccepted);
  CHECK(flat({1, 0, 0}, true) == Status::kAccepted);
  CHECK(flat({1, 0, -1}, false) != flat({1, 0, -1}, true));
  CHECK(flat({1, 0, -1}, false) != flat({1, 0, 1}, false));
  CHECK((flat({1, 0, -1}, false) == Status::kInverted || flat({1, 0, -1}, true) == Status::kInverted));
  CHECK((flat({1, 0, -1}, false) == Status::kAccepted || flat({1, 0, -1}, true) == Status::kAccepted));
}

// The tet 0 4 5 6 becomes a sliver by 0 -> 1; 0 7 8 9 is as good or bad as we like, and gets better.
TEST_CASE("check: below the floor only where the old star was as bad", "[build][check]") {
  const double height = 0.01; // of the sliver
  const auto with_other = [&](double length) {
    return Fixture({{0, 0, 0},
                    {1 - height, 0, 0},
                    {0.5, 0, 1},
                    {0.5, 0.1, 1.5},
                    {1, -1, -1},
                    {1, 1, -1},
                    {1, 0, 1},
                    {-1, 0, 0},
                    {-1, length, 0},
                    {-1, -length, 1}},
                   {{0, 1, 2, 3}, {0, 4, 5, 6}, {0, 7, 8, 9}}, Ghosts::kNone);
  };
  const Fixture good = with_other(1);
  const double sliver = quality(good, {1, 4, 5, 6});
  REQUIRE(std::abs(sliver) < 0.02);
  REQUIRE(good.complex.slot(1).quality > 0.2F);
  const double sliver_quality = std::abs(sliver);
  const double worst_of_good =
      std::min({good.complex.slot(0).quality, good.complex.slot(1).quality, good.complex.slot(2).quality});
  REQUIRE(worst_of_good > 1.5 * sliver_quality);
  CHECK(good.examine(0, 1, 0.99 * sliver_quality) == Status::kAccepted); // above the floor
  CHECK(good.examine(0, 1, 1.01 * sliver_quality) == Status::kQuality);
  const Fixture bad = with_other(500);
  REQUIRE(bad.complex.slot(2).quality < sliver_quality);
  CHECK(bad.examine(0, 1, 1.01 * sliver_quality) == Status::kAccepted); // below it, but so was the star
}

TEST_CASE("check: the deleted tets count as part of the old star", "[build][check]") {
  // The worst tet is the one on the edge, and goes.
  const double height = 0.01;
  const Fixture f({{0, 0, 0}, {1 - height, 0, 0}, {0.5, 0, 1}, {0.5, 1e-4, 1.5}, {1, -1, -1}, {1, 1, -1}, {1, 0, 1}},
                  {{0, 1, 2, 3}, {0, 4, 5, 6}}, Ghosts::kNone);
  REQUIRE(f.complex.slot(0).quality < std::abs(quality(f, {1, 4, 5, 6})));
  CHECK(f.examine(0, 1, 0.5) == Status::kAccepted);
}

TEST_CASE("check: the cap on the star of the target, ghosts included", "[build][check]") {
  const Fixture f = tent(1);
  // star(0): 4 tets, 4 ghosts. star(2): 2 tets, 4 ghosts. On the edge: 2 tets, 2 ghosts. After: 8 + 6 - 2 * 4 = 6.
  REQUIRE(f.complex.star(0).size() == 8);
  REQUIRE(f.complex.star(2).size() == 6);
  CHECK(f.examine(0, 2, 0, 6) == Status::kAccepted);
  // Beyond the cap, but the star of the target does not grow.
  CHECK(f.examine(0, 2, 0, 5) == Status::kAccepted);

  // A fan with n blades around the edge 0 1; 2 -> 3 next to it leaves 3 with more than it had only when 2 has much.
  std::vector<Point> points = {{0, 0, 0}, {1, 0, 0}, {0.5, 0, 1}, {0.5, 1, 0}};
  std::vector<std::array<Vertex, 4>> tets = {{0, 1, 2, 3}};
  const auto add_blades = [&](int from, int to) { // at 0, that the collapse takes to 1
    for (int i = from; i < to; ++i) {
      const auto first = static_cast<Vertex>(points.size());
      points.insert(points.end(), {{-1.0 - i, 0, 0}, {-1.0 - i, 1, 0}, {-1.0 - i, 0, 1}});
      tets.push_back({0, first, first + 1, first + 2});
    }
  };
  add_blades(0, 10);
  const Fixture blades(points, tets, Ghosts::kNone);
  // After: the 10 blades.
  CHECK(blades.examine(0, 1, 0, 10) == Status::kAccepted);
  CHECK(blades.examine(0, 1, 0, 9) == Status::kStarTooLarge);

  // What no cap allows: the star of the removed vertex is larger than is taken apart.
  add_blades(10, 1023);
  CHECK(Fixture(points, tets, Ghosts::kNone).examine(0, 1, 0, 4096) == Status::kAccepted);
  add_blades(1023, 1024);
  CHECK(Fixture(points, tets, Ghosts::kNone).examine(0, 1, 0, 4096) == Status::kRemovedStarTooLarge);
}

TEST_CASE("check: many examinations in a row do not disturb one another", "[build][check]") {
  const Fixture f = tent(1);
  CollapseCheck check(f.complex, f.points, 0, 64);
  for (int i = 0; i < 1000; ++i) {
    CHECK(check.examine(0, 1) == Status::kBoundaryVertex);
    CHECK(check.examine(0, 2 + static_cast<Vertex>(i % 4)) == Status::kAccepted);
    CHECK(check.deleted().size() == 4);
    CHECK(check.modified().size() == 4);
  }
}
