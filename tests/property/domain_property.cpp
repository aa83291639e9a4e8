// The stated domain errors are upper bounds, both ways: dense samples of the original boundary and of the boundaries of
// cuts, each against all faces of the other.
#include "build/builder.hpp"
#include "support/brute_force.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

struct Built {
  PreparedMesh prepared;
  RecordStream stream;
};

using Corners = std::array<Point, 3>;

Built build_down(const TetMesh& mesh, double max_domain_error) {
  Built built{prepare(mesh), {}};
  BuildOptions options;
  options.target_vertices = 0;
  options.max_domain_error = {max_domain_error, true};
  options.prediction = Prediction::kQuadric;
  BuildReport report;
  built.stream = build::build_records(built.prepared, options, report, {});
  return built;
}

std::vector<Corners> original_faces(const Built& built) {
  std::vector<Corners> faces;
  for (const auto& face : built.prepared.boundary_faces) {
    Corners corners;
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] = built.prepared.points[face[i].index()];
    faces.push_back(corners);
  }
  return faces;
}

std::vector<Corners> faces_of(const Built& built, const test::CutMesh& cut) {
  std::vector<Corners> faces;
  for (const Tet& ghost : cut.ghosts) {
    Corners corners;
    std::size_t i = 0;
    for (const VertexId v : ghost)
      if (v != kDummyVertex) corners.at(i++) = built.prepared.points[v.index()];
    faces.push_back(corners);
  }
  return faces;
}

/// The largest distance of a point of a grid on each face to the other surface.
double sampled_distance(const std::vector<Corners>& from, const std::vector<Corners>& to, int steps) {
  double worst = 0;
  for (const Corners& face : from)
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; j <= steps - i; ++j) {
        const double u = double(i) / steps, v = double(j) / steps;
        Point p{};
        for (std::size_t axis = 0; axis < 3; ++axis)
          p[axis] = (1 - u - v) * face[0][axis] + u * face[1][axis] + v * face[2][axis];
        double nearest = std::numeric_limits<double>::infinity();
        for (const Corners& other : to) {
          nearest = std::min(nearest, test::nearest_on_triangle(p, other).distance);
          if (nearest <= worst) break;
        }
        worst = std::max(worst, nearest);
      }
  return worst;
}

struct Comparison {
  double stated, there, back;
};
Comparison compare(const Built& built, const std::vector<char>& is_split) {
  const test::CutMesh cut = test::cut_mesh(built.stream, is_split);
  const std::vector<Corners> original = original_faces(built), faces = faces_of(built, cut);
  return {test::largest_domain_error(built.stream, cut), sampled_distance(original, faces, 5),
          sampled_distance(faces, original, 12)};
}

std::vector<char> random_cut(const RecordStream& stream, std::mt19937& random) {
  std::vector<char> is_split(stream.size(), 0);
  // Some single records and all that they need, or all above an error.
  if (random() % 2 == 0) {
    for (std::size_t i = 1 + random() % 4; i > 0; --i)
      is_split[random() % stream.size()] = 1;
  } else {
    const double above = stream.domain_error[random() % stream.size()];
    for (std::size_t i = 0; i < stream.size(); ++i)
      is_split[i] = stream.domain_error[i] > above ? 1 : 0;
  }
  test::close_cut(stream, is_split);
  return is_split;
}

} // namespace

TEST_CASE("no point of either boundary is further from the other than stated", "[domain]") {
  std::mt19937 random(5);
  std::vector<double> ratio;
  for (const test::NamedMesh& named : test::sample_meshes(11)) {
    INFO(named.name);
    const Built built = build_down(named.mesh, 0.3);
    const double rounding = 1e-11 * built.stream.diagonal;
    REQUIRE(built.stream.size() > 30);
    for (int i = 0; i < 8; ++i) {
      INFO("cut " << i);
      const Comparison found =
          compare(built, i == 0 ? std::vector<char>(built.stream.size(), 0) : random_cut(built.stream, random));
      CHECK(found.there <= found.stated + rounding);
      CHECK(found.back <= found.stated + rounding);
      if (found.stated > rounding) ratio.push_back(found.stated / std::max(found.there, found.back));
    }
  }
  REQUIRE(ratio.size() > 30);
  // The samples miss some of the truth, and coarse cuts of coarse meshes have few faces to be near to.
  std::sort(ratio.begin(), ratio.end());
  CHECK(ratio[ratio.size() / 2] < 1.3);
}

TEST_CASE("where all faces of a body stay planes nothing is stated", "[domain]") {
  const Built built = build_down(test::grid({{6, 5, 4}, [](int x, int y, int) { return x < 3 || y < 2; }, 0, 3}), 0);
  REQUIRE(built.stream.size() > 100);
  for (const double error : built.stream.domain_error)
    CHECK(error == 0);
  const Comparison base = compare(built, std::vector<char>(built.stream.size(), 0));
  CHECK(base.there < 1e-11 * built.stream.diagonal);
  CHECK(base.back < 1e-11 * built.stream.diagonal);
}

TEST_CASE("a limit on the domain error holds both ways", "[domain]") {
  const Built built = build_down(test::sample_meshes(12).front().mesh, 0.05);
  for (const double error : built.stream.domain_error)
    CHECK(error <= 0.05 * built.stream.diagonal);
  const Comparison base = compare(built, std::vector<char>(built.stream.size(), 0));
  CHECK(base.there <= 0.05 * built.stream.diagonal);
  CHECK(base.back <= 0.05 * built.stream.diagonal);
  CHECK(base.stated > 0);
}

TEST_CASE("where errors are measured, no collapse is taken before the square has grown around its domain error",
          "[domain]") {
  BuildOptions options;
  options.target_vertices = 0;
  options.max_domain_error = {0.2, true};
  double weight = 10; // of the error as a part of the diagonal
  SECTION("thresholds") {
    options.max_field_error = {{"", {0.8, true}}};
    weight = 1 / 0.2;
  }
  SECTION("no thresholds") {}
  SECTION("the mean square alone") {
    options.objective = Objective::kRootMeanSquare;
    weight /= 3;
  }
  for (const test::NamedMesh& named : test::sample_meshes(13)) {
    INFO(named.name);
    BuildReport report;
    PreparedMesh prepared = prepare(named.mesh);
    const RecordStream stream = build::build_records(prepared, options, report, {});
    REQUIRE(stream.size() > 30);
    std::size_t step = 0;
    bool any = false;
    for (std::size_t i = 0; i < stream.size(); ++i) {
      if (i > 0 && stream.round[i] != stream.round[i - 1]) ++step;
      REQUIRE(step < report.walk.size());
      const double part = weight * stream.domain_error[i] / stream.diagonal;
      any |= part > 0;
      CHECK(part <= report.walk[step].cost * (1 + 1e-6));
    }
    CHECK(any);
  }
}
