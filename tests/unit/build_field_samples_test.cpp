// Samples inside tets: how many, where, and with which values.
#include "build/field_samples.hpp"
#include "build_predictor_fixture.hpp"

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::build::test;
using build::choose_samples;
using build::FieldSamples;
using build::Sample;

namespace {

/// Largest difference of two corners, in values that are not scaled.
double variation(const Scene& scene, const Tet& tet) {
  double least = *scene.fields.at(tet[0].index());
  double most = least;
  for (const VertexId v : tet) {
    least = std::min(least, *scene.fields.at(v.index()));
    most = std::max(most, *scene.fields.at(v.index()));
  }
  return most - least;
}

} // namespace

TEST_CASE("samples: in number as the field varies", "[build][samples]") {
  const Scene scene(prepared_grid(curved));
  const auto& tets = scene.prepared.mesh.tets;
  double sum = 0;
  for (const Tet& tet : tets)
    sum += variation(scene, tet);
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{100}, tets.size(), 7 * tets.size()}) {
    const std::vector<Sample> found = choose_samples(tets, scene.fields, count);
    REQUIRE(found.size() == count);
    std::vector<double> number(tets.size());
    for (const Sample& sample : found)
      ++number.at(sample.tet);
    for (std::size_t t = 0; t < tets.size(); ++t)
      CHECK(std::abs(number[t] - static_cast<double>(count) * variation(scene, tets[t]) / sum) <= 1);
  }
  CHECK(choose_samples(tets, scene.fields).size() == tets.size());
}

TEST_CASE("samples: where nothing varies there are none", "[build][samples]") {
  const Scene constant(prepared_grid([](const Point&) { return std::vector<double>{3}; }));
  CHECK(choose_samples(constant.prepared.mesh.tets, constant.fields, 50).empty());
  const Scene half(prepared_grid([](const Point& p) { return std::vector<double>{std::max(0.0, p[0] - 30)}; }));
  const std::vector<Sample> found = choose_samples(half.prepared.mesh.tets, half.fields);
  CHECK(found.size() == half.prepared.mesh.tets.size());
  for (const Sample& sample : found)
    CHECK(variation(half, half.prepared.mesh.tets[sample.tet]) > 0);
}

TEST_CASE("samples: inside, with the values of the linear field there", "[build][samples]") {
  // A vector field, linear, so that its values are known at every position.
  const auto field = [](const Point& p) { return std::vector<double>{p[0] - 2 * p[1], 0.5 * p[2], 1}; };
  const Scene scene(prepared_grid(field, 3));
  const double unit = scene.fields.fields()[0].range * scene.fields.exact().scale(0);
  const auto& tets = scene.prepared.mesh.tets;
  const std::vector<Sample> samples = choose_samples(tets, scene.fields, 500);
  const FieldSamples found = look_at(samples, tets, scene.points(), scene.fields);
  REQUIRE(samples.size() == 500);
  REQUIRE(found.points.size() == 500);
  REQUIRE(found.values.size() == 1500);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& sample = samples[i];
    const Tet& tet = tets[sample.tet];
    Point expected{};
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      CHECK(sample.weight[k] > 0.01);
      sum += sample.weight[k];
      for (std::size_t axis = 0; axis < 3; ++axis)
        expected[axis] += sample.weight[k] * scene.points()[tet[k].index()][axis];
    }
    CHECK(sum == Approx(1));
    const auto value = field(expected);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK(found.points[i][axis] == Approx(expected[axis]).margin(1e-12));
      CHECK(found.values[3 * i + axis] * unit == Approx(value[axis]).margin(1e-9));
    }
  }
}

TEST_CASE("samples: several fields, the one that varies most", "[build][samples]") {
  PreparedMesh prepared = with_field({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0}, {0}, {1}, {4}});
  ptet::test::add_array(prepared.mesh, "g", ScalarType::kFloat64, 2, [](const Point& p) {
    return std::vector<double>{3 * p[0], 4 * p[0]};
  });
  const build::NormalizedFields fields(prepared, {});
  // f takes all of its range over the tet, and so does g between its vertices 0 and 1.
  CHECK(build::field_variation(fields, {0, 1, 2, 3}) == Approx(1));
  CHECK(build::field_variation(fields, {0, 2, 2, 0}) == Approx(0.25));
  CHECK(build::field_variation(fields, {0, 1, 0, 1}) == Approx(1));
  CHECK(build::field_variation(fields, {1, 1, 1, 1}) == 0);
}

TEST_CASE("samples: evenly spread over a tet, and the same every time", "[build][samples]") {
  const PreparedMesh prepared = with_field({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0}, {0}, {0}, {1}});
  const build::NormalizedFields fields(prepared, {});
  const std::vector<Tet> tets{{VertexId{0}, VertexId{1}, VertexId{2}, VertexId{3}}};
  const std::vector<Sample> found = choose_samples(tets, fields, 8000);
  std::array<int, 4> near_corner{};
  std::array<double, 4> mean{};
  for (const Sample& sample : found)
    for (std::size_t k = 0; k < 4; ++k) {
      // The margin moves every sample towards the middle by a sixteenth.
      near_corner[k] += (sample.weight[k] - 1.0 / 64) / (1 - 4.0 / 64) > 0.5 ? 1 : 0;
      mean[k] += sample.weight[k] / 8000;
    }
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK(mean[k] == Approx(0.25).epsilon(0.005));
    CHECK(near_corner[k] == Approx(1000).epsilon(0.02)); // an eighth of the volume
  }
  const std::vector<Sample> again = choose_samples(tets, fields, 8000);
  CHECK(std::equal(found.begin(), found.end(), again.begin(), again.end(),
                   [](const Sample& a, const Sample& b) { return a.tet == b.tet && a.weight == b.weight; }));
}
