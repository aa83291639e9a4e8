// Gradients at vertices and what their differences say of collapses.
#include "build/gradient_predictor.hpp"
#include "build_predictor_fixture.hpp"

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::build::test;
using build::GradientPredictor;
using build::Vertex;

namespace {

constexpr double kPi = 3.14159265358979323846;

GradientPredictor make(const Scene& scene, double field_weight = 1, double domain_weight = 1) {
  return {scene.complex, scene.points(), scene.fields, scene.diagonal, {field_weight}, domain_weight};
}

/// A corner of a cube below and above the plane z = 0; 3 at the top, 4 at the bottom, `depth` below.
Fixture two_corners(double depth = 1) {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -depth}}, {{0, 1, 2, 3}, {0, 1, 2, 4}}};
}

} // namespace

TEST_CASE("gradient predictor: needles have gradients", "[build][predictor]") {
  Fixture needles = octahedron();
  for (Point& p : needles.points)
    p = {p[0], p[1] * 1e-6, p[2] * 1e-6};
  const Scene scene(needles, scalars({1, 3, 5, 6, 2, 4, 10}));
  CHECK(scene.field_error(make(scene), 6, 0) > 0.1);
}

TEST_CASE("solid angle: an octant, a thin and a flat one, and around a vertex", "[build][predictor]") {
  CHECK(build::solid_angle({0, 0, 0}, {1, 0, 0}, {0, 7, 0}, {0, 0, 0.1}) == Approx(kPi / 2));
  CHECK(build::solid_angle({0, 0, 0}, {0, 7, 0}, {1, 0, 0}, {0, 0, 0.1}) == Approx(kPi / 2));
  // Far away a triangle is seen as its area over the square of the distance.
  CHECK(build::solid_angle({0, 0, 1000}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}) == Approx(0.5e-6).epsilon(1e-3));
  // From inside a triangle everything on one side of it.
  CHECK(build::solid_angle({0.2, 0.2, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}) == Approx(2 * kPi));
  const Scene scene(prepared_grid(curved));
  std::vector<double> sum(scene.complex.vertex_count());
  const auto& p = scene.points();
  for (const Tet& t : scene.prepared.mesh.tets)
    for (std::size_t i = 0; i < 4; ++i)
      sum[t[i].index()] += build::solid_angle(p[t[i].index()], p[t[(i + 1) % 4].index()], p[t[(i + 2) % 4].index()],
                                              p[t[(i + 3) % 4].index()]);
  int inner = 0;
  for (Vertex v = 0; v < scene.complex.vertex_count(); ++v)
    if (scene.is_inner(v)) {
      ++inner;
      CHECK(sum[v] == Approx(4 * kPi));
    } else {
      CHECK(sum[v] < 4 * kPi - 0.1);
    }
  CHECK(inner == 27);
}

TEST_CASE("gradient: the mean over the tets, weighted by solid angle", "[build][predictor]") {
  // |z|: gradients (0, 0, 1) and (0, 0, -1). Lengths count in diagonals of 4.
  Scene scene(two_corners(), scalars({0, 0, 0, 1, 1}));
  const auto g = build::vertex_gradients(scene.complex, scene.points(), scene.fields, scene.diagonal);
  REQUIRE(g.size() == 5);
  CHECK(norm(g[0]) == Approx(0).margin(1e-15));
  CHECK(g[3][2] == Approx(4));
  CHECK(g[4][2] == Approx(-4));
  // The gradients differ by (0, 0, 1), the range is 1: what counts is how far an edge leads up.
  CHECK(scene.field_error(make(scene), 3, 0) == Approx(1));
  CHECK(scene.field_error(make(scene), 3, 1) == Approx(1));
  CHECK(scene.field_error(make(scene), 0, 1) == Approx(0).margin(1e-15));
}

TEST_CASE("gradient: unequal solid angles", "[build][predictor]") {
  // z above, 0 below; at 1 the tets are seen under different angles, at 0 both under a right one.
  Scene scene(two_corners(3), scalars({0, 0, 0, 1, 0}));
  const auto g = build::vertex_gradients(scene.complex, scene.points(), scene.fields, 1);
  const auto& p = scene.points();
  CHECK(g[0][2] == Approx(0.5));
  const double above = build::solid_angle(p[1], p[0], p[2], p[3]);
  const double below = build::solid_angle(p[1], p[0], p[2], p[4]);
  REQUIRE(below > 1.5 * above);
  CHECK(g[1][2] == Approx(above / (above + below)));
}

TEST_CASE("gradient: vectors by the Euclidean norm over the components", "[build][predictor]") {
  // (3 |z|, 4 |z|) / 5 has the same range and the same differences as |z|.
  Scene scene(two_corners(), {{0, 0}, {0, 0}, {0, 0}, {0.6, 0.8}, {0.6, 0.8}});
  CHECK(scene.field_error(make(scene), 3, 0) == Approx(1));
}

TEST_CASE("gradient: flat tets have no say", "[build][predictor]") {
  Fixture fixture({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}}, {{0, 1, 2, 3}, {0, 1, 2, 4}});
  Scene scene(fixture, scalars({0, 0, 0, 1, 100}));
  const auto g = build::vertex_gradients(scene.complex, scene.points(), scene.fields, 100);
  CHECK(g[0][2] == Approx(1));
  CHECK(norm(g[4]) == 0);
}

TEST_CASE("gradient: the domain and the accumulation are as for local errors", "[build][predictor]") {
  Scene scene(tent(1), scalars({6, 100, 1, 0, 3, 0}));
  GradientPredictor predictor = make(scene);
  CHECK(predictor.domain_error(0, 2) == Approx(0.25));
  CHECK(Scene::cost(make(scene, 1e-9, 16), 0, 2) == Approx(4 + scene.length_part(0, 2)));
  const double first = scene.field_error(predictor, 0, 2);
  const double alone = scene.field_error(predictor, 2, 3);
  REQUIRE(first > 0);
  REQUIRE(scene.collapse(0, 2, {&predictor}));
  CHECK(scene.field_error(predictor, 2, 3) == Approx(first + alone));
}
