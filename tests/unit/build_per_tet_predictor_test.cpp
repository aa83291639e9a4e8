// Error bounds carried by tets: by hand, and against the two linear fields themselves.
#include "build/per_tet_predictor.hpp"
#include "build_predictor_fixture.hpp"
#include "support/brute_force.hpp"

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::build::test;
using build::PerTetPredictor;
using build::SlotId;
using build::Vertex;

namespace {

PerTetPredictor make(const Scene& scene, double field_weight = 1, double domain_weight = 1) {
  return {scene.complex, scene.points(), scene.fields, scene.diagonal, {field_weight}, domain_weight};
}

std::array<Point, 4> points_of(const Scene& scene, const std::array<Vertex, 4>& v) {
  return {scene.points()[v[0]], scene.points()[v[1]], scene.points()[v[2]], scene.points()[v[3]]};
}

/// The linear field of a tet at a vertex, inside or not.
double linear_at(const Scene& scene, const std::array<Vertex, 4>& v, Vertex x) {
  const auto weight = ptet::test::barycentrics(scene.points()[x], points_of(scene, v));
  REQUIRE(weight.has_value());
  double value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value += (*weight)[i] * *scene.fields.at(v[i]);
  return value;
}

} // namespace

TEST_CASE("per tet: the tets that are left carry the error", "[build][predictor]") {
  Scene scene(octahedron(), scalars({1, 3, 5, 6, 2, 4, 10}));
  PerTetPredictor predictor = make(scene);
  // Half way between 0 and 1 there is 2, but it was 10.
  CHECK(scene.field_error(predictor, 6, 0) == Approx(8.0 / 9));
  CHECK(Scene::cost(predictor, 6, 0) == Approx(8.0 / 9 + scene.length_part(6, 0)));
  CHECK(Scene::cost(make(scene, 3), 6, 0) == Approx(8.0 / 3 + scene.length_part(6, 0)));
  REQUIRE(scene.collapse(6, 0, {&predictor}));
  int tets = 0;
  for (const SlotId s : scene.complex.star(0)) {
    if (scene.complex.is_ghost(scene.complex.slot(s))) continue;
    ++tets;
    CHECK(predictor.tet_errors(s)[0] == Approx(8.0 / 9));
  }
  CHECK(tets == 4);
}

TEST_CASE("per tet: boundary faces carry the distance", "[build][predictor]") {
  Scene scene(tent(1), scalars({0, 1, 0, 0, 0, 0}));
  PerTetPredictor predictor = make(scene, 1e-9, 16);
  CHECK(Scene::cost(predictor, 0, 2) == Approx(4 + scene.length_part(0, 2)));
  REQUIRE(scene.collapse(0, 2, {&predictor}));
  int faces = 0;
  for (const SlotId s : scene.complex.star(2)) {
    const auto& slot = scene.complex.slot(s);
    if (!scene.complex.is_ghost(slot)) continue;
    // The two faces of the ring are new, the two down to the foot are not.
    const bool is_new = std::find(slot.v.begin(), slot.v.end(), 1) == slot.v.end();
    CHECK(predictor.face_error(s) == Approx(is_new ? 0.25 : 0).margin(1e-15));
    faces += is_new ? 1 : 0;
  }
  CHECK(faces == 2);
}

TEST_CASE("per tet: what a tet adds is how far its two linear fields are apart", "[build][predictor]") {
  Scene scene(prepared_grid(curved));
  PerTetPredictor predictor = make(scene);
  int lower_vd = 0;
  int changed = 0;
  std::vector<std::array<double, 2>> expected; // by slot: the error, or -1; for the collapse that is tried
  const auto before = [&](Vertex vs, Vertex vd) {
    expected.assign(scene.complex.slot_count(), {-1, -1});
    double deleted = 0;
    for (const SlotId s : scene.complex.star(vs)) {
      const auto& v = scene.complex.slot(s).v;
      if (std::find(v.begin(), v.end(), vd) != v.end() && !scene.complex.is_ghost(scene.complex.slot(s)))
        deleted = std::max(deleted, predictor.tet_errors(s)[0]);
    }
    for (const SlotId s : scene.complex.star(vs)) {
      const auto& old = scene.complex.slot(s).v;
      if (scene.complex.is_ghost(scene.complex.slot(s)) || std::find(old.begin(), old.end(), vd) != old.end()) continue;
      auto now = old;
      std::replace(now.begin(), now.end(), vs, vd);
      if (!ptet::test::barycentrics(scene.points()[vs], points_of(scene, now))) return; // flat: will be refused
      const double at_vs = std::abs(linear_at(scene, now, vs) - *scene.fields.at(vs));
      const double at_vd = std::abs(linear_at(scene, old, vd) - *scene.fields.at(vd));
      if (at_vd < at_vs) ++lower_vd;
      expected[s][0] = std::max(deleted, predictor.tet_errors(s)[0]) + std::min(at_vs, at_vd);
    }
  };
  const auto after = [&](Vertex, Vertex) {
    for (SlotId s = 0; s < expected.size(); ++s)
      if (expected[s][0] >= 0) {
        ++changed;
        CHECK(predictor.tet_errors(s)[0] == Approx(expected[s][0]).margin(1e-12));
      }
  };
  CHECK(scene.random_collapses(40, false, {&predictor}, before, after) == 40);
  CHECK(changed > 200);
  CHECK(lower_vd > 20);
}
