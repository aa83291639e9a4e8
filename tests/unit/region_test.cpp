#include "lod/region.hpp"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

const std::array<Point, 4> kCorner = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

bool meets_tet(const FocusRegion& region, const std::array<Point, 4>& tet = kCorner) {
  return meets(region, tet);
}

} // namespace

TEST_CASE("region: a box inside a tet, around it, touching it, beside it") {
  CHECK(meets_tet(Box{{0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}}));
  CHECK(meets_tet(Box{{-9, -9, -9}, {9, 9, 9}}));
  CHECK(meets_tet(Box{{0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}}));
  CHECK(meets_tet(Box{{-1, 0, 0}, {0, 1, 1}}));
  CHECK(meets_tet(Box{{1, 0, 0}, {2, 1, 1}}));
  CHECK(meets_tet(Box{{0.5, 0.5, 0}, {2, 2, 2}})); // touches an edge in one point
  CHECK_FALSE(meets_tet(Box{{1.001, 0, 0}, {2, 1, 1}}));
  CHECK_FALSE(meets_tet(Box{{-1, -1, -1}, {2, 2, -1e-6}}));
  CHECK_FALSE(meets_tet(Box{{0.34, 0.34, 0.34}, {2, 2, 2}})); // only the slanted face separates
}

TEST_CASE("region: boxes that only a pair of edges separates") {
  const std::array<Point, 4> wedge = {{{0, 0, -1}, {0, 0, 1}, {-1, -1, -0.5}, {-1, -1, 0.5}}};
  CHECK_FALSE(meets_tet(Box{{-0.5, 0.1, -0.1}, {3, 3, 0.1}}, wedge));
  const std::array<Point, 4> turned = {{{1, 0, 1}, {0, 1, 1}, {2, 2, 3}, {3, 3, 3.5}}};
  CHECK_FALSE(meets_tet(Box{{-1, -1, -1}, {0.45, 0.45, 2}}, turned));
  CHECK(meets_tet(Box{{-1, -1, -1}, {0.5, 0.5, 2}}, turned));
}

TEST_CASE("region: a ball at a corner, an edge, a face, inside and around") {
  CHECK(meets_tet(Sphere{{0.1, 0.1, 0.1}, 0}));
  CHECK(meets_tet(Sphere{{0.2, 0.2, 0.2}, 100}));
  CHECK(meets_tet(Sphere{{2, 0, 0}, 1}));
  CHECK_FALSE(meets_tet(Sphere{{2, 0, 0}, 0.999}));
  CHECK(meets_tet(Sphere{{0.5, -1, -1}, std::sqrt(2.0)}));
  CHECK_FALSE(meets_tet(Sphere{{0.5, -1, -1}, 1.414}));
  CHECK(meets_tet(Sphere{{0.2, 0.2, -3}, 3}));
  CHECK_FALSE(meets_tet(Sphere{{0.2, 0.2, -3}, 2.999}));
  CHECK(meets_tet(Sphere{{1, 1, 1}, 2 / std::sqrt(3.0)}));
  CHECK_FALSE(meets_tet(Sphere{{1, 1, 1}, 1.154}));
}

TEST_CASE("region: triangles") {
  const std::array<Point, 3> triangle = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  CHECK(meets(FocusRegion{Box{{1, 1, -1}, {1.5, 1.5, 1}}}, triangle));
  CHECK(meets(FocusRegion{Box{{1, 1, 0}, {1.5, 1.5, 1}}}, triangle));
  CHECK_FALSE(meets(FocusRegion{Box{{1, 1, 0.001}, {1.5, 1.5, 1}}}, triangle));
  CHECK_FALSE(meets(FocusRegion{Box{{2.1, 2.1, -1}, {9, 9, 1}}}, triangle));
  CHECK(meets(FocusRegion{Sphere{{1, 1, 2}, 2}}, triangle));
  CHECK_FALSE(meets(FocusRegion{Sphere{{3, 3, 0}, 1.41}}, triangle));
}

TEST_CASE("region: flat tets are no exception") {
  const std::array<Point, 4> flat = {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}};
  CHECK(meets_tet(Box{{2.5, -1, -1}, {2.6, 1, 1}}, flat));
  CHECK_FALSE(meets_tet(Box{{2.5, 0.1, -1}, {2.6, 1, 1}}, flat));
  CHECK(meets_tet(Sphere{{1.5, 1, 0}, 1}, flat));
  CHECK_FALSE(meets_tet(Sphere{{1.5, 1, 0}, 0.99}, flat));
}

TEST_CASE("region: a point of the tet that is in the region is never overlooked, far from the origin too") {
  std::mt19937 random(3);
  const auto number = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random() % 4097) / 4096);
  };
  for (int i = 0; i < 20000; ++i) {
    const double offset = i % 3 == 0 ? 1e6 : 0, size = i % 2 == 0 ? 1 : 1e-3;
    std::array<Point, 4> tet{};
    for (Point& p : tet)
      for (double& x : p)
        x = offset + size * number(-1, 1);
    if (i % 5 == 0) tet[3] = tet[2]; // a triangle in disguise
    Point inside{};
    std::array<double, 4> weights = {number(0, 1), number(0, 1), number(0, 1), 0.001};
    const double sum = weights[0] + weights[1] + weights[2] + weights[3];
    for (std::size_t corner = 0; corner < 4; ++corner)
      for (std::size_t axis = 0; axis < 3; ++axis)
        inside[axis] += weights[corner] / sum * tet[corner][axis];
    // The regions touch the tet at this point, some of them in nothing else.
    Box box{inside, inside};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double length = size * number(0, 1);
      if (random() % 2 == 0)
        box.max[axis] += length;
      else
        box.min[axis] -= length;
    }
    CHECK(meets_tet(box, tet));
    Point centre = inside;
    for (double& x : centre)
      x += size * number(-1, 1);
    const double radius = std::hypot(centre[0] - inside[0], centre[1] - inside[1], centre[2] - inside[2]);
    CHECK(meets_tet(Sphere{centre, radius}, tet));
  }
}

TEST_CASE("region: boxes of stars and blocks") {
  CHECK(meets(FocusRegion{Box{{0, 0, 0}, {1, 1, 1}}}, {1, 1, 1}, {2, 2, 2}));
  CHECK_FALSE(meets(FocusRegion{Box{{0, 0, 0}, {1, 1, 1}}}, {1, 1.01, 1}, {2, 2, 2}));
  CHECK(meets(FocusRegion{Sphere{{0, 0, 0}, 5}}, {3, 4, -1}, {9, 9, 1}));
  CHECK_FALSE(meets(FocusRegion{Sphere{{0, 0, 0}, 4.99}}, {3, 4, -1}, {9, 9, 1}));
}
