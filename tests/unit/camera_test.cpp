#include "lod/camera.hpp"
#include "lod/region.hpp"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

double product(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Looks along -z from the origin: 90 degrees high, twice as wide, 100 pixels high.
View plain() {
  View view;
  view.direction = {0, 0, -3};
  view.up = {0, 1, 0.5};
  view.vertical_angle = M_PI / 2;
  view.width = 200;
  view.height = 100;
  return view;
}

bool sees(const Camera& camera, const Point& p) {
  return camera.meets(std::vector<Point>{p, p, p});
}

} // namespace

TEST_CASE("camera: directions may be as short or long as numbers go") {
  for (const double length : {5e-324, 1e-309, 1.0, 1e308}) {
    View view = plain();
    view.direction = {0, 0, -length};
    view.up = {0, length, 0};
    const Camera camera(view);
    CHECK(sees(camera, {0, 0.99, -1}));
    CHECK_FALSE(sees(camera, {0, 1.01, -1}));
  }
}

TEST_CASE("camera: what is in the picture") {
  const Camera camera(plain());
  CHECK(sees(camera, {0, 0, -1}));
  CHECK_FALSE(sees(camera, {0, 0, 1}));
  CHECK(sees(camera, {0, 0.99, -1}));
  CHECK_FALSE(sees(camera, {0, 1.01, -1}));
  CHECK_FALSE(sees(camera, {0, -1.01, -1}));
  CHECK(sees(camera, {1.99, 0, -1}));
  CHECK_FALSE(sees(camera, {2.01, 0, -1}));
  CHECK_FALSE(sees(camera, {-2.01, 0, -1}));
  CHECK(camera.meets(std::vector<Point>{{-100, -100, -5}, {100, -100, -5}, {0, 100, -5}}));
}

TEST_CASE("camera: a triangle with a point in the picture is never said to be outside") {
  const Camera camera(plain());
  std::mt19937 random(5);
  const auto number = [&](double reach) { return reach * (static_cast<double>(random() % 4097) / 2048 - 1); };
  for (int i = 0; i < 20000; ++i) {
    const double depth = 2.5 + number(2.4);
    const Point inside{number(2 * depth), number(depth), -depth}, a{number(9), number(9), number(9)},
        b{number(9), number(9), number(9)};
    // The third corner is such that the point is in the middle.
    const Point c{3 * inside[0] - a[0] - b[0], 3 * inside[1] - a[1] - b[1], 3 * inside[2] - a[2] - b[2]};
    CHECK(camera.meets(std::vector<Point>{a, b, c}));
    CHECK(camera.depth(std::vector<Point>{a, b, c}) <= depth);
    CHECK(camera.eye_distance(std::vector<Point>{a, b, c}) <= std::sqrt(product(inside, inside)));
  }
}

TEST_CASE("camera: a box is what its corners are") {
  View view = plain();
  view.eye = {0.5, -1, 2};
  view.direction = {1, 0.3, -2};
  const Camera camera(view);
  std::mt19937 random(7);
  const auto number = [&](double reach) { return reach * (static_cast<double>(random() % 4097) / 2048 - 1); };
  int seen = 0;
  for (int i = 0; i < 20000; ++i) {
    Box box{{number(9), number(9), number(9)}, {}};
    for (std::size_t axis = 0; axis < 3; ++axis)
      box.max[axis] = box.min[axis] + std::fabs(number(3));
    const std::array<Point, 8> corners = box_corners(box.min, box.max);
    REQUIRE(camera.meets(box) == camera.meets(corners));
    CHECK(camera.depth(box) == Approx(camera.depth(corners)).margin(1e-12));
    CHECK(camera.eye_distance(box) == camera.eye_distance(corners));
    seen += camera.meets(box) ? 1 : 0;
  }
  CHECK(seen > 1000);
  CHECK(seen < 19000);
}

TEST_CASE("camera: a length that is allowed never looks longer than it may") {
  const Camera camera(plain());
  std::mt19937 random(6);
  const auto number = [&](double reach) { return reach * (static_cast<double>(random() % 4097) / 2048 - 1); };
  double longest = 0;
  for (int i = 0; i < 200000; ++i) {
    const double depth = 2.5 + number(2.4), pixels = 0.1 + std::fabs(number(20));
    // Most at the rim of the picture, where lengths look longest.
    const double x = i % 2 == 0 ? 2 : number(2), y = i % 2 == 0 ? 1 : number(1);
    const Point p{x * depth, y * depth, -depth};
    const double length = camera.length_of(pixels, depth);
    CHECK(camera.pixels_of(length, depth) == Approx(pixels));
    Point q{number(1), number(1), number(1)};
    if (i % 4 == 0) q = {-1, 0.0, -std::fabs(x)}; // across the line of sight
    const double scale = length / std::sqrt(product(q, q));
    for (std::size_t axis = 0; axis < 3; ++axis)
      q[axis] = p[axis] + scale * q[axis];
    if (q[2] >= 0 || std::fabs(q[0]) > -2 * q[2] || std::fabs(q[1]) > -q[2]) continue;
    const double focal = 50;
    const double seen = std::hypot(focal * (q[0] / -q[2] - p[0] / -p[2]), focal * (q[1] / -q[2] - p[1] / -p[2]));
    CHECK(seen <= pixels * (1 + 1e-9));
    longest = std::max(longest, seen / pixels);
  }
  CHECK(longest > 0.7); // and is not allowed far too little
  CHECK(std::isinf(camera.pixels_of(2, 1)));
  CHECK(camera.pixels_of(0, 0) == 0);
}
