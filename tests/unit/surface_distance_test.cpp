// Distances to a triangle surface and their bounds, against all triangles one by one and dense sampling.
#include "error/surface_distance.hpp"
#include "support/brute_force.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <tuple>

#include <catch2/catch.hpp>
#include <tbb/global_control.h>

using namespace ptet;

namespace {

Point random_point(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> number(-size, size);
  return {number(random), number(random), number(random)};
}

Triangle random_triangle(std::mt19937& random, double spread, double size) {
  const Point at = random_point(random, spread);
  Triangle triangle;
  for (Point& p : triangle) {
    p = random_point(random, size);
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] += at[axis];
  }
  return triangle;
}

double plain_distance(const Point& p, const std::vector<Triangle>& triangles) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Triangle& triangle : triangles)
    nearest = std::min(nearest, test::nearest_on_triangle(p, triangle).distance);
  return nearest;
}

/// The greatest distance of points on a triangular grid; the truth is greater by less than `*step`.
double sampled_farthest(const Triangle& t, const std::vector<Triangle>& triangles, int steps, double* step) {
  double farthest = 0, longest = 0;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; i + j <= steps; ++j) {
      const double u = double(i) / steps, v = double(j) / steps;
      Point p;
      for (std::size_t axis = 0; axis < 3; ++axis)
        p[axis] = (1 - u - v) * t[0][axis] + u * t[1][axis] + v * t[2][axis];
      farthest = std::max(farthest, plain_distance(p, triangles));
    }
  for (std::size_t i = 0; i < 3; ++i) {
    const Point &p = t[i], &q = t[(i + 1) % 3];
    longest = std::max(longest, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
  }
  *step = longest / steps;
  return farthest;
}

/// A square of 2 x n x n triangles in the plane through the origin that `u` and `v` span; each vertex lifted.
template <class Lift>
std::vector<Triangle> patch(int n, const Point& u, const Point& v, Lift lift) {
  const auto at = [&](int i, int j) {
    const double a = double(i) / n, b = double(j) / n, h = lift(a, b);
    return Point{a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2] + h};
  };
  std::vector<Triangle> triangles;
  triangles.reserve(static_cast<std::size_t>(2 * n * n));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return triangles;
}

} // namespace

TEST_CASE("triangle surface: nearest triangles, whatever the hint", "[surface-distance]") {
  std::mt19937 random(11);
  std::vector<Triangle> triangles;
  triangles.reserve(302);
  for (int i = 0; i < 300; ++i)
    triangles.push_back(random_triangle(random, 4, i % 3 == 0 ? 2 : 0.3));
  triangles.push_back({{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}});
  triangles.push_back({{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}});
  const TriangleSurface surface(triangles);
  REQUIRE(surface.size() == triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    CHECK(surface.triangle(i) == triangles[i]);
  std::uint32_t nearest = 0xffffffff;
  for (int i = 0; i < 500; ++i) {
    const Point p = random_point(random, 6);
    const double truth = plain_distance(p, triangles);
    CHECK(std::sqrt(surface.distance_sq(p)) == Approx(truth).margin(1e-12));
    CHECK(std::sqrt(surface.distance_sq(p, &nearest)) == Approx(truth).margin(1e-12));
    CHECK(test::nearest_on_triangle(p, triangles.at(nearest)).distance == Approx(truth).margin(1e-12));
  }
}

TEST_CASE("triangle surface: bounds hold the truth and are as close as asked", "[surface-distance]") {
  std::mt19937 random(12);
  for (int round = 0; round < 60; ++round) {
    std::vector<Triangle> triangles;
    const int count = 1 + round % 40;
    triangles.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i)
      triangles.push_back(random_triangle(random, 2, 1));
    const TriangleSurface surface(triangles);
    const Triangle triangle = random_triangle(random, 1, 2);
    const double relative = round % 2 == 0 ? 0.01 : 0.2;
    double step = 0;
    const double sampled = sampled_farthest(triangle, triangles, 60, &step);

    const DistanceBounds bounds = surface.farthest(triangle, relative, 0);
    CHECK(bounds.upper <= bounds.lower * (1 + relative) + 1e-12);
    CHECK(bounds.upper >= sampled - 1e-12);
    CHECK(bounds.lower <= sampled + step);

    const DistanceBounds above = surface.farthest(triangle, relative, sampled * 2);
    CHECK(above.upper <= sampled * 2 + 1e-12);
    CHECK(above.upper >= sampled - 1e-12);
    const DistanceBounds below = surface.farthest(triangle, relative, sampled * 0.9);
    CHECK(below.upper >= sampled - 1e-12);
    CHECK(below.upper <= below.lower * (1 + relative) + 1e-12);
  }
}

TEST_CASE("triangle surface: over a flat patch of many triangles", "[surface-distance]") {
  const Point u{3, 1, 0.5}, v{-0.7, 2, 1.5};
  const std::vector<Triangle> flat = patch(24, u, v, [](double, double) { return 0.0; });
  const TriangleSurface surface(flat);
  const auto at = [&](double a, double b, double h) {
    return Point{a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2] + h};
  };
  const Triangle within{at(0.03, 0.11, 0), at(0.97, 0.4, 0), at(0.2, 0.91, 0)};
  const DistanceBounds zero = surface.farthest(within, 0.01, 0);
  CHECK(zero.upper < 1e-12);
  // Upright distance 0.25 nearly everywhere; a corner that hangs out by more.
  const double slope = std::abs(u[0] * v[1] - u[1] * v[0]) /
                       std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  const Triangle lifted{at(0.2, 0.3, 0.25), at(0.8, 0.4, 0.25), at(0.3, 0.8, 0.25)};
  const DistanceBounds same = surface.farthest(lifted, 0.01, 0);
  CHECK(same.lower == Approx(0.25 * slope).epsilon(1e-9));
  CHECK(same.upper == Approx(0.25 * slope).epsilon(0.0101));
  CHECK(surface.farthest({at(0.2, 0.3, 0), at(2, 0.4, 0), at(0.3, 0.8, 0)}, 0.01, 0).lower ==
        Approx(plain_distance(at(2, 0.4, 0), flat)));
}

TEST_CASE("triangle surface: needles that are left along the surface's edges", "[surface-distance]") {
  // Triangles a little off two sides of a cube, along the edge between them: cuts leave pieces 1e-17 wide there, which
  // lie in the planes that cut next.
  std::vector<Triangle> sides = patch(3, {1, 0, 0}, {0, 0, 1}, [](double, double) { return 0.0; });
  const std::vector<Triangle> other = patch(3, {0, 1, 0}, {0, 0, 1}, [](double, double) { return 0.0; });
  sides.insert(sides.end(), other.begin(), other.end());
  const TriangleSurface surface(sides);
  std::mt19937 random(5);
  std::uniform_int_distribution<int> quarter(0, 4);
  std::uniform_real_distribution<double> off(-1e-5, 1e-5);
  for (int i = 0; i < 400; ++i) {
    Triangle triangle{Point{0, 0, quarter(random) / 4.0}, Point{0, 0, quarter(random) / 4.0},
                      Point{quarter(random) / 4.0, 0, quarter(random) / 4.0}};
    for (Point& p : triangle)
      for (double& x : p)
        x += off(random);
    const DistanceBounds bounds = surface.farthest(triangle, 0.01, 1e-9);
    CAPTURE(i, bounds.lower, bounds.upper);
    CHECK(bounds.lower < 2e-5);
    CHECK(bounds.upper <= bounds.lower * 1.0101);
  }
}

TEST_CASE("triangle surface: far from the origin no less is told", "[surface-distance]") {
  // All coordinates are multiples of 2^-10 and exact at 2^30, where sums of others round to 2^-22.
  const auto placed = [](Triangle t, double far) {
    for (Point& p : t)
      for (double& x : p)
        x += far;
    return t;
  };
  const std::vector<Triangle> flat = patch(24, {6, 3, 1.5}, {-1.5, 3, 4.5}, [](double, double) { return 0.0; });
  const auto at = [](double a, double b) { return Point{6 * a - 1.5 * b, 3 * a + 3 * b, 1.5 * a + 4.5 * b}; };
  const Triangle within{at(0.125, 0.0625), at(0.875, 0.25), at(0.25, 0.9375)};
  const Triangle lifted = placed(within, 0.25);
  const TriangleSurface surface(flat);
  const DistanceBounds near = surface.farthest(lifted, 0.01, 0);
  for (const double far : {0x1p30, -0x1p30}) {
    std::vector<Triangle> there;
    for (const Triangle& t : flat)
      there.push_back(placed(t, far));
    const TriangleSurface far_surface(there);
    CHECK(far_surface.triangle(7) == there[7]);
    CHECK(far_surface.farthest(placed(within, far), 0.01, 0).upper < 1e-12);
    const DistanceBounds bounds = far_surface.farthest(placed(lifted, far), 0.01, 0);
    CHECK(bounds.lower == Approx(near.lower).epsilon(1e-12));
    CHECK(bounds.upper == Approx(near.upper).epsilon(1e-12));
    CHECK(far_surface.distance_sq(placed(lifted, far)[1]) == Approx(surface.distance_sq(lifted[1])).epsilon(1e-12));
  }
}

TEST_CASE("triangle surface: a peak between the corners", "[surface-distance]") {
  // A large triangle at height 0 under a tent with its ridge at height 1: farthest under the ridge, not at a corner.
  const std::vector<Triangle> tent =
      patch(20, {4, 0, 0}, {0, 4, 0}, [](double a, double) { return 1 - std::abs(2 * a - 1); });
  const TriangleSurface surface(tent);
  const Triangle ground{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  const double truth = 2 / std::sqrt(5.0); // from (2, y, 0) to a side of slope 1/2
  for (const double relative : {0.1, 0.01, 1e-4}) {
    const DistanceBounds bounds = surface.farthest(ground, relative, 0);
    CHECK(bounds.lower <= truth * (1 + 1e-12));
    CHECK(bounds.upper >= truth * (1 - 1e-12));
    CHECK(bounds.upper <= bounds.lower * (1 + relative) * (1 + 1e-12));
  }
}

TEST_CASE("triangle surface: none", "[surface-distance]") {
  const TriangleSurface none({});
  CHECK(std::isinf(none.distance_sq({1, 2, 3})));
  CHECK(std::isinf(none.farthest({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, 0.01, 1).lower));
  CHECK(one_sided_hausdorff({}, none, 0.01, 0).upper == 0);
}

TEST_CASE("one-sided Hausdorff distance: the greatest over the triangles, on any number of threads",
          "[surface-distance]") {
  const std::vector<Triangle> flat = patch(40, {4, 0, 0}, {0, 4, 0}, [](double, double) { return 0.0; });
  const std::vector<Triangle> bumpy =
      patch(130, {4, 0, 0}, {0, 4, 0}, [](double a, double b) { return 0.2 * std::sin(9 * a) * std::sin(7 * b); });
  double truth = 0;
  for (const Triangle& triangle : bumpy)
    for (const Point& p : triangle)
      truth = std::max(truth, std::abs(p[2])); // upright over the flat patch, so greatest at vertices
  const TriangleSurface surface(flat);
  DistanceBounds first;
  for (const int threads : {1, 2, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    const DistanceBounds bounds = one_sided_hausdorff(bumpy, surface, 0.01, 0);
    CHECK(bounds.lower <= truth * (1 + 1e-12));
    CHECK(bounds.upper >= truth * (1 - 1e-12));
    CHECK(bounds.upper <= bounds.lower * 1.01 * (1 + 1e-12));
    if (threads == 1) first = bounds;
    CHECK(bounds.lower == first.lower);
    CHECK(bounds.upper == first.upper);
  }
  CHECK_THROWS(one_sided_hausdorff(bumpy, surface, 0.01, 0, [](const Progress&) { return false; }));
  // Often enough to be stopped soon: a batch of triangles that are hard to tell apart takes its time.
  std::size_t reports = 0;
  std::ignore = one_sided_hausdorff(bumpy, surface, 0.01, 0, [&](const Progress&) { return ++reports > 0; });
  CHECK(reports >= bumpy.size() / 2048);
}
