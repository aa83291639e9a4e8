// Closest points on triangles and tets, against dense sampling.
#include "mesh/closest_point.hpp"
#include "support/brute_force.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

double distance(const Point& p, const Point& q) {
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

template <std::size_t N>
Point combine(const std::array<double, N>& weight, const std::array<Point, N>& corners) {
  Point q{};
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      q[axis] += weight[i] * corners[i][axis];
  return q;
}

/// No sample of the triangle is nearer than this.
double sampled_distance(const Point& p, const std::array<Point, 3>& triangle, int steps) {
  double nearest = distance(p, triangle[0]);
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; i + j <= steps; ++j) {
      const double u = double(i) / steps, v = double(j) / steps;
      nearest = std::min(nearest, distance(p, combine<3>({1 - u - v, u, v}, triangle)));
    }
  return nearest;
}

template <class Closest, std::size_t N>
void check_weights(const Closest& on, const Point& p, const std::array<Point, N>& corners) {
  double sum = 0;
  for (const double w : on.weight) {
    CHECK(w >= -1e-15);
    sum += w;
  }
  CHECK(sum == Approx(1));
  CHECK(std::sqrt(on.distance_sq) == Approx(distance(p, combine(on.weight, corners))).margin(1e-12));
}

Point random_point(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> number(-size, size);
  return {number(random), number(random), number(random)};
}

void check_triangle(const Point& p, const std::array<Point, 3>& triangle) {
  const ClosestOnTriangle on = closest_on_triangle(p, triangle[0], triangle[1], triangle[2]);
  check_weights(on, p, triangle);
  constexpr int kSteps = 40;
  const double longest = std::max(
      {distance(triangle[0], triangle[1]), distance(triangle[1], triangle[2]), distance(triangle[2], triangle[0])});
  const double sampled = sampled_distance(p, triangle, kSteps);
  CHECK(std::sqrt(on.distance_sq) <= sampled + 1e-12);
  CHECK(std::sqrt(on.distance_sq) >= sampled - longest / kSteps - 1e-12);
  CHECK(std::sqrt(on.distance_sq) == Approx(test::nearest_on_triangle(p, triangle).distance).margin(1e-12));
}

} // namespace

TEST_CASE("closest point of a triangle: each of its seven regions", "[closest-point]") {
  const std::array<Point, 3> t = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  const auto on = [&](const Point& p) { return closest_on_triangle(p, t[0], t[1], t[2]); };
  using Weights = std::array<double, 3>;
  CHECK(on({1, 1, 5}).weight == Weights{0.5, 0.25, 0.25});
  CHECK(on({1, 1, 5}).distance_sq == 25);
  CHECK(on({-1, -2, 0}).weight == Weights{1, 0, 0});
  CHECK(on({6, -1, 0}).weight == Weights{0, 1, 0});
  CHECK(on({-1, 6, 2}).weight == Weights{0, 0, 1});
  CHECK(on({1, -3, 0}).weight == Weights{0.75, 0.25, 0});
  CHECK(on({-3, 1, 0}).weight == Weights{0.75, 0, 0.25});
  CHECK(on({4, 4, 0}).weight == Weights{0, 0.5, 0.5});
  CHECK(on({4, 4, 0}).distance_sq == 8);
}

TEST_CASE("closest point of random triangles and points: as dense sampling says", "[closest-point]") {
  std::mt19937 random(3);
  for (int i = 0; i < 400; ++i)
    check_triangle(random_point(random, 2),
                   {random_point(random, 1), random_point(random, 1), random_point(random, 1)});
}

TEST_CASE("closest point of triangles that are a segment or a point", "[closest-point]") {
  std::mt19937 random(4);
  const std::vector<std::array<Point, 3>> degenerate = {
      {{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}}, {{{0, 0, 0}, {4, 2, 0}, {4, 2, 0}}}, {{{0, 0, 0}, {0, 0, 0}, {4, 2, 0}}},
      {{{4, 2, 0}, {0, 0, 0}, {4, 2, 0}}}, {{{0, 0, 0}, {2, 1, 0}, {4, 2, 0}}}, {{{2, 1, 0}, {4, 2, 0}, {0, 0, 0}}},
      {{{4, 2, 0}, {0, 0, 0}, {2, 1, 0}}},
  };
  for (std::size_t which = 0; which < degenerate.size(); ++which) {
    INFO("triangle " << which);
    for (int i = 0; i < 50; ++i)
      check_triangle(random_point(random, 8), degenerate[which]);
  }
}

TEST_CASE("closest point of thin triangles: to the last digits, whichever corner comes first", "[closest-point]") {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> number(0, 1);
  for (const double height : {1e-2, 1e-4, 1e-6, 1e-8})
    // A needle with two right angles nearly, one with a right angle, one that is flat at its apex.
    for (const double apex : {0.0, 1.0, 0.4})
      for (int i = 0; i < 300; ++i) {
        const Point offset = random_point(random, 3);
        // In the plane y = offset: points over, beside and beyond the triangle are known without its coordinates.
        std::array<Point, 3> t = {{{0, 0, 0}, {1, 0, 0}, {apex, 0, height}}};
        for (Point& x : t)
          for (std::size_t axis = 0; axis < 3; ++axis)
            x[axis] += offset[axis];
        double u = number(random), v = number(random);
        if (u + v > 1) {
          u = 1 - u;
          v = 1 - v;
        }
        const Point on = combine<3>({1 - u - v, u, v}, t);
        const double lift = i % 3 == 0 ? 0 : i % 3 == 1 ? 1e-9 : 0.1;
        const Point p{on[0], on[1] + lift, on[2]};
        std::rotate(t.begin(), t.begin() + i % 3, t.end());
        if (i % 2 == 0) std::swap(t[1], t[2]);
        const ClosestOnTriangle closest = closest_on_triangle(p, t[0], t[1], t[2]);
        INFO("height " << height << ", apex " << apex << ", lift " << lift);
        CHECK(std::sqrt(closest.distance_sq) == Approx(p[1] - offset[1]).margin(1e-13));
        check_weights(closest, p, t);
      }
}

TEST_CASE("closest point of a tet's surface: the best of its four faces", "[closest-point]") {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    std::array<Point, 4> tet = {random_point(random, 1), random_point(random, 1), random_point(random, 1),
                                random_point(random, 1)};
    if (i % 5 == 0) tet[3] = combine<3>({0.2, 0.5, 0.3}, {tet[0], tet[1], tet[2]}); // flat
    const Point p = random_point(random, 2);
    const ClosestOnTet on = closest_on_tet_surface(p, tet);
    check_weights(on, p, tet);
    CHECK(*std::min_element(on.weight.begin(), on.weight.end()) == Approx(0).margin(1e-15)); // on the surface
    double nearest = 1e9;
    for (std::size_t apex = 0; apex < 4; ++apex)
      nearest = std::min(
          nearest,
          test::nearest_on_triangle(p, {tet[(apex + 1) % 4], tet[(apex + 2) % 4], tet[(apex + 3) % 4]}).distance);
    CHECK(std::sqrt(on.distance_sq) == Approx(nearest).margin(1e-12));
  }
}

TEST_CASE("closest points far from the origin are as near as at it") {
  const auto distance_of = [](double far, const Point& p) {
    // Grid positions, so that moving them does not round them.
    const auto at = [&](double x, double y, double z) { return Point{x / 64 + far, y / 64 - 2 * far, z / 64 + far}; };
    const Point moved = at(p[0], p[1], p[2]);
    return std::sqrt(closest_on_triangle(moved, at(0, 0, 0), at(48, 16, 8), at(16, 64, 24)).distance_sq);
  };
  const std::vector<Point> points = {{20, 20, 9}, {23, 22, 13}, {40, -10, 3}, {30, 50, 20}, {-5, 30, 10}, {60, 10, 9}};
  for (const Point& p : points)
    for (const double far : {1e6, 1e9})
      CHECK(distance_of(far, p) == Approx(distance_of(0, p)).epsilon(1e-13));
}
