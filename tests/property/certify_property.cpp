// The stated field errors hold at every point, not only at vertices: random points of every version against the
// original mesh, found by looking at all of its tets.
#include "build/builder.hpp"
#include "mesh/vec3.hpp"
#include "record/ghost.hpp"
#include "support/brute_force.hpp"
#include "support/meshes.hpp"
#include "support/versions.hpp"

#include <random>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

struct Built {
  PreparedMesh prepared;
  BuildReport report;
  RecordStream records;
};

Built build_with(const TetMesh& mesh, Evaluation evaluation, double max_domain_error = 1) {
  Built built{prepare(mesh), {}, {}};
  BuildOptions options;
  options.target_vertices = 0;
  options.max_domain_error = {max_domain_error, true};
  options.prediction = evaluation == Evaluation::kExact ? Prediction::kExact : Prediction::kQuadric;
  options.evaluation = evaluation;
  built.records = build::build_records(built.prepared, options, built.report, {});
  return built;
}

std::array<Point, 4> corners_of(const Built& built, const Tet& tet) {
  std::array<Point, 4> corners;
  for (std::size_t i = 0; i < 4; ++i)
    corners[i] = built.prepared.points[tet[i].index()];
  return corners;
}

Point random_point_in(const std::array<Point, 4>& corners, std::mt19937& random) {
  std::exponential_distribution<double> spread;
  std::array<double, 4> weight{};
  double sum = 0;
  for (double& w : weight)
    sum += w = spread(random);
  Point p{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] += weight[i] / sum * corners[i][axis];
  return p;
}

/// The value of the field at a point with these barycentric coordinates.
std::vector<double> interpolated(const PointArray& array, const Tet& tet, const std::array<double, 4>& weight) {
  std::vector<double> value(array.components);
  for (std::uint32_t c = 0; c < array.components; ++c)
    for (std::size_t i = 0; i < 4; ++i)
      value[c] += weight[i] * array.value(tet[i].index(), c);
  return value;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum_sq = 0;
  for (std::size_t c = 0; c < a.size(); ++c)
    sum_sq += (a[c] - b[c]) * (a[c] - b[c]);
  return std::sqrt(sum_sq);
}

/// Of a tet with so little volume for its edges rounding tells nothing.
bool is_flat(const std::array<Point, 4>& x) {
  using namespace vec;
  const Vec3 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
  return !(std::abs(dot(a, cross(b, c))) > 1e-12 * norm(a) * norm(b) * norm(c));
}

/// Largest excess of the true error over the stated one at random points, as a fraction of the range; and how many
/// points of the domain were looked at.
std::pair<double, std::size_t> worst_excess(const Built& built, int points_per_version, std::mt19937& random) {
  const RecordStream& records = built.records;
  const test::Versions all(records);
  const std::size_t fields = records.fields.size();
  double worst = -1;
  std::size_t looked_at = 0;
  for (std::size_t r = 0; r < records.size(); ++r)
    for (std::uint32_t m = 0; m < records.modified_count[r]; ++m) {
      const Tet& version = all.tets[all.coarse_begin[r].index() + m];
      if (is_ghost(version)) continue;
      const auto corners = corners_of(built, version);
      if (is_flat(corners)) continue;
      for (int i = 0; i < points_per_version; ++i) {
        const Point p = random_point_in(corners, random);
        const auto coarse = test::barycentrics(p, corners);
        if (!coarse) continue;
        for (const Tet& original : built.prepared.mesh.tets) {
          const auto around = corners_of(built, original);
          const auto fine = test::barycentrics(p, around);
          if (!fine || *std::min_element(fine->begin(), fine->end()) < 0 || is_flat(around)) continue;
          ++looked_at;
          for (std::size_t f = 0; f < fields; ++f) {
            const PointArray& array = built.prepared.mesh.point_arrays[records.fields[f].array];
            const double error = distance(interpolated(array, version, *coarse), interpolated(array, original, *fine));
            worst = std::max(worst, (error - records.field_error[r * fields + f]) / records.fields[f].range);
          }
          break;
        }
      }
    }
  return {worst, looked_at};
}

} // namespace

TEST_CASE("certified field errors hold at every point of the domain") {
  std::mt19937 random(7);
  for (const test::NamedMesh& named : test::sample_meshes(3)) {
    INFO(named.name);
    const auto [excess, looked_at] = worst_excess(build_with(named.mesh, Evaluation::kExact), 3, random);
    CHECK(looked_at > 500);
    CHECK(excess <= 1e-9);
  }
}

TEST_CASE("certified field errors hold where layers pinch out") {
  for (const unsigned seed : {1U, 2U, 24U}) {
    INFO(seed);
    std::mt19937 random(7);
    const auto [excess, looked_at] =
        worst_excess(build_with(test::pinched_layers(seed), Evaluation::kExact), 100, random);
    CHECK(looked_at > 500);
    CHECK(excess <= 1e-9);
  }
}

TEST_CASE("errors at vertices alone do not hold at every point") {
  std::mt19937 random(7);
  const auto [excess, looked_at] =
      worst_excess(build_with(test::sample_meshes(3).front().mesh, Evaluation::kVertices), 3, random);
  CHECK(looked_at > 500);
  CHECK(excess > 1e-3);
}

TEST_CASE("a linear field is certified to have no error") {
  // Where the boundary moves, vertices left outside have an error all the same: a box whose faces stay planes.
  TetMesh mesh = test::grid({{5, 5, 4}, {}, 0, 5});
  mesh.point_arrays.clear();
  test::add_array(mesh, "linear", ScalarType::kFloat64, 2, [](const Point& p) {
    return std::vector<double>{3 * p[0] - p[1] + 0.5 * p[2] + 11, p[2] - p[0]};
  });
  const Built built = build_with(mesh, Evaluation::kExact, 0);
  REQUIRE(built.records.size() > 50);
  CHECK(built.report.field_error.at(0).second == 0);
}

TEST_CASE("a limit on the field error holds at every point") {
  std::mt19937 random(7);
  const TetMesh mesh = test::sample_meshes(4).front().mesh;
  Built built{prepare(mesh), {}, {}};
  BuildOptions options;
  options.target_vertices = 0;
  options.max_field_error = {{"", {0.05, true}}};
  built.records = build::build_records(built.prepared, options, built.report, {});
  REQUIRE(built.records.size() > 10);
  const RecordStream& records = built.records;
  for (std::size_t r = 0; r < records.size(); ++r)
    for (std::size_t f = 0; f < records.fields.size(); ++f)
      CHECK(records.field_error[r * records.fields.size() + f] <= 0.05 * records.fields[f].range * (1 + 1e-8));
  CHECK(worst_excess(built, 2, random).first <= 1e-9);
}
