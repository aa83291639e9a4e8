// Removed vertices and the field errors at them, by hand.
#include "build/removed_vertices.hpp"
#include "build_predictor_fixture.hpp"
#include "mesh/closest_point.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using build::CollapseCheck;
using build::CoveredPoints;
using build::Vertex;
using build::test::Fixture;
using build::test::Ghosts;
using build::test::octahedron;
using build::test::scalars;
using build::test::tent;
using build::test::with_field;

namespace {

struct Holding {
  Holding(const std::vector<Point>& points, const std::vector<std::vector<double>>& values,
          CoveredPoints covered = CoveredPoints::kMove)
      : prepared(with_field(points, values)), removed(prepared.points, fields, 4, covered) {}
  PreparedMesh prepared;
  build::NormalizedFields fields{prepared, {}};
  build::RemovedVertices removed;
  build::RemovedVertices::Simulation seen;

  /// Collapses, and returns the error seen as a fraction of the range.
  double collapse(Fixture& fixture, Vertex vs, Vertex vd, std::optional<bool> boundary_moves = {}) {
    CollapseCheck check(fixture.complex, fixture.points, 0, 64);
    REQUIRE(check.examine(vs, vd) == CollapseStatus::kAccepted);
    removed.simulate(fixture.complex, vs, vd, check.deleted(), check.modified(),
                     boundary_moves.value_or(check.moves_boundary()), seen);
    REQUIRE(seen.errors().size() == 1);
    const double error = seen.errors()[0];
    removed.commit(fixture.complex, check.deleted(), seen);
    fixture.complex.collapse(vs, vd, check.deleted(), check.modified());
    return error;
  }
};

/// The tent with tip 0 at (0, 0, 1), and behind it the points 6 .. 10 of a second body, `cover()`.
std::vector<Point> tent_and_cover_points() {
  std::vector<Point> points = tent(1).points;
  points.insert(points.end(), {{0, 0, 0.6}, {0, 0, 3}, {-1, 0, 0.5}, {1, -1, 0.5}, {1, 1, 0.5}, {0, 0, 3.5}});
  return points;
}
/// The tent, where 0 goes to 2, and a body where 6 goes up to 7: the tet 7 8 9 10 then covers the tip. No ghosts: the
/// tests say themselves when a boundary moves.
Fixture tent_and_cover(const std::vector<std::array<Vertex, 4>>& more = {}) {
  std::vector<std::array<Vertex, 4>> tets = {{0, 1, 2, 3}, {0, 1, 3, 4},  {0, 1, 4, 5},
                                             {0, 1, 5, 2}, {6, 8, 9, 10}, {6, 7, 8, 9}};
  tets.insert(tets.end(), more.begin(), more.end());
  return {tent_and_cover_points(), tets, Ghosts::kNone};
}

} // namespace

TEST_CASE("removed: a vertex inside is compared with the tet that it lies in", "[build][removed]") {
  Fixture f = octahedron();
  // On the axis 0 1, half way: (1 + 3) / 2, but it was 10. Values range over 9.
  Holding h(f.points, scalars({1, 3, 5, 6, 2, 4, 10}));
  CHECK(h.fields.fields()[0].range == 9);
  CHECK(h.collapse(f, 6, 0) == Approx(8.0 / 9));
  // Now 0 goes to 4: the vertex 6 lies on the edge 4 5, and so does the point nearest to 0, which is left outside:
  // 3 in both places.
  CHECK(h.collapse(f, 0, 4) == Approx(7.0 / 9));
}

TEST_CASE("removed: what lies on the linear field has no error", "[build][removed]") {
  Fixture f = octahedron();
  std::vector<double> values;
  for (const Point& p : f.points)
    values.push_back(0.1 * p[0] - 7 * p[1] + p[2] / 3);
  Holding h(f.points, scalars(values));
  CHECK(h.collapse(f, 6, 0) == 0);
}

TEST_CASE("removed: an error is seen beside a fill value and on top of an offset", "[build][removed]") {
  for (const double fill : {1e20, -9.96921e36}) {
    Fixture f = octahedron();
    // On the axis 0 1, half way: (1 + 3) / 2, but it was 10. A vertex far away has the fill value.
    f.points.push_back({9, 9, 9});
    Holding h(f.points, scalars({1, 3, 5, 6, 2, 4, 10, fill}));
    CHECK(h.collapse(f, 6, 0) * h.fields.fields()[0].range == Approx(8).epsilon(1e-12));
  }
  Fixture f = octahedron();
  std::vector<double> values;
  for (const Point& p : f.points)
    values.push_back(0x1p50 + 8 * p[0] - 4 * p[1] + 2 * p[2]);
  values[6] += 0.25;
  Holding h(f.points, scalars(values));
  CHECK(h.fields.fields()[0].range == 16);
  CHECK(h.collapse(f, 6, 0) == 0.25 / 16);
}

TEST_CASE("removed: vectors are compared by Euclidean distance", "[build][removed]") {
  Fixture f = octahedron();
  // Off by (3, 4) at the centre, in a box of values with a diagonal of 5.
  std::vector<std::vector<double>> values(7, {0, 0});
  values[6] = {3, 4};
  Holding h(f.points, values);
  CHECK(h.fields.fields()[0].range == 5);
  CHECK(h.collapse(f, 6, 0) == Approx(1));
}

TEST_CASE("removed: a vertex left outside is compared with the closest point", "[build][removed]") {
  Fixture f = tent(1);
  // The tip has 6; below it, on the edge 2 4, there is (1 + 3) / 2. The foot's 100 would blow up a linear extension.
  Holding h(f.points, scalars({6, 100, 1, 0, 3, 0}));
  CHECK(h.collapse(f, 0, 2) == Approx(0.04));
}

TEST_CASE("removed: of all tets a vertex left outside is compared with the nearest", "[build][removed]") {
  constexpr std::uint32_t kRing = 8;
  std::mt19937 random(7);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int seen = 0;
  for (int round = 0; round < 400; ++round) {
    // A tent over an uneven ring: tip 0, foot 1, and the tip goes to 2.
    std::vector<Point> points{{between(-0.3, 0.3), between(-0.3, 0.3), 0.7}, {0, 0, -1}};
    std::vector<double> values{0, 100};
    std::vector<std::array<Vertex, 4>> tets;
    for (std::uint32_t i = 0; i < kRing; ++i) {
      const double angle = 2 * std::numbers::pi * i / kRing, radius = between(0.6, 1.6);
      points.push_back({radius * std::cos(angle), radius * std::sin(angle), between(-0.3, 0.5)});
      values.push_back(between(0, 100));
      tets.push_back({0, 1, 2 + i, 2 + (i + 1) % kRing});
    }
    Fixture f(points, tets, Ghosts::kNone);
    if (CollapseCheck(f.complex, f.points, 0, 64).examine(0, 2) != CollapseStatus::kAccepted) continue;
    double least = std::numeric_limits<double>::infinity();
    double expected = 0;
    for (std::uint32_t i = 1; i + 1 < kRing; ++i) {
      const std::array<Vertex, 4> corners{2, 1, 2 + i, 3 + i};
      const ClosestOnTet on = closest_on_tet_surface(
          points[0], {points[corners[0]], points[corners[1]], points[corners[2]], points[corners[3]]});
      if (!(on.distance_sq < least)) continue;
      least = on.distance_sq;
      expected = 0;
      for (std::size_t k = 0; k < 4; ++k)
        expected += on.weight[k] * values[corners[k]];
    }
    Holding h(f.points, scalars(values));
    const double error = h.collapse(f, 0, 2);
    if (least < 1e-6) continue; // it may as well lie inside
    CHECK(error == Approx(expected / 100));
    ++seen;
  }
  CHECK(seen > 100);
}

TEST_CASE("removed: a simulation alone changes nothing", "[build][removed]") {
  Fixture f = octahedron();
  Holding h(f.points, scalars({1, 3, 5, 6, 2, 4, 10}));
  CollapseCheck check(f.complex, f.points, 0, 64);
  for (const Vertex vd : {0U, 2U, 4U, 0U}) {
    REQUIRE(check.examine(6, vd) == CollapseStatus::kAccepted);
    h.removed.simulate(f.complex, 6, vd, check.deleted(), check.modified(), check.moves_boundary(), h.seen);
    const double middle = vd == 0 ? 2 : vd == 2 ? 5.5 : 3;
    CHECK(h.seen.errors()[0] == Approx((10 - middle) / 9));
  }
  CHECK(f.complex.validate() == "");
  for (build::SlotId s = 0; s < f.complex.slot_count(); ++s)
    CHECK(f.complex.slot(s).first_point == build::kNone);
}

TEST_CASE("removed: what squared errors grow by is the trapezoidal rule at the vertices", "[build][removed]") {
  Fixture f = octahedron();
  Holding h(f.points, scalars({1, 3, 5, 6, 2, 4, 10}));
  CHECK(h.collapse(f, 6, 0) == Approx(8.0 / 9)); // nobody has asked for squares
  CHECK(h.seen.squared_growth()[0] == 0);

  f = octahedron();
  Holding weighed(f.points, scalars({1, 3, 5, 6, 2, 4, 10}));
  weighed.removed.weigh({2, 1, 1, 1, 1, 1, 3});
  weighed.collapse(f, 6, 0);
  CHECK(weighed.seen.squared_growth()[0] == Approx(3 * 64.0 / 81));
  // The vertex 6 has 3 now instead of 2, which is nearer to its 10; 0 lies outside.
  weighed.collapse(f, 0, 4);
  CHECK(weighed.seen.squared_growth()[0] == Approx(3 * (49 - 64.0) / 81));
}

TEST_CASE("removed: a point outside counts for a tet that comes to cover it later", "[build][removed]") {
  //                               0  1    2  3  4  5  6     7  8  9  10 11
  Holding h(tent_and_cover_points(), scalars({6, 100, 1, 0, 3, 0, 0.32, 8, 0, 0, 0, 0}));
  Fixture f = tent_and_cover();
  REQUIRE(h.collapse(f, 0, 2, true) == Approx(0.04));
  // In the tet 7 8 9 10 the vertex 6 has 0.04 * 8, as it had, and the tip 0.2 * 8, but it was 6.
  CHECK(h.collapse(f, 6, 7, true) == Approx(0.044));
}

TEST_CASE("removed: a point outside counts for the tets that replace one that covers it", "[build][removed]") {
  //                               0  1    2  3  4  5  6     7  8  9  10 11
  Holding h(tent_and_cover_points(), scalars({6, 100, 1, 0, 3, 0, 0.32, 8, 0, 0, 0, 10}));
  Fixture f = tent_and_cover({{7, 11, 8, 9}});
  REQUIRE(h.collapse(f, 0, 2, true) == Approx(0.04));
  REQUIRE(h.collapse(f, 6, 7, true) == Approx(0.044));
  // The boundary stays as it is now, but the tet 7 8 9 10 that covers the tip becomes 11 8 9 10, where the tip has
  // 10 / 6, but it was 6; 7 has 10 * 2.5 / 3, but it was 8.
  CHECK(h.collapse(f, 7, 11, false) == Approx((6 - 10.0 / 6) / 100));
}

TEST_CASE("removed: a point that is covered is let go by the tet that held it", "[build][removed]") {
  Holding h(tent_and_cover_points(), scalars({6, 100, 1, 0, 3, 0, 0.32, 8, 0, 0, 0, 0}));
  Fixture f = tent_and_cover();
  h.collapse(f, 0, 2, true);
  h.collapse(f, 6, 7, true);
  std::vector<Vertex> firsts;
  for (build::SlotId s = 0; s < f.complex.slot_count(); ++s)
    if (f.complex.slot(s).first_point != build::kNone) firsts.push_back(f.complex.slot(s).first_point);
  CHECK(firsts.size() == 1);
}

TEST_CASE("removed: a point that is covered stays with the tet that held it where that is asked", "[build][removed]") {
  Holding h(tent_and_cover_points(), scalars({6, 100, 1, 0, 3, 0, 0.32, 8, 0, 0, 0, 0}), CoveredPoints::kStay);
  Fixture f = tent_and_cover();
  REQUIRE(h.collapse(f, 0, 2, true) == Approx(0.04));
  // Of the two that the tet 7 8 9 10 covers the tip is not seen, and the vertex 6 has what it had.
  CHECK(h.collapse(f, 6, 7, true) == Approx(0).margin(1e-12));
  std::vector<Vertex> firsts;
  for (build::SlotId s = 0; s < f.complex.slot_count(); ++s)
    if (f.complex.slot(s).first_point != build::kNone) firsts.push_back(f.complex.slot(s).first_point);
  CHECK(firsts.size() == 2);
}
