// Requests are about the original: what they ask for holds where the mesh leaves parts of it outside, too.
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"
#include "support/brute_force.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <span>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

constexpr double kPi = 3.14159265358979323846;

/// With a field "spikes", 0 but at some vertices, and built down as far as it goes wherever the boundary goes.
struct Built {
  TetMesh original;
  std::shared_ptr<const Dataset> dataset;

  [[nodiscard]] Extraction base() const {
    Request coarsest;
    coarsest.max_tets = 0;
    return dataset->extract(coarsest);
  }
};
Built build(TetMesh mesh, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<double> spikes(mesh.vertex_count(), 0);
  for (double& value : spikes)
    if (random() % 8 == 0) value = static_cast<double>(random() % 100) / 100;
  PointArray array;
  array.name = "spikes";
  array.type = ScalarType::kFloat64;
  array.components = 1;
  const auto bytes = std::as_bytes(std::span(spikes));
  array.bytes.assign(bytes.begin(), bytes.end());
  mesh.point_arrays = {array};
  BuildOptions options;
  options.prediction = Prediction::kQuadric;
  options.evaluation = Evaluation::kExact;
  options.max_domain_error = {1, true};
  options.target_vertices = 0;
  return {mesh, Dataset::open_memory(build_memory(mesh, options))};
}

/// The vertices on its boundary alone.
std::set<std::uint32_t> on_boundary_of(const TetMesh& mesh) {
  std::set<std::uint32_t> all;
  for (const test::Face& face : test::examine(mesh).boundary)
    for (const VertexId v : face)
      all.insert(v.index());
  return all;
}

std::set<Point> places(const TetMesh& mesh) {
  std::set<Point> all;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    all.insert(mesh.position(VertexId(v)));
  return all;
}

double distance_to_boundary(const Extraction& mesh, const Point& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& face : mesh.boundary_faces) {
    std::array<Point, 3> corners;
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] = mesh.mesh.position(face[i]);
    least = std::min(least, test::nearest_on_triangle(p, corners).distance);
  }
  return least;
}

} // namespace

TEST_CASE("outside: with no bounds, all that has a value of interest is the original, wherever it is") {
  std::size_t asked = 0, outside_of_base = 0;
  for (const auto& [name, mesh] : test::sample_meshes(43))
    for (unsigned seed = 0; seed < 4; ++seed) {
      INFO(name << ", spikes " << seed);
      const Built built = build(mesh, seed);
      const std::set<Point> in_base = places(built.base().mesh);
      for (const double least : {0.05, 0.3, 0.6, 0.8, 0.95}) {
        Request request;
        request.values = {{"spikes", least, least + 0.04}};
        const Extraction cut = built.dataset->extract(request);
        const std::set<Point> there = places(cut.mesh);
        std::size_t lost = 0, wanted = 0;
        for (std::uint32_t v = 0; v < built.original.vertex_count(); ++v) {
          const double value = built.original.point_arrays[0].value(v, 0);
          if (value < least || value > least + 0.04) continue;
          ++wanted;
          lost += there.count(built.original.position(VertexId(v))) == 0 ? 1 : 0;
          outside_of_base += in_base.count(built.original.position(VertexId(v))) == 0 ? 1 : 0;
        }
        CHECK(lost == 0);
        CHECK((wanted == 0 || unmet_wishes(request, cut).values.empty()));
        ++asked;
      }
    }
  CHECK(asked > 100);
  CHECK(outside_of_base > 100);
}

TEST_CASE("outside: what a picture would show of the original is as sharp as was asked, though the mesh is beside it") {
  std::size_t looked = 0, beside = 0;
  for (const auto& [name, mesh] : test::sample_meshes(47)) {
    const Built built = build(mesh, 1);
    const DatasetInfo& info = built.dataset->info();
    const Extraction base = built.base();
    std::mt19937 random(3);
    const auto uniform = [&] { return static_cast<double>(random() % 1000001) / 1e6; };
    for (const std::uint32_t v : on_boundary_of(built.original)) {
      const Point at = built.original.position(VertexId(v));
      if (random() % 4 != 0 || distance_to_boundary(base, at) < 0.01 * info.diagonal) continue;
      Request request;
      View& view = request.view.emplace();
      double length = 0;
      for (double& x : view.direction) {
        x = uniform() - 0.5;
        length += x * x;
      }
      const double far = info.diagonal * (0.5 + uniform());
      for (std::size_t i = 0; i < 3; ++i)
        view.eye[i] = at[i] - far * view.direction[i] / std::sqrt(length);
      view.up = {view.direction[1], -view.direction[0], 0.3};
      view.vertical_angle = (0.05 + uniform()) * kPi / 180;
      view.width = view.height = 1000;
      view.max_pixels = 1 + 20 * uniform();
      const double focal = view.height / (2 * std::tan(view.vertical_angle / 2));
      INFO(name << ", vertex " << v << ", angle " << view.vertical_angle);
      for (const bool is_asked : {true, false}) { // where nothing is asked what is lost is told
        if (!is_asked) view.max_pixels = 1e9;
        const Extraction cut = built.dataset->extract(request);
        const double off = focal * distance_to_boundary(cut, at) / far;
        CHECK(off <= view.max_pixels * 1.01);
        CHECK(off <= cut.pixels_in_view * 1.01 + 1e-6);
        CHECK(focal * cut.in_view->domain_error / far >= off * 0.99 - 1e-6);
        if (!is_asked) beside += off > 20 ? 1 : 0;
      }
      ++looked;
    }
  }
  CHECK(looked > 60);
  CHECK(beside > 40);
}

// A focus so small that only a point of the original is in it, and a face that lies beside it stands for that.
TEST_CASE("outside: a point of the original's boundary in a focus is as near to the mesh as was asked") {
  std::size_t lost = 0, asked = 0;
  for (const auto& [name, mesh] : test::sample_meshes(59))
    for (unsigned seed = 0; seed < 2; ++seed) {
      const Built built = build(mesh, seed);
      const double diagonal = built.dataset->info().diagonal;
      const Extraction base = built.base();
      Request request;
      std::mt19937 random(seed);
      for (const std::uint32_t v : on_boundary_of(built.original)) {
        const Point at = built.original.position(VertexId(v));
        const double off = distance_to_boundary(base, at);
        if (off < 0.001 * diagonal) continue;
        for (int i = 0; i < 6; ++i) {
          INFO(name << ", vertex " << v << ", error " << i);
          Focus focus{Sphere{at, 1e-9 * diagonal}, {0.1 * (i + 1) * off / diagonal, true}};
          double allowed = focus.error.value * diagonal;
          if (i % 2 == 0) { // beside the focus, where it grows with the distance, and so it does for the face
            Point& centre = std::get<Sphere>(focus.region).centre;
            centre[i / 2] += (random() % 2 == 0 ? 0.2 : -0.2) * off;
            focus.error.value = 0;
            focus.falloff = Bound{1.0 + i, true};
            allowed = (1.0 + i) * (0.2 * off - 1e-9 * diagonal);
          }
          request.focus = {focus};
          const Extraction cut = built.dataset->extract(request);
          lost += distance_to_boundary(cut, at) > allowed * (1 + 1e-9) ? 1 : 0;
          ++asked;
        }
      }
    }
  CHECK(lost == 0);
  CHECK(asked > 500);
}

TEST_CASE("outside: the original's boundary in a focus, and on the way from it, is as near to the mesh as was asked") {
  std::size_t inside = 0, lost_in_base = 0;
  double told = 0, most = 0;
  for (const auto& [name, mesh] : test::sample_meshes(53)) {
    const Built built = build(mesh, 2);
    const DatasetInfo& info = built.dataset->info();
    std::vector<Point> on_boundary;
    for (const std::uint32_t v : on_boundary_of(built.original))
      on_boundary.push_back(built.original.position(VertexId(v)));
    const Extraction base = built.base();
    std::mt19937 random(5);
    const auto uniform = [&] { return static_cast<double>(random() % 1000001) / 1e6; };
    for (int i = 0; i < 40; ++i) {
      INFO(name << ", focus " << i);
      const Sphere sphere{on_boundary[random() % on_boundary.size()], 0.08 * uniform() * uniform() * info.diagonal};
      Focus focus{sphere, {0.15 * uniform(), true}};
      if (i % 2 == 0) focus.falloff = Bound{uniform(), true};
      Request request;
      request.focus = {focus};
      const Extraction cut = built.dataset->extract(request);
      double in_focus = 0;
      for (const Point& p : on_boundary) {
        const double apart = std::max(
            0.0, std::hypot(p[0] - sphere.centre[0], p[1] - sphere.centre[1], p[2] - sphere.centre[2]) - sphere.radius);
        if (apart > 0 && !focus.falloff) continue;
        const double allowed = focus.error.value * info.diagonal + (focus.falloff ? focus.falloff->value * apart : 0);
        const double off = distance_to_boundary(cut, p);
        CHECK(off <= allowed * (1 + 1e-9));
        if (apart > 0) continue;
        in_focus = std::max(in_focus, off);
        ++inside;
        lost_in_base += distance_to_boundary(base, p) > allowed ? 1 : 0;
      }
      CHECK(cut.in_focus.front().domain_error >= in_focus * (1 - 1e-9));
      told += cut.in_focus.front().domain_error;
      most += in_focus;
    }
  }
  CHECK(inside > 200);
  CHECK(lost_in_base > 40);
  CHECK(told < 20 * most);
}
