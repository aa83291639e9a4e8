#include "lod/region.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

const std::array<Point, 4> kCorner = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

bool meets_tet(const Region& region, const std::array<Point, 4>& tet = kCorner) {
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
  CHECK(meets(Region{Box{{1, 1, -1}, {1.5, 1.5, 1}}}, triangle));
  CHECK(meets(Region{Box{{1, 1, 0}, {1.5, 1.5, 1}}}, triangle));
  CHECK_FALSE(meets(Region{Box{{1, 1, 0.001}, {1.5, 1.5, 1}}}, triangle));
  CHECK_FALSE(meets(Region{Box{{2.1, 2.1, -1}, {9, 9, 1}}}, triangle));
  CHECK(meets(Region{Sphere{{1, 1, 2}, 2}}, triangle));
  CHECK_FALSE(meets(Region{Sphere{{3, 3, 0}, 1.41}}, triangle));
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
  CHECK(meets(Region{Box{{0, 0, 0}, {1, 1, 1}}}, {1, 1, 1}, {2, 2, 2}));
  CHECK_FALSE(meets(Region{Box{{0, 0, 0}, {1, 1, 1}}}, {1, 1.01, 1}, {2, 2, 2}));
  CHECK(meets(Region{Sphere{{0, 0, 0}, 5}}, {3, 4, -1}, {9, 9, 1}));
  CHECK_FALSE(meets(Region{Sphere{{0, 0, 0}, 4.99}}, {3, 4, -1}, {9, 9, 1}));
}

TEST_CASE("region: a ball and a box meet where no distance between them is certain, at any size and place") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1), exponent(-1, 1);
  int meeting = 0, close = 0;
  for (int i = 0; i < 200000; ++i) {
    // The usual sizes, those whose squares overflow or vanish, and some in between; from the middle to far away.
    const double reach = i % 4 == 0 ? 300 : i % 4 == 1 ? 100 : 6;
    const double size = std::pow(10, reach * exponent(random));
    const double offset = i % 3 == 0 ? size * std::pow(10, 16 * exponent(random)) : 0;
    Point centre{}, min{}, max{};
    double apart = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      centre[axis] = offset + size * number(random);
      const double a = offset + size * number(random), b = offset + size * number(random);
      min[axis] = std::min(a, b);
      max[axis] = std::max(a, b);
      apart = std::hypot(apart, std::max({min[axis] - centre[axis], centre[axis] - max[axis], 0.0}));
    }
    // Half of them just touch, or miss one another by up to some per cent.
    const double near = 1 + (i % 5 == 0 ? 1e-15 : 0.03) * number(random);
    const Region region = Sphere{centre, i % 2 == 0 ? near * apart : size * std::fabs(number(random))};
    const double least = distance(region, min, max);
    CHECK(meets(region, min, max) == !(least > 0));
    meeting += least > 0 ? 0 : 1;
    close += least > 0 && least < 0.01 * size ? 1 : 0;
  }
  CHECK(meeting > 50000);
  CHECK(meeting < 170000);
  CHECK(close > 10000);
}

TEST_CASE("region: half-spaces and boxes in any position") {
  CHECK(meets_tet(HalfSpace{{1, 0, 0}, 0}));
  CHECK_FALSE(meets_tet(HalfSpace{{1, 0, 0}, -0.001}));
  CHECK(meets_tet(HalfSpace{{-2, -2, -2}, -2})); // touches the slanted face
  CHECK_FALSE(meets_tet(HalfSpace{{-2, -2, -2}, -2.001}));
  const double s = std::sqrt(0.5);
  // A square prism around the z axis, turned by 45 degrees: it reaches to 1 along x and along y.
  const OrientedBox prism{{0, 0, 0}, {{{0.5, 0.5, 0}, {-0.5, 0.5, 0}, {0, 0, 1}}}};
  CHECK(meets_tet(prism));
  const auto away = [](double x, double y, double z) {
    return std::array<Point, 4>{{{x, y, z}, {x + 1, y, z}, {x, y + 1, z}, {x, y, z + 1}}};
  };
  CHECK(meets_tet(prism, away(1, 0, 0)));
  CHECK_FALSE(meets_tet(prism, away(1.001, 0, 0)));
  CHECK(meets_tet(prism, away(0.5, 0.5, 0)));
  CHECK_FALSE(meets_tet(prism, away(0.5, 0.501, 0)));
  CHECK(meets_tet(prism, away(0, 0, 1)));
  CHECK_FALSE(meets_tet(prism, away(0, 0, 1.001)));
  CHECK(distance(prism, away(1, 1, 0)) == Approx(s).epsilon(1e-12));
  CHECK(distance(prism, away(1.5, 0, 2)) == Approx(std::sqrt(1.25)).epsilon(1e-12));
  CHECK(distance(Region{HalfSpace{{0, 3, 0}, -6}}, kCorner) == Approx(2).epsilon(1e-12));
}

namespace {

double product(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
/// By the formula for a point and each shape.
double distance_of(const Region& region, const Point& p) {
  if (const HalfSpace* const half = std::get_if<HalfSpace>(&region))
    return std::max(0.0, product(half->normal, p) - half->offset) / std::sqrt(product(half->normal, half->normal));
  if (const Sphere* const sphere = std::get_if<Sphere>(&region)) {
    const Point& c = sphere->centre;
    return std::max(0.0, std::hypot(p[0] - c[0], p[1] - c[1], p[2] - c[2]) - sphere->radius);
  }
  OrientedBox box;
  if (const Box* const straight = std::get_if<Box>(&region)) {
    for (std::size_t i = 0; i < 3; ++i) {
      box.centre[i] = (straight->min[i] + straight->max[i]) / 2;
      box.half_axes[i][i] = (straight->max[i] - straight->min[i]) / 2;
    }
  } else {
    box = std::get<OrientedBox>(region);
  }
  double squared = 0;
  for (const Point& half : box.half_axes) {
    const double length = std::sqrt(product(half, half));
    const Point to{p[0] - box.centre[0], p[1] - box.centre[1], p[2] - box.centre[2]};
    const double beyond = std::max(0.0, std::fabs(product(to, half)) / length - length);
    squared += beyond * beyond;
  }
  return std::sqrt(squared);
}

struct RandomShapes {
  std::mt19937 random{11};
  double number(double low, double high) {
    return low + (high - low) * (static_cast<double>(random() % 65537) / 65536);
  }
  Point point(double reach) { return {number(-reach, reach), number(-reach, reach), number(-reach, reach)}; }
  Region region() {
    const Point at = point(1);
    switch (random() % 4) {
    case 0: return Sphere{at, number(0, 0.7)};
    case 1: {
      const Point normal = point(1);
      return HalfSpace{normal, product(normal, at)};
    }
    case 2: return Box{at, {at[0] + number(0.1, 1), at[1] + number(0.1, 1), at[2] + number(0.1, 1)}};
    default: break;
    }
    const double turn = number(0, 7), tilt = number(0, 7), s = std::sin(turn), c = std::cos(turn), t = std::sin(tilt),
                 u = std::cos(tilt);
    OrientedBox box{at, {{{c, s, 0}, {-s * u, c * u, t}, {s * t, -c * t, u}}}};
    for (Point& half : box.half_axes) {
      const double length = number(0.05, 0.7);
      for (double& x : half)
        x *= length;
    }
    return box;
  }
};

} // namespace

TEST_CASE("region: distances against the least over points of the tet, found by descent") {
  RandomShapes shapes;
  std::size_t apart = 0;
  for (int i = 0; i < 4000; ++i) {
    const Region region = shapes.region();
    std::array<Point, 4> tet = {shapes.point(1), shapes.point(1), shapes.point(1), shapes.point(1)};
    for (Point& p : tet)
      for (std::size_t axis = 0; axis < 3; ++axis)
        p[axis] += axis == 0 ? 1.0 : 0.2;
    const std::size_t count = i % 4 == 0 ? 3 : 4;
    // The distance is convex in the weights: halving steps from corner to corner ends near its least value.
    std::array<double, 4> weight{};
    for (std::size_t c = 0; c < count; ++c)
      weight[c] = 1.0 / static_cast<double>(count);
    const auto value = [&] {
      Point p{};
      for (std::size_t c = 0; c < count; ++c)
        for (std::size_t axis = 0; axis < 3; ++axis)
          p[axis] += weight[c] * tet[c][axis];
      return distance_of(region, p);
    };
    double least = value();
    for (double step = 0.5; step > 1e-7;) {
      bool is_better = false;
      for (std::size_t from = 0; from < count; ++from)
        for (std::size_t to = 0; to < count; ++to) {
          const double moved = std::min(step, weight[from]);
          weight[from] -= moved;
          weight[to] += moved;
          const double now = value();
          if (now < least) {
            least = now;
            is_better = true;
          } else {
            weight[to] -= moved;
            weight[from] += moved;
          }
        }
      if (!is_better) step /= 2;
    }
    const std::span<const Point> corners(tet.data(), count);
    const double found = distance(region, corners);
    CHECK(found <= least + 1e-12);
    CHECK((found == 0) == meets(region, corners));
    if (least > 1e-3) CHECK(found >= least * 0.9);
    if (least > 1e-3) CHECK(found > 0);
    apart += found > 0 ? 1 : 0;

    // The box around it is no further, and is in the region only when all of it is.
    Point min = tet[0], max = tet[0];
    for (const Point& p : corners)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        min[axis] = std::min(min[axis], p[axis]);
        max[axis] = std::max(max[axis], p[axis]);
      }
    CHECK(distance(region, min, max) <= found + 1e-12);
    CHECK((distance(region, min, max) == 0) == meets(region, min, max));
    const Point middle{(min[0] + max[0]) / 2, (min[1] + max[1]) / 2, (min[2] + max[2]) / 2};
    for (double share : {1.0, 0.3, 0.05}) {
      Point low{}, high{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = middle[axis] + share * (min[axis] - middle[axis]);
        high[axis] = middle[axis] + share * (max[axis] - middle[axis]);
      }
      bool all_inside = true;
      double deepest = 0;
      for (const Point& p : box_corners(low, high)) {
        all_inside = all_inside && distance_of(region, p) == 0;
        deepest = std::max(deepest, distance_of(region, p));
      }
      if (contains(region, low, high)) CHECK(deepest <= 1e-12);
      if (all_inside && share < 1 && std::holds_alternative<Box>(region)) CHECK(contains(region, low, high));
    }
  }
  CHECK(apart > 1000);
}
