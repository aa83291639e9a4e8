// Quadrics behind the common interface, and the errors they stand for.
#include "build/quadric_predictor.hpp"
#include "build_predictor_fixture.hpp"

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::build::test;
using build::QuadricPredictor;
using build::Vertex;

namespace {

QuadricPredictor make(const Scene& scene) {
  return {scene.complex, scene.points(), scene.fields, scene.diagonal, {1}, 16};
}

} // namespace

TEST_CASE("quadric predictor: the error is the root mean square over the tets", "[build][predictor]") {
  Scene scene(octahedron(), scalars({1, 3, 5, 6, 2, 4, 10}));
  QuadricPredictor predictor = make(scene);
  // The four tets that hold 0 have its value; the others go on from 3 over 10 to 17, but it is 1.
  CHECK(scene.field_error(predictor, 6, 0) == Approx(16.0 / 9 * std::sqrt(0.5)));
  // Now 0 stands for 8 + 4 tets, all of them at 6, half of them on the side of 4 and half on that of 5.
  // Those of 5 go on from 4 over 10 to 16, but at 4 it is 2; those of 3 from 6 over 10 to 14, but at 2 it is 5.
  REQUIRE(scene.collapse(6, 0, {&predictor}));
  CHECK(scene.field_error(predictor, 0, 4) == Approx(14.0 / 9 * std::sqrt(0.5)));
  CHECK(scene.field_error(predictor, 0, 2) == Approx(9.0 / 9 * std::sqrt(0.5)));
}

TEST_CASE("quadric predictor: needles have gradients, and where all is flat values are compared",
          "[build][predictor]") {
  const auto error_when = [](double y, double z) {
    Fixture squeezed = octahedron();
    for (Point& p : squeezed.points)
      p = {p[0], p[1] * y, p[2] * z};
    const Scene scene(squeezed, scalars({1, 3, 5, 6, 2, 4, 10}));
    return scene.field_error(make(scene), 6, 0);
  };
  CHECK(error_when(1e-6, 1e-6) == Approx(16.0 / 9 * std::sqrt(0.5)));
  CHECK(error_when(1, 1e-6) == Approx(16.0 / 9 * std::sqrt(0.5)));
  CHECK(error_when(1, 1e-12) == Approx(9.0 / 9));
  CHECK(error_when(1e-6, 1e-12) == Approx(9.0 / 9));
}

TEST_CASE("quadric predictor: the domain error is the root mean square over the planes", "[build][predictor]") {
  const Scene scene(octahedron(), scalars({1, 3, 5, 6, 2, 4, 10})); // of diagonal 4
  QuadricPredictor predictor = make(scene);
  CHECK(predictor.domain_error(6, 0) == 0);
  // Of the planes at (1, 0, 0) two go through (0, 0, 1), and two are 2 / sqrt(3) away.
  CHECK(predictor.domain_error(0, 4) == Approx(std::sqrt(2.0 / 3) / 4));
  // Now it carries its own four, too: six of the eight are so far from (0, 0, -1), and half of them from (0, 1, 0).
  predictor.merge(0, 4);
  CHECK(predictor.domain_error(4, 5) == Approx(1.0 / 4));
  CHECK(predictor.domain_error(4, 2) == Approx(std::sqrt(2.0 / 3) / 4));
}

TEST_CASE("quadric predictor: in a plane no domain error comes of rounding", "[build][predictor]") {
  for (int turn = 1; turn < 12; ++turn) {
    const double angle = 0.5 * turn;
    Fixture flat = tent(0);
    for (Point& p : flat.points) {
      const double y = std::cos(angle) * p[1] - std::sin(angle) * p[2];
      const double z = std::sin(angle) * p[1] + std::cos(angle) * p[2];
      p = {std::cos(angle) * p[0] - std::sin(angle) * y, std::sin(angle) * p[0] + std::cos(angle) * y, z};
    }
    const Scene scene(flat, scalars({1, 3, 5, 6, 2, 4}));
    CHECK(make(scene).domain_error(0, 2) == 0);
    CHECK(make(scene).domain_error(0, 4) == 0);
  }
}

TEST_CASE("quadric predictor: the interface says what the inline function says", "[build][predictor]") {
  Scene scene(prepared_grid(curved));
  QuadricPredictor told = make(scene);
  QuadricPredictor merged = make(scene);
  const auto after = [&](Vertex vs, Vertex vd) {
    merged.merge(vs, vd);
    const auto targets = scene.neighbours(vd);
    std::vector<float> costs(targets.size(), -1.0F);
    told.costs(vd, targets, costs);
    for (std::size_t i = 0; i < targets.size(); ++i)
      CHECK(costs[i] == merged.cost(vd, targets[i]));
  };
  CHECK(scene.random_collapses(
            40, false, {&told}, [](Vertex, Vertex) {}, after) == 40);
}
