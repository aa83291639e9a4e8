// Local error accumulation: by hand, and against a search over all tets.
#include "build/local_predictor.hpp"
#include "build_predictor_fixture.hpp"
#include "support/brute_force.hpp"

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::build::test;
using build::LocalPredictor;
using build::SlotId;
using build::Vertex;

namespace {

LocalPredictor make(const Scene& scene, double field_weight = 1, double domain_weight = 1) {
  return {scene.complex, scene.points(), scene.fields, scene.diagonal, {field_weight}, domain_weight};
}

} // namespace

TEST_CASE("local: the value lost is compared with that of the tet in its place", "[build][predictor]") {
  // On the axis 0 1, half way: (1 + 3) / 2, but it was 10. Values range over 9.
  Scene scene(octahedron(), scalars({1, 3, 5, 6, 2, 4, 10}));
  const LocalPredictor predictor = make(scene);
  CHECK(scene.field_error(predictor, 6, 0) == Approx(8.0 / 9));
  CHECK(scene.field_error(predictor, 6, 2) == Approx((10 - 5.5) / 9));
  CHECK(predictor.domain_error(6, 0) == 0);
  CHECK(Scene::cost(predictor, 6, 0) == Approx(8.0 / 9 + scene.length_part(6, 0)));
}

TEST_CASE("local: vectors are compared by Euclidean distance", "[build][predictor]") {
  std::vector<std::vector<double>> values(7, {0, 0});
  values[6] = {3, 4};
  Scene scene(octahedron(), values);
  CHECK(scene.field_error(make(scene), 6, 0) == Approx(1));
}

TEST_CASE("local: a boundary vertex against closest points, and the larger weighted error", "[build][predictor]") {
  // The tip has 6; below it, on the edge 2 4, there is (1 + 3) / 2. Values range over 100, the diagonal is 4.
  Scene scene(tent(1), scalars({6, 100, 1, 0, 3, 0}));
  const LocalPredictor predictor = make(scene);
  CHECK(scene.field_error(predictor, 0, 2) == Approx(0.04));
  CHECK(predictor.domain_error(0, 2) == Approx(0.25));
  CHECK(Scene::cost(predictor, 0, 2) == Approx(0.25 + scene.length_part(0, 2)));
  CHECK(Scene::cost(make(scene, 1, 16), 0, 2) == Approx(4 + scene.length_part(0, 2)));
  CHECK(Scene::cost(make(scene, 50, 1), 0, 2) == Approx(2 + scene.length_part(0, 2)));
}

TEST_CASE("local: errors of the vertex that is taken away add up", "[build][predictor]") {
  Scene scene(octahedron(), scalars({1, 3, 5, 6, 2, 4, 10}));
  LocalPredictor predictor = make(scene);
  REQUIRE(scene.collapse(6, 0, {&predictor}));
  // Now 0 goes to 4. What is left nearest to it is the middle of the edge 4 5 with (2 + 4) / 2, at a distance of 1
  // of 4.
  CHECK(scene.field_error(predictor, 0, 4) == Approx(8.0 / 9 + 2.0 / 9));
  CHECK(predictor.domain_error(0, 4) == Approx(0.25));
}

TEST_CASE("local: errors go to all vertices of the modified tets, and to no others", "[build][predictor]") {
  Scene scene(prepared_grid(curved));
  LocalPredictor predictor = make(scene);
  const LocalPredictor forgetful = make(scene);
  std::vector<double> expected(scene.complex.vertex_count());
  std::vector<double> domain(scene.complex.vertex_count());
  std::vector<double> field_before;
  std::vector<double> domain_before;
  const auto before = [&](Vertex vs, Vertex vd) {
    const double error = expected[vs] + scene.field_error(forgetful, vs, vd);
    const double moved = domain[vs] + forgetful.domain_error(vs, vd);
    CHECK(scene.field_error(predictor, vs, vd) == Approx(error).margin(1e-12));
    if (!scene.is_inner(vs)) CHECK(predictor.domain_error(vs, vd) == Approx(moved).margin(1e-12));
    field_before = expected;
    domain_before = domain;
    for (const SlotId s : scene.complex.star(vs)) {
      const auto& v = scene.complex.slot(s).v;
      if (std::find(v.begin(), v.end(), vd) != v.end()) continue;
      const bool ghost = scene.complex.is_ghost(scene.complex.slot(s));
      for (Vertex x : v) {
        if (x == scene.complex.dummy()) continue;
        if (x == vs) x = vd;
        auto& of_x = ghost ? domain[x] : expected[x];
        of_x = std::max(of_x, ghost ? moved : error);
      }
    }
    // Until it is known whether the collapse is allowed.
    field_before.swap(expected);
    domain_before.swap(domain);
  };
  const auto after = [&](Vertex, Vertex) {
    expected = field_before;
    domain = domain_before;
  };
  CHECK(scene.random_collapses(60, false, {&predictor}, before, after) == 60);
  CHECK(*std::max_element(expected.begin(), expected.end()) > 0.1);
  CHECK(*std::max_element(domain.begin(), domain.end()) > 0.01);
}

TEST_CASE("local: the same as a search over all tets", "[build][predictor]") {
  Scene scene(prepared_grid(curved));
  const LocalPredictor predictor = make(scene);
  build::CollapseCheck check(scene.complex, scene.points(), 0, 64);
  int compared = 0;
  int outside = 0;
  for (Vertex vs = 0; vs < scene.complex.vertex_count(); ++vs)
    for (const Vertex vd : scene.neighbours(vs)) {
      if (check.examine(vs, vd) != CollapseStatus::kAccepted) continue;
      double nearest = std::numeric_limits<double>::infinity();
      std::vector<double> values; // at all the nearest points: they need not agree where a boundary moves
      for (const Tet& tet : scene.prepared.mesh.tets) {
        std::array<Vertex, 4> v = {tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()};
        if (std::find(v.begin(), v.end(), vs) == v.end() || std::find(v.begin(), v.end(), vd) != v.end()) continue;
        std::replace(v.begin(), v.end(), vs, vd);
        const auto on = ptet::test::nearest_on_tet(scene.points()[vs], {scene.points()[v[0]], scene.points()[v[1]],
                                                                        scene.points()[v[2]], scene.points()[v[3]]});
        double value = 0;
        for (std::size_t i = 0; i < 4; ++i)
          value += on.weight[i] * *scene.fields.at(v[i]);
        if (on.distance < nearest - 1e-9) values.clear();
        if (on.distance <= nearest + 1e-9) values.push_back(value);
        nearest = std::min(nearest, on.distance);
      }
      const double error = scene.field_error(predictor, vs, vd);
      CHECK(std::any_of(values.begin(), values.end(),
                        [&](double value) { return std::abs(error - std::abs(value - *scene.fields.at(vs))) < 1e-9; }));
      ++compared;
      outside += nearest > 1e-6 ? 1 : 0;
    }
  CHECK(compared > 300);
  CHECK(outside > 20);
}
