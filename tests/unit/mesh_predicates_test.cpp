// Predicates against exact integer arithmetic, on input where plain floating point goes wrong.
#include "mesh/face_plane.hpp"
#include "mesh/predicates.hpp"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

namespace {

using ptet::faces_meet_improperly;
using ptet::Point;
using ptet::triangles_cross;
using ptet::VertexId;

__extension__ using Integer = __int128;
using IntegerPoint = std::array<std::int64_t, 3>;

int sign(Integer x) {
  return x > 0 ? 1 : x < 0 ? -1 : 0;
}

Integer dot(const IntegerPoint& u, const IntegerPoint& v) {
  return Integer{u[0]} * v[0] + Integer{u[1]} * v[1] + Integer{u[2]} * v[2];
}
/// det(u, v, w); coordinates up to 2^41.
Integer determinant(const IntegerPoint& u, const IntegerPoint& v, const IntegerPoint& w) {
  return u[0] * (Integer{v[1]} * w[2] - Integer{v[2]} * w[1]) - u[1] * (Integer{v[0]} * w[2] - Integer{v[2]} * w[0]) +
         u[2] * (Integer{v[0]} * w[1] - Integer{v[1]} * w[0]);
}
IntegerPoint minus(const IntegerPoint& u, const IntegerPoint& v) {
  return {u[0] - v[0], u[1] - v[1], u[2] - v[2]};
}
IntegerPoint cross(const IntegerPoint& u, const IntegerPoint& v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
bool is_zero(const IntegerPoint& u) {
  return u == IntegerPoint{};
}

int exact_orientation(const std::array<IntegerPoint, 4>& p) {
  return sign(determinant(minus(p[1], p[0]), minus(p[2], p[0]), minus(p[3], p[0])));
}
Point scaled(const IntegerPoint& p, double scale) {
  return {static_cast<double>(p[0]) * scale, static_cast<double>(p[1]) * scale, static_cast<double>(p[2]) * scale};
}
int naive_orientation(const std::array<IntegerPoint, 4>& p) {
  std::array<Point, 3> d{};
  for (std::size_t i = 0; i < 3; ++i)
    d[i] = scaled(minus(p[i + 1], p[0]), 1);
  const double det = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                     d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                     d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
  return det > 0 ? 1 : det < 0 ? -1 : 0;
}

/// Four points near a line near a plane, coordinates up to 2^40.
std::array<IntegerPoint, 4> nearly_flat(std::mt19937_64& random) {
  std::uniform_int_distribution<std::int64_t> coordinate(-(std::int64_t{1} << 38), std::int64_t{1} << 38), small(-1, 1);
  std::uniform_real_distribution<double> along(-1.5, 1.5);
  const IntegerPoint a{coordinate(random), coordinate(random), coordinate(random)};
  const IntegerPoint direction{coordinate(random), coordinate(random), coordinate(random)};
  std::array<IntegerPoint, 4> points{a, a, a, a};
  for (std::size_t i = 1; i < 4; ++i) {
    const double s = along(random);
    for (std::size_t k = 0; k < 3; ++k)
      points[i][k] += std::llround(s * static_cast<double>(direction[k])) + small(random);
  }
  return points;
}

/// Whether the origin is in the convex hull of at most four points.
bool hull_holds_origin(const std::vector<IntegerPoint>& p) {
  switch (p.size()) {
  case 1: return is_zero(p[0]);
  case 2: return is_zero(cross(p[0], p[1])) && dot(p[0], p[1]) <= 0;
  case 3: {
    const IntegerPoint normal = cross(minus(p[1], p[0]), minus(p[2], p[0]));
    return !is_zero(normal) && dot(p[0], normal) == 0 && dot(cross(p[0], p[1]), normal) >= 0 &&
           dot(cross(p[1], p[2]), normal) >= 0 && dot(cross(p[2], p[0]), normal) >= 0;
  }
  default: {
    const int whole = sign(determinant(minus(p[1], p[0]), minus(p[2], p[0]), minus(p[3], p[0])));
    return whole != 0 && whole * sign(determinant(p[1], p[2], p[3])) >= 0 &&
           whole * sign(determinant(p[0], p[3], p[2])) >= 0 && whole * sign(determinant(p[0], p[1], p[3])) >= 0 &&
           whole * sign(determinant(p[0], p[2], p[1])) >= 0;
  }
  }
}

/// Whether the origin is in the convex hull: if so, it is in that of at most four of the points (Caratheodory).
bool origin_in_hull(const std::vector<IntegerPoint>& points) {
  for (unsigned subset = 1; subset < 1U << points.size(); ++subset) {
    std::vector<IntegerPoint> chosen;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (subset >> i & 1) chosen.push_back(points[i]);
    if (chosen.size() <= 4 && hull_holds_origin(chosen)) return true;
  }
  return false;
}

std::array<IntegerPoint, 5> five_grid_points(std::mt19937& random, int size) {
  std::array<IntegerPoint, 5> points{};
  for (IntegerPoint& p : points)
    for (std::int64_t& x : p)
      x = static_cast<std::int64_t>(random() % static_cast<unsigned>(size));
  return points;
}
bool collinear(const IntegerPoint& a, const IntegerPoint& b, const IntegerPoint& c) {
  return is_zero(cross(minus(b, a), minus(c, a)));
}

ptet::Face face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return {VertexId{a}, VertexId{b}, VertexId{c}};
}

} // namespace

TEST_CASE("orientation of a positive tet is +1", "[predicates]") {
  const Point a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0}, d{0, 0, 1};
  CHECK(ptet::orientation(a, b, c, d) == 1);
  CHECK(ptet::orientation(a, c, b, d) == -1);
  CHECK(ptet::orientation(a, b, c, {0.25, 0.25, 0}) == 0);
  CHECK(ptet::orientation(a, b, c, {0.25, 0.25, 5e-324}) == 1);
  CHECK(ptet::orientation(a, a, c, d) == 0);
}

TEST_CASE("orientation agrees with integer arithmetic on nearly flat tets, at every scale", "[predicates]") {
  std::mt19937_64 random(1);
  int naive_is_wrong = 0;
  std::array<int, 3> signs{};
  for (int i = 0; i < 20000; ++i) {
    const std::array<IntegerPoint, 4> p = nearly_flat(random);
    const int expected = exact_orientation(p);
    naive_is_wrong += naive_orientation(p) != expected;
    ++signs[static_cast<std::size_t>(expected + 1)];
    // 2^-382 leaves the terms of the determinant a few bits, 2^-500 none; 2^400 lets them overflow.
    for (const int exponent : {0, -60, -382, -500, 400}) {
      const double scale = std::ldexp(1.0, exponent);
      const int got =
          ptet::orientation(scaled(p[0], scale), scaled(p[1], scale), scaled(p[2], scale), scaled(p[3], scale));
      if (got != expected) FAIL("tet " << i << " at scale " << scale << ": " << got << ", not " << expected);
    }
  }
  // The input is hard enough to tell the difference, and has all signs.
  CHECK(naive_is_wrong > 100);
  CHECK(signs[0] > 1000);
  CHECK(signs[2] > 1000);
}

TEST_CASE("triangles_cross agrees with integer arithmetic, degenerate and touching triangles too", "[predicates]") {
  std::mt19937 random(2);
  std::array<int, 2> answers{};
  int degenerate = 0;
  for (int i = 0; i < 5000; ++i) {
    const int size = 2 + i % 4;
    std::array<IntegerPoint, 3> s{}, t{};
    for (auto* triangle : {&s, &t})
      for (IntegerPoint& p : *triangle)
        p = five_grid_points(random, size)[0];
    std::vector<IntegerPoint> differences;
    for (const IntegerPoint& p : s)
      for (const IntegerPoint& q : t)
        differences.push_back(minus(p, q));
    const bool expected = origin_in_hull(differences);
    ++answers[expected];
    degenerate += collinear(s[0], s[1], s[2]) || collinear(t[0], t[1], t[2]);
    if (triangles_cross({scaled(s[0], 1), scaled(s[1], 1), scaled(s[2], 1)},
                        {scaled(t[0], 1), scaled(t[1], 1), scaled(t[2], 1)}) != expected)
      FAIL("pair " << i << ": not " << expected);
  }
  CHECK(answers[0] > 500);
  CHECK(answers[1] > 500);
  CHECK(degenerate > 500);
}

TEST_CASE("faces that share a vertex may meet only there", "[predicates]") {
  std::mt19937 random(3);
  std::array<int, 2> answers{};
  for (int i = 0; i < 8000; ++i) {
    const auto p = five_grid_points(random, 3 + i % 3);
    if (collinear(p[0], p[1], p[2]) || collinear(p[0], p[3], p[4])) continue;
    // Both span cones at p[0]; these have a ray in common exactly if u's and -v's positive combinations reach 0.
    const bool expected = origin_in_hull({minus(p[1], p[0]), minus(p[2], p[0]), minus(p[0], p[3]), minus(p[0], p[4])});
    ++answers[expected];
    std::vector<Point> points;
    for (const IntegerPoint& q : p)
      points.push_back(scaled(q, 1));
    if (faces_meet_improperly(face(1, 0, 2), face(3, 4, 0), points) != expected) FAIL("pair " << i);
    if (faces_meet_improperly(face(4, 0, 3), face(0, 2, 1), points) != expected) FAIL("pair " << i << " swapped");
  }
  CHECK(answers[0] > 500);
  CHECK(answers[1] > 500);
}

TEST_CASE("faces that share an edge meet improperly only when folded flat onto each other", "[predicates]") {
  const std::vector<Point> points = {{0, 0, 0},   {1, 0, 0}, {0.3, 1, 0}, {0.6, -1, 0}, {0.6, 2, 0}, {0.6, 2, 1e-300},
                                     {0.5, 0, 0}, {2, 0, 0}, {3, 0, 0},   {-1, 0, 0},   {0, 0, 0},   {-2, 0, 0}};
  CHECK_FALSE(faces_meet_improperly(face(0, 1, 2), face(1, 0, 3), points)); // flat continuation
  CHECK(faces_meet_improperly(face(0, 1, 2), face(1, 0, 4), points));       // folded onto itself
  CHECK_FALSE(faces_meet_improperly(face(0, 1, 2), face(1, 0, 5), points)); // but for a hair
  CHECK(faces_meet_improperly(face(0, 1, 2), face(2, 1, 0), points));       // the same vertices
  // Degenerate faces: one within its edge, some beyond it.
  CHECK_FALSE(faces_meet_improperly(face(0, 1, 6), face(1, 0, 4), points));
  CHECK_FALSE(faces_meet_improperly(face(0, 1, 7), face(1, 0, 4), points));
  CHECK(faces_meet_improperly(face(0, 1, 7), face(1, 0, 8), points));
  CHECK_FALSE(faces_meet_improperly(face(0, 1, 7), face(1, 0, 9), points));
  CHECK(faces_meet_improperly(face(0, 1, 9), face(1, 0, 11), points));
  // An edge of no length, vertices 0 and 10: then it is as if they shared a vertex.
  CHECK(faces_meet_improperly(face(0, 10, 7), face(10, 0, 8), points));
  CHECK_FALSE(faces_meet_improperly(face(0, 10, 7), face(10, 0, 9), points));
}

TEST_CASE("degenerate faces that share a vertex", "[predicates]") {
  const std::vector<Point> points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 0}};
  CHECK_FALSE(faces_meet_improperly(face(0, 1, 2), face(0, 3, 4), points)); // segment against a triangle, only at 0
  CHECK_FALSE(faces_meet_improperly(face(0, 1, 2), face(0, 2, 5), points)); // within an edge that they share
  CHECK(faces_meet_improperly(face(0, 1, 3), face(0, 2, 5), points));       // the segment passes through 0
  CHECK_FALSE(faces_meet_improperly(face(0, 6, 3), face(0, 2, 5), points)); // a segment away from it
}

TEST_CASE("what the plane of a face tells apart does not meet it", "[predicates]") {
  std::mt19937 random(4);
  std::array<int, 2> answers{};
  for (int i = 0; i < 20000; ++i) {
    std::vector<Point> points;
    for (int k = 0; k < 6; ++k)
      points.push_back(scaled(five_grid_points(random, 3 + i % 3)[0], i % 2 == 0 ? 1 : 0x1p-500));
    const std::uint32_t common = static_cast<std::uint32_t>(i) % 4; // the last so many vertices are the face's
    const ptet::Face one = face(2, 0, 1), other = face(common > 0 ? 0 : 3, common > 1 ? 1 : 4, common > 2 ? 2 : 5);
    const bool missed = ptet::FacePlane(one, points).surely_misses(other, points);
    ++answers[missed];
    if (missed && faces_meet_improperly(one, other, points)) FAIL("pair " << i);
  }
  CHECK(answers[0] > 500);
  CHECK(answers[1] > 500);
}

TEST_CASE("the planes of a bipyramid's thin faces tell all their pairs apart", "[predicates]") {
  constexpr std::uint32_t kCount = 200;
  std::vector<Point> points = {{0, 0, 1}, {0, 0, -1}};
  std::vector<ptet::Face> faces;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double angle = 6.283185307179586 * i / kCount;
    points.push_back({std::cos(angle), std::sin(angle), 0});
    faces.push_back(face(0, 2 + i, 2 + (i + 1) % kCount));
    faces.push_back(face(1, 2 + (i + 1) % kCount, 2 + i));
  }
  std::size_t left = 0;
  for (const ptet::Face& one : faces) {
    const ptet::FacePlane plane(one, points);
    for (const ptet::Face& other : faces)
      left += &one != &other && !plane.surely_misses(other, points);
  }
  CHECK(left == 0);
}
