// The three terms of the weighted sum, each alone and by hand.
#include "build/weighted_sum_predictor.hpp"
#include "build_predictor_fixture.hpp"

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::build::test;
using build::Vertex;
using build::WeightedSumPredictor;
using Weights = WeightedSumPredictor::Weights;

namespace {

WeightedSumPredictor make(const Scene& scene, const Weights& weights, double field_weight = 1,
                          double domain_weight = 1) {
  return {scene.complex, scene.points(), scene.fields, scene.diagonal, {field_weight}, domain_weight, weights};
}

} // namespace

TEST_CASE("weighted sum: the terms", "[build][predictor]") {
  // The tent is 4 large, so its four tets are 1 large on average, and so is the face.
  Scene scene(tent(1), scalars({6, 100, 1, 0, 3, 0}));
  const auto cost = [&](const Weights& weights, double field_weight = 1, double domain_weight = 1) {
    return Scene::cost(make(scene, weights, field_weight, domain_weight), 0, 2);
  };
  CHECK(cost({0, 0, 0}) == 0);
  // |6 - 1| of 100.
  CHECK(cost({1, 0, 0}) == Approx(0.05));
  CHECK(cost({3, 0, 0}, 2) == Approx(0.3));
  // The pyramid above the ring is lost: 4 / 3 over a face of 1, of a diagonal of 4.
  CHECK(cost({0, 1, 0}) == Approx(1.0 / 3));
  CHECK(cost({0, 2, 0}, 1, 16) == Approx(32.0 / 3));
  // 2 gets edges to the foot, across the ring and along it, each in two tets or in one of each kind.
  const std::array<double, 3> length{std::sqrt(6.0), 2.0, 2 * std::sqrt(2.0)};
  const double mean = (length[0] + length[1] + length[2]) / 3;
  const double unequal = (std::abs(length[0] - mean) + std::abs(length[1] - mean) + std::abs(length[2] - mean)) / 3;
  CHECK(cost({0, 0, 1}) == Approx(unequal / 4));
  CHECK(cost({1, 1, 1}) == Approx(0.05 + 1.0 / 3 + unequal / 4));
}

TEST_CASE("weighted sum: an inner vertex changes no volume", "[build][predictor]") {
  Scene scene(octahedron(), scalars({1, 3, 5, 6, 2, 4, 10}));
  CHECK(Scene::cost(make(scene, {0, 1, 0}), 6, 0) == 0);
  CHECK(scene.field_error(make(scene, {}), 6, 0) == Approx(1));
}

TEST_CASE("weighted sum: nothing is accumulated", "[build][predictor]") {
  Scene scene(octahedron(), scalars({1, 3, 5, 6, 2, 4, 10}));
  WeightedSumPredictor predictor = make(scene, {});
  REQUIRE(scene.collapse(6, 0, {&predictor}));
  CHECK(scene.field_error(predictor, 0, 4) == Approx(1.0 / 9));
}
