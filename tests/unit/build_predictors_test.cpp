// What holds for every predictor of half-edge collapses.
#include "build/gradient_predictor.hpp"
#include "build/local_predictor.hpp"
#include "build/per_tet_predictor.hpp"
#include "build/quadric_predictor.hpp"
#include "build/weighted_sum_predictor.hpp"
#include "build_predictor_fixture.hpp"
#include "mesh/box_tree.hpp"

#include <memory>
#include <thread>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::build::test;
using build::Predictor;
using build::Vertex;
using build::WeightedSumPredictor;

namespace {

enum Kind { kLocal, kGradient, kQuadric, kPerTet, kWeightedSum, kKinds };

std::unique_ptr<Predictor> make(Kind kind, const Scene& s, const std::vector<double>& field_weight = {1},
                                double domain_weight = 16) {
  const auto as = [&]<class P>(P*, const auto&... more) -> std::unique_ptr<Predictor> {
    return std::make_unique<P>(s.complex, s.points(), s.fields, s.diagonal, field_weight, domain_weight, more...);
  };
  switch (kind) {
  case kLocal: return as(static_cast<build::LocalPredictor*>(nullptr));
  case kGradient: return as(static_cast<build::GradientPredictor*>(nullptr));
  case kQuadric: return as(static_cast<build::QuadricPredictor*>(nullptr));
  case kPerTet: return as(static_cast<build::PerTetPredictor*>(nullptr));
  default: break;
  }
  return as(static_cast<WeightedSumPredictor*>(nullptr), WeightedSumPredictor::Weights{});
}

std::vector<double> linear(const Point& p) {
  return {0.1 * p[0] - 7 * p[1] + p[2] / 3};
}

/// A bit for each side of the grid that `v` is on.
unsigned sides_of(const Scene& scene, Vertex v) {
  BoundingBox box;
  for (const Point& p : scene.points())
    box.add(p);
  unsigned sides = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    sides |= (scene.points()[v][axis] == box.low[axis] ? 1U : 0U) << axis;
    sides |= (scene.points()[v][axis] == box.high[axis] ? 8U : 0U) << axis;
  }
  return sides;
}

constexpr auto kNothing = [](Vertex, Vertex) {};

} // namespace

TEST_CASE("predictors: a linear field costs nothing inside", "[build][predictor]") {
  for (const Kind kind : {kLocal, kGradient, kQuadric, kPerTet}) {
    CAPTURE(kind);
    Scene scene(prepared_grid(linear));
    const auto predictor = make(kind, scene);
    // Squares lose half of the digits.
    const double rounding = kind == kQuadric ? 2e-7 : 1e-12;
    int seen = 0;
    const auto check = [&](Vertex vs, Vertex vd) {
      ++seen;
      CHECK(scene.field_error(*predictor, vs, vd) == Approx(0).margin(rounding));
      CHECK(Scene::cost(*predictor, vs, vd) == Approx(scene.length_part(vs, vd)).margin(1e-11 + 5 * rounding));
    };
    CHECK(scene.random_collapses(15, true, {predictor.get()}, check, kNothing) == 15);
    CHECK(seen >= 15);
  }
}

TEST_CASE("predictors: a curved field costs something", "[build][predictor]") {
  for (int kind = 0; kind < kKinds; ++kind) {
    CAPTURE(kind);
    Scene scene(prepared_grid(curved));
    const auto predictor = make(static_cast<Kind>(kind), scene);
    for (Vertex v = 0; v < scene.complex.vertex_count(); ++v)
      for (const Vertex x : scene.neighbours(v))
        if (scene.is_inner(v)) CHECK(scene.field_error(*predictor, v, x) > 1e-6);
  }
}

TEST_CASE("predictors: the units of mesh and field do not matter", "[build][predictor]") {
  for (int kind = 0; kind < kKinds; ++kind) {
    CAPTURE(kind);
    Scene scene(prepared_grid(curved));
    PreparedMesh large = prepared_grid([](const Point& p) { return std::vector<double>{40 - 1e6 * curved(p)[0]}; });
    for (Point& p : large.points)
      for (double& x : p)
        x = 1000 * x + 7;
    Scene scaled(std::move(large), 1000 * scene.diagonal);
    const auto predictor = make(static_cast<Kind>(kind), scene);
    const auto other = make(static_cast<Kind>(kind), scaled);
    int accepted = 0;
    const auto check = [&](Vertex vs, Vertex vd) {
      CHECK(Scene::cost(*other, vs, vd) == Approx(Scene::cost(*predictor, vs, vd)).epsilon(1e-5).margin(1e-7));
      CHECK(scaled.field_error(*other, vs, vd) ==
            Approx(scene.field_error(*predictor, vs, vd)).epsilon(1e-5).margin(1e-7));
    };
    const auto follow = [&](Vertex vs, Vertex vd) { accepted += scaled.collapse(vs, vd, {other.get()}) ? 1 : 0; };
    CHECK(scene.random_collapses(40, false, {predictor.get()}, check, follow) == 40);
    CHECK(accepted == 40);
  }
}

TEST_CASE("predictors: what was lost stays lost", "[build][predictor]") {
  for (const Kind kind : {kLocal, kGradient, kPerTet}) {
    CAPTURE(kind);
    Scene scene(prepared_grid(curved));
    const auto predictor = make(kind, scene, {1}, 1e-9);
    double error = 0;
    double cost = 0;
    double largest = 0;
    const auto before = [&](Vertex vs, Vertex vd) {
      error = scene.field_error(*predictor, vs, vd);
      cost = Scene::cost(*predictor, vs, vd);
      CHECK(cost == Approx(error + scene.length_part(vs, vd)).margin(1e-6));
    };
    const auto after = [&](Vertex, Vertex vd) {
      largest = std::max(largest, error);
      for (const Vertex x : scene.neighbours(vd))
        CHECK(scene.field_error(*predictor, vd, x) >= error);
    };
    CHECK(scene.random_collapses(60, false, {predictor.get()}, before, after) == 60);
    CHECK(largest > 0.05);
  }
}

TEST_CASE("predictors: the domain is accumulated too", "[build][predictor]") {
  for (const Kind kind : {kLocal, kGradient, kPerTet}) {
    CAPTURE(kind);
    Scene scene(prepared_grid(curved));
    const auto predictor = make(kind, scene, {1e-9}, 1);
    double cost = 0;
    bool inner = false;
    int moved = 0;
    const auto before = [&](Vertex vs, Vertex vd) {
      inner = scene.is_inner(vs);
      cost = Scene::cost(*predictor, vs, vd) - scene.length_part(vs, vd);
      if (inner) CHECK(cost == Approx(0).margin(1e-6));
    };
    const auto after = [&](Vertex, Vertex vd) {
      if (inner || cost < 1e-6) return;
      ++moved;
      for (const Vertex x : scene.neighbours(vd))
        CHECK(Scene::cost(*predictor, vd, x) >= cost - 1e-7);
    };
    CHECK(scene.random_collapses(60, false, {predictor.get()}, before, after) == 60);
    CHECK(moved > 5);
  }
}

TEST_CASE("predictors: the domain error is what the domain costs", "[build][predictor]") {
  for (const Kind kind : {kLocal, kGradient, kPerTet}) {
    CAPTURE(kind);
    Scene scene(prepared_grid(curved));
    const auto predictor = make(kind, scene, {1e-9}, 1);
    int moved = 0;
    const auto check = [&](Vertex vs, Vertex vd) {
      const double error = predictor->domain_error(vs, vd);
      CHECK(error == Approx(Scene::cost(*predictor, vs, vd) - scene.length_part(vs, vd)).margin(1e-6));
      if (scene.is_inner(vs)) CHECK(error == 0);
      moved += error > 1e-3 ? 1 : 0;
    };
    CHECK(scene.random_collapses(60, false, {predictor.get()}, check, kNothing) == 60);
    CHECK(moved > 5);
  }
}

TEST_CASE("predictors: what stays in its plane leaves the domain as it is", "[build][predictor]") {
  ptet::test::GridOptions options;
  options.jitter = 0;
  const Scene scene(prepare(ptet::test::grid(options)));
  for (int kind = 0; kind < kKinds; ++kind) {
    CAPTURE(kind);
    const auto predictor = make(static_cast<Kind>(kind), scene, std::vector<double>(scene.fields.field_count(), 1));
    int within = 0;
    int across = 0;
    for (Vertex vs = 0; vs < scene.complex.vertex_count(); ++vs)
      for (const Vertex vd : scene.neighbours(vs)) {
        const double error = predictor->domain_error(vs, vd);
        if (scene.is_inner(vs)) CHECK(error == 0);
        if (scene.is_inner(vs) || scene.is_inner(vd)) continue;
        const bool stays = (sides_of(scene, vs) & ~sides_of(scene, vd)) == 0;
        (stays ? within : across) += 1;
        if (stays)
          CHECK(error == 0);
        else
          CHECK(error > 1e-3);
      }
    CHECK(within > 100);
    CHECK(across > 20);
  }
}

TEST_CASE("predictors: several fields, each by its own weight", "[build][predictor]") {
  TetMesh mesh = ptet::test::grid({});
  mesh.point_arrays.clear();
  ptet::test::add_array(mesh, "linear", ScalarType::kFloat64, 1, linear);
  ptet::test::add_array(mesh, "curved", ScalarType::kFloat64, 1, curved);
  ptet::test::add_array(mesh, "vector", ScalarType::kFloat64, 3, [](const Point& p) {
    return std::vector<double>{p[0], 0.01 * p[1] * p[1], p[2]};
  });
  Scene scene(prepare(std::move(mesh)));
  for (const Kind kind : {kLocal, kGradient, kPerTet, kWeightedSum}) {
    CAPTURE(kind);
    const std::vector<double> weight{1, 2, 5};
    const auto predictor = make(kind, scene, weight, 0);
    const auto weightless = make(kind, scene, {0, 0, 0}, 0);
    for (Vertex v = 0; v < scene.complex.vertex_count(); ++v) {
      if (!scene.is_inner(v)) continue;
      for (const Vertex x : scene.neighbours(v)) {
        std::array<double, 3> errors{-1, -1, -1};
        predictor->field_errors(v, x, errors);
        const double worst = std::max({weight[0] * errors[0], weight[1] * errors[1], weight[2] * errors[2]});
        if (kind != kWeightedSum) CHECK(errors[0] == Approx(0).margin(1e-12)); // it is linear
        CHECK(errors[2] > 0);
        CHECK(Scene::cost(*predictor, v, x) == Approx(worst + Scene::cost(*weightless, v, x)).epsilon(1e-5));
      }
    }
  }
}

TEST_CASE("predictors: several threads at once get what one gets", "[build][predictor]") {
  Scene scene(prepared_grid(curved));
  for (int kind = 0; kind < kKinds; ++kind) {
    CAPTURE(kind);
    const auto predictor = make(static_cast<Kind>(kind), scene);
    const auto all_costs = [&](std::vector<float>& into) {
      for (Vertex v = 0; v < scene.complex.vertex_count(); ++v) {
        const auto targets = scene.neighbours(v);
        std::vector<float> costs(targets.size());
        predictor->costs(v, targets, costs);
        into.insert(into.end(), costs.begin(), costs.end());
      }
    };
    std::vector<float> alone;
    all_costs(alone);
    std::vector<std::vector<float>> found(4);
    std::vector<std::thread> threads;
    threads.reserve(found.size());
    for (auto& into : found)
      threads.emplace_back([&] { all_costs(into); });
    for (std::thread& thread : threads)
      thread.join();
    for (const auto& costs : found)
      CHECK(costs == alone);
  }
}
