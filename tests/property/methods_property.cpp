// Every way to predict, evaluate and choose collapses: what each promises, on small meshes of every kind.
#include "build/builder.hpp"
#include "build/certify.hpp"
#include "formats/ptet/writer.hpp"
#include "ptet/dataset.hpp"
#include "record/ghost.hpp"
#include "support/brute_force.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/topology_checks.hpp"
#include "support/versions.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

struct Way {
  Prediction prediction;
  Evaluation evaluation;
  Objective objective = Objective::kBoth;
};

std::string describe(const Way& way) {
  return std::string(name_of(way.prediction)) + ", " + std::string(name_of(way.evaluation)) + ", " +
         std::string(name_of(way.objective));
}

constexpr std::array kPredictionsThatDoNotSimulate = {Prediction::kLocal, Prediction::kGradient, Prediction::kQuadric,
                                                      Prediction::kWeightedSum, Prediction::kPerTet};
constexpr std::array kObjectives = {Objective::kMaximum, Objective::kRootMeanSquare, Objective::kBoth};

/// All that make sense: what simulates collapses looks at errors somewhere, what measures everywhere records that.
std::vector<Way> all_ways() {
  std::vector<Way> ways;
  for (const Prediction prediction : kPredictionsThatDoNotSimulate)
    for (const Evaluation evaluation :
         {Evaluation::kNone, Evaluation::kVertices, Evaluation::kSamples, Evaluation::kExact})
      ways.push_back({prediction, evaluation});
  for (const Objective objective : kObjectives) {
    for (const Evaluation evaluation : {Evaluation::kVertices, Evaluation::kSamples, Evaluation::kExact})
      ways.push_back({Prediction::kSimulate, evaluation, objective});
    ways.push_back({Prediction::kExact, Evaluation::kExact, objective});
  }
  return ways;
}

BuildOptions options_for(const Way& way, double target = 0) {
  BuildOptions options;
  options.prediction = way.prediction;
  options.evaluation = way.evaluation;
  options.objective = way.objective;
  options.target_vertices = target;
  options.max_domain_error = {0.2, true};
  return options;
}

struct Built {
  RecordStream stream;
  BuildReport report;
};

Built built_with(PreparedMesh prepared, const BuildOptions& options) {
  Built built;
  built.stream = build::build_records(prepared, options, built.report, {});
  return built;
}

std::size_t vertices_left(const PreparedMesh& prepared, const Built& built) {
  return prepared.used_vertex_count - built.stream.size();
}

void stretch(TetMesh& mesh, const std::array<double, 3>& factors) {
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto value = static_cast<float>(mesh.positions.value(v, static_cast<std::uint32_t>(axis)) * factors[axis]);
      std::memcpy(mesh.positions.bytes.data() + (3 * v + axis) * sizeof value, &value, sizeof value);
    }
}

/// One scalar field.
void give_one_field(TetMesh& mesh) {
  mesh.point_arrays.clear();
  test::add_array(mesh, "wave", ScalarType::kFloat64, 1, [](const Point& p) {
    return std::vector<double>{std::sin(p[0] / 17 + p[2] / 40) + 0.3 * std::cos(p[1] / 11)};
  });
}

/// A smooth scalar, a vector, and one that jumps.
void give_three_fields(TetMesh& mesh) {
  give_one_field(mesh);
  test::add_array(mesh, "flow", ScalarType::kFloat32, 3, [](const Point& p) {
    return std::vector<double>{p[1] * p[2] / 100, 20 * std::sin(p[0] / 30), std::sqrt(1 + p[0] * p[0])};
  });
  test::add_array(mesh, "shock", ScalarType::kFloat64, 1,
                  [](const Point& p) { return std::vector<double>{p[0] + 0.3 * p[1] > 30 ? 7.0 + p[2] / 100 : -2.0}; });
}

/// Not convex, with a hole through it, in two components, stretched; with one field and with three.
std::vector<test::NamedMesh> meshes_to_build() {
  std::vector<test::NamedMesh> meshes;
  const auto add = [&](const std::string& name, TetMesh mesh) {
    for (const bool one_field : {true, false}) {
      meshes.push_back({name + (one_field ? ", one field" : ", three fields"), mesh});
      one_field ? give_one_field(meshes.back().mesh) : give_three_fields(meshes.back().mesh);
    }
  };
  add("l-shape", test::grid({{4, 4, 3}, [](int x, int y, int) { return x < 2 || y < 2; }, 3, 31}));
  add("frame", test::grid({{5, 5, 1}, [](int x, int y, int) { return x != 2 || y != 2; }, 2, 32}));
  add("two components", test::grid({{7, 3, 3}, [](int x, int, int) { return x != 3; }, 3, 33}));
  TetMesh layers = test::grid({{4, 4, 4}, {}, 3, 34});
  stretch(layers, {1, 0.25, 0.02});
  add("layers", std::move(layers));
  return meshes;
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same_bytes(const RecordStream& a, const RecordStream& b) {
  return a.diagonal == b.diagonal && a.volume == b.volume && same_bytes(a.slots, b.slots) &&
         same_bytes(a.removed, b.removed) && same_bytes(a.target, b.target) && same_bytes(a.round, b.round) &&
         same_bytes(a.star_begin, b.star_begin) && same_bytes(a.stars, b.stars) &&
         same_bytes(a.modified_count, b.modified_count) && same_bytes(a.field_error, b.field_error) &&
         same_bytes(a.outside_error, b.outside_error) && same_bytes(a.domain_error, b.domain_error) &&
         same_bytes(a.squared_error, b.squared_error) && same_bytes(a.uncovered_volume, b.uncovered_volume) &&
         same_bytes(a.also_needs_begin, b.also_needs_begin) && same_bytes(a.also_needs, b.also_needs);
}

bool same_collapses(const RecordStream& a, const RecordStream& b) {
  return same_bytes(a.removed, b.removed) && same_bytes(a.target, b.target) && same_bytes(a.round, b.round) &&
         same_bytes(a.slots, b.slots);
}

std::vector<char> random_cut(const RecordStream& stream, unsigned one_in, std::mt19937& random) {
  std::vector<char> is_split(stream.size(), 0);
  for (char& split : is_split)
    split = one_in != 0 && random() % one_in == 0 ? 1 : 0;
  test::close_cut(stream, is_split);
  return is_split;
}

void check_conforming(const PreparedMesh& prepared, const test::CutMesh& cut, const test::MeshFacts& original) {
  TetMesh mesh;
  mesh.positions = prepared.mesh.positions;
  mesh.tets = cut.tets;
  const test::MeshFacts facts = test::examine(mesh);
  CHECK(facts.inverted_tets == 0);
  test::check_same_topology(facts, original);
  CHECK(facts.boundary.size() == cut.ghosts.size());
}

std::array<Point, 4> corners(const PreparedMesh& prepared, const Tet& tet) {
  const auto at = [&](std::size_t i) { return prepared.points[tet[i].index()]; };
  return {at(0), at(1), at(2), at(3)};
}

double interpolated(const PointArray& field, std::uint32_t c, const Tet& tet, const std::array<double, 4>& weight) {
  double value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value += weight[i] * field.value(tet[i].index(), c);
  return value;
}

double recorded_error(const RecordStream& stream, std::size_t maker, std::size_t f) {
  return maker == test::CutMesh::kOriginal ? 0 : stream.field_error[maker * stream.fields.size() + f];
}

/// Random points of the original, on its edges and faces too: where a tet of the cut contains one, the fields differ
/// there by no more than was recorded for it.
/// Returns how many lay in a tet that a collapse made.
std::size_t check_bounds_everywhere(const PreparedMesh& prepared, const RecordStream& stream, const test::CutMesh& cut,
                                    std::size_t count, std::mt19937& random) {
  std::size_t seen = 0;
  double excess = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Tet& original = prepared.mesh.tets[random() % prepared.mesh.tets.size()];
    std::array<double, 4> fine{};
    double sum = 0;
    for (double& w : fine)
      sum += w = random() % 3 == 0 ? 0 : static_cast<double>(1 + random() % 1000);
    if (sum == 0) continue;
    Point p{};
    const auto at = corners(prepared, original);
    for (std::size_t k = 0; k < 4; ++k) {
      fine[k] /= sum;
      for (std::size_t axis = 0; axis < 3; ++axis)
        p[axis] += fine[k] * at[k][axis];
    }
    // Of the tets that share a face any may be the one that a point on it belongs to.
    std::vector<double> least(stream.fields.size(), std::numeric_limits<double>::infinity());
    bool in_made = true;
    for (std::size_t t = 0; t < cut.tets.size(); ++t) {
      const auto coarse = test::barycentrics(p, corners(prepared, cut.tets[t]));
      if (!coarse || *std::min_element(coarse->begin(), coarse->end()) < test::kTouching) continue;
      in_made &= cut.tet_maker[t] != test::CutMesh::kOriginal;
      for (std::size_t f = 0; f < stream.fields.size(); ++f) {
        const PointArray& field = prepared.mesh.point_arrays[stream.fields[f].array];
        double sum_sq = 0;
        for (std::uint32_t c = 0; c < field.components; ++c) {
          const double d = interpolated(field, c, original, fine) - interpolated(field, c, cut.tets[t], *coarse);
          sum_sq += d * d;
        }
        least[f] = std::min(least[f],
                            (std::sqrt(sum_sq) - recorded_error(stream, cut.tet_maker[t], f)) / stream.fields[f].range);
      }
    }
    if (std::isinf(least[0])) continue;
    seen += in_made ? 1 : 0;
    excess = std::max(excess, *std::max_element(least.begin(), least.end()));
  }
  CHECK(excess <= 1e-7);
  return seen;
}

/// Removed vertices that no tet of the cut contains, at the closest point of the tet that each was handed down to:
/// no error above the recorded ones there, inside and outside.
/// Returns how many there were.
std::size_t check_outside_vertices(const PreparedMesh& prepared, const RecordStream& stream,
                                   const std::vector<char>& is_split, const test::CutMesh& cut) {
  const auto holders = test::possible_holders(stream, prepared.points, is_split, cut.removed);
  const test::Versions all(stream);
  const std::vector<std::size_t> maker_of = test::makers(stream);
  std::size_t outside = 0;
  double excess = 0;
  for (std::size_t i = 0; i < cut.removed.size(); ++i) {
    const Point& p = prepared.points[cut.removed[i].index()];
    const bool inside = std::any_of(cut.tets.begin(), cut.tets.end(), [&](const Tet& tet) {
      const auto weight = test::barycentrics(p, corners(prepared, tet));
      return weight && *std::min_element(weight->begin(), weight->end()) >= test::kTouching;
    });
    if (inside) continue;
    ++outside;
    for (std::size_t f = 0; f < stream.fields.size(); ++f) {
      double least = std::numeric_limits<double>::infinity();
      for (const VersionId t : holders[i]) {
        const Tet& tet = all.tets[t.index()];
        const auto nearest = test::nearest_on_tet(p, corners(prepared, tet));
        const double error = test::interpolation_error(prepared.mesh.point_arrays[stream.fields[f].array],
                                                       cut.removed[i], tet, nearest.weight);
        const std::size_t maker = maker_of[t.index()];
        const double recorded = maker == test::CutMesh::kOriginal ? 0 : stream.largest_error(maker, f);
        least = std::min(least, (error - recorded) / stream.fields[f].range);
      }
      excess = std::max(excess, least);
    }
  }
  CHECK(excess <= 1e-7);
  return outside;
}

double largest_error(const RecordStream& stream, std::size_t f) {
  double largest = 0;
  for (std::size_t r = 0; r < stream.size(); ++r)
    largest = std::max(largest, stream.largest_error(r, f));
  return largest;
}

/// The stream with its field errors measured everywhere, whatever they were.
RecordStream measured_everywhere(const PreparedMesh& prepared, RecordStream stream) {
  const build::NormalizedFields fields(prepared, {});
  build::certify_field_errors(prepared, fields, stream, {});
  return stream;
}

} // namespace

TEST_CASE("every method: sound streams, the same on any number of threads, that stop where they should",
          "[build][methods]") {
  const auto meshes = meshes_to_build();
  const auto ways = all_ways();
  std::size_t with_target = 0;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const auto& [name, mesh] = meshes[i % meshes.size()];
    INFO(name << "; " << describe(ways[i]));
    const PreparedMesh prepared = prepare(mesh);
    for (const double target : {0.0, 0.6}) {
      BuildOptions options = options_for(ways[i], target);
      options.threads = 1;
      const Built built = built_with(prepared, options);
      const RecordStream& stream = built.stream;
      REQUIRE(stream.validate() == "");
      REQUIRE(stream.size() > prepared.used_vertex_count / 4);
      CHECK(built.report.records == stream.size());
      const auto aim = static_cast<std::size_t>(std::ceil(target * prepared.used_vertex_count));
      if (built.report.stopped_by == "target") {
        CHECK(vertices_left(prepared, built) == aim);
        ++with_target;
      } else {
        CHECK(vertices_left(prepared, built) > aim);
        CHECK_THAT(built.report.stopped_by, Catch::StartsWith("no candidate left ("));
      }
      // Squared errors stand where they are exact.
      const bool exact = ways[i].evaluation == Evaluation::kExact;
      CHECK(stream.squared_error.size() == (exact ? stream.field_error.size() : 0));
      CHECK(built.report.domain_error <= 0.2 * stream.diagonal);
      CHECK((built.report.simulations > 0) ==
            (ways[i].prediction == Prediction::kSimulate || ways[i].prediction == Prediction::kExact));
      CHECK((built.report.exact_evaluations >= stream.size()) == (ways[i].prediction == Prediction::kExact));
      for (const unsigned threads : {2U, 5U}) {
        INFO(threads << " threads");
        options.threads = threads;
        const Built other = built_with(prepared, options);
        CHECK(same_bytes(stream, other.stream));
        CHECK(built.report.collapses == other.report.collapses);
        CHECK(built.report.stopped_by == other.report.stopped_by);
        CHECK(built.report.simulations == other.report.simulations);
        CHECK(built.report.exact_evaluations == other.report.exact_evaluations);
      }
    }
  }
  CHECK(with_target > ways.size() / 2);
}

TEST_CASE("every method: conforming cuts, and no error above the recorded one where that is measured",
          "[build][methods]") {
  const auto meshes = meshes_to_build();
  const auto ways = all_ways();
  std::mt19937 random(41);
  std::size_t outside = 0;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const auto& [name, mesh] = meshes[(3 * i + 1) % meshes.size()];
    INFO(name << "; " << describe(ways[i]));
    const PreparedMesh prepared = prepare(mesh);
    const test::MeshFacts original = test::examine(prepared.mesh);
    const Built built = built_with(prepared, options_for(ways[i]));
    std::size_t seen = 0;
    for (const unsigned one_in : {0U, 40U, 12U, 4U}) {
      INFO("one split in " << one_in);
      const std::vector<char> is_split = random_cut(built.stream, one_in, random);
      const test::CutMesh cut = test::cut_mesh(built.stream, is_split);
      check_conforming(prepared, cut, original);
      if (ways[i].evaluation == Evaluation::kExact)
        seen += check_bounds_everywhere(prepared, built.stream, cut, 150, random);
      if (ways[i].evaluation != Evaluation::kNone)
        outside += check_outside_vertices(prepared, built.stream, is_split, cut);
    }
    if (ways[i].evaluation == Evaluation::kExact) CHECK(seen > 100);
  }
  CHECK(outside > 100); // else the boundary never moved
}

TEST_CASE("errors measured while collapsing are those of the finished records", "[build][methods]") {
  std::size_t more_outside = 0;
  for (const auto& [name, mesh] : meshes_to_build()) {
    INFO(name);
    const PreparedMesh prepared = prepare(mesh);
    const Built built = built_with(prepared, options_for({Prediction::kExact, Evaluation::kExact}));
    // From nothing: what is recorded is what there is where the mesh covers the domain, no more.
    RecordStream unmeasured = built.stream;
    std::fill(unmeasured.field_error.begin(), unmeasured.field_error.end(), 0.0);
    const RecordStream again = measured_everywhere(prepared, std::move(unmeasured));
    const std::size_t k = again.fields.size();
    std::vector<double> sum(k), sum_again(k);
    for (std::size_t i = 0; i < again.field_error.size(); ++i)
      more_outside += built.stream.outside_error[i] > built.stream.field_error[i] ? 1 : 0;
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < again.field_error.size(); ++i) {
      const double here = built.stream.field_error[i];
      wrong += std::abs(again.field_error[i] - here) > 1e-8 * here + 1e-12 * again.fields[i % k].range ? 1 : 0;
      sum[i % k] += built.stream.squared_error[i];
      sum_again[i % k] += again.squared_error[i];
    }
    CHECK(wrong == 0);
    for (std::size_t i = 0; i < again.squared_error.size(); ++i)
      wrong += std::abs(again.squared_error[i] - built.stream.squared_error[i]) > 1e-9 * sum_again[i % k] ? 1 : 0;
    REQUIRE(again.uncovered_volume.size() == again.size());
    for (std::size_t i = 0; i < again.size(); ++i)
      wrong += std::abs(again.uncovered_volume[i] - built.stream.uncovered_volume[i]) > 1e-9 * again.volume ? 1 : 0;
    CHECK(wrong == 0);
    for (std::size_t f = 0; f < k; ++f) {
      CHECK(sum[f] == Approx(sum_again[f]).epsilon(1e-9));
      CHECK(sum[f] > 0);
    }
  }
  CHECK(more_outside > 0); // else nothing was to be kept apart
}

TEST_CASE("errors at vertices and samples are no more than those everywhere, and samples see more",
          "[build][methods]") {
  double missed_by_vertices = 0;
  double missed_by_samples = 0;
  for (const auto& [name, mesh] : meshes_to_build()) {
    INFO(name);
    const PreparedMesh prepared = prepare(mesh);
    // The same collapses, looked at in three ways.
    const Built vertices = built_with(prepared, options_for({Prediction::kQuadric, Evaluation::kVertices}));
    const Built samples = built_with(prepared, options_for({Prediction::kQuadric, Evaluation::kSamples}));
    REQUIRE(same_collapses(vertices.stream, samples.stream));
    const RecordStream everywhere = measured_everywhere(prepared, vertices.stream);
    std::size_t above = 0;
    for (std::size_t i = 0; i < everywhere.field_error.size(); ++i) {
      const double truth = everywhere.field_error[i];
      const double range = everywhere.fields[i % everywhere.fields.size()].range;
      above += vertices.stream.field_error[i] > truth ? 1 : 0;
      // A sample outside of all tets is seen too, and the measurement knows nothing of it.
      const double by_samples = samples.stream.field_error[i];
      missed_by_vertices += (truth - vertices.stream.field_error[i]) / range;
      missed_by_samples += std::max(0.0, truth - by_samples) / range;
    }
    CHECK(above == 0);
  }
  CHECK(missed_by_vertices > 0);
  CHECK(missed_by_samples > 0);
  CHECK(missed_by_samples < 0.9 * missed_by_vertices);
}

TEST_CASE("limits hold for whatever is recorded, and stop the build", "[build][methods]") {
  TetMesh mesh = test::grid({{4, 4, 4}, [](int x, int y, int) { return x < 2 || y < 3; }, 3, 51});
  give_three_fields(mesh);
  const PreparedMesh prepared = prepare(mesh);
  for (const Way& way : all_ways()) {
    INFO(describe(way));
    BuildOptions options = options_for(way);
    options.max_field_error = {{"wave", {0.05, true}}, {"flow", {3, false}}};
    options.max_domain_error = {0.01, true};
    const Built built = built_with(prepared, options);
    const RecordStream& stream = built.stream;
    CHECK(stream.validate() == "");
    CHECK(stream.size() > 0);
    CHECK(largest_error(stream, 0) <= 0.05 * stream.fields[0].range * (1 + 1e-8));
    CHECK(largest_error(stream, 1) <= 3 * (1 + 1e-8));
    CHECK(built.report.domain_error <= 0.01 * stream.diagonal);
    CHECK_THAT(built.report.stopped_by, Catch::StartsWith("no candidate left") && Catch::Contains("field error"));
    if (way.evaluation == Evaluation::kExact) {
      const RecordStream everywhere = measured_everywhere(prepared, stream);
      CHECK(largest_error(everywhere, 0) <= 0.05 * stream.fields[0].range * (1 + 1e-8));
    }
  }
}

TEST_CASE("an objective lowers what it is named for, and matters only where collapses are simulated",
          "[build][methods]") {
  // Large enough for chance to even out.
  std::vector<TetMesh> meshes = {
      test::grid({{9, 9, 7}, [](int x, int y, int) { return x < 4 || y < 5; }, 3, 61}),
      test::grid({{12, 12, 2}, [](int x, int y, int) { return x < 4 || x > 7 || y < 4 || y > 7; }, 3, 62}),
      test::grid({{8, 8, 8}, {}, 3, 63})};
  for (TetMesh& mesh : meshes)
    give_one_field(mesh);
  // Ratios of greatest and mean square errors at equal vertex counts, all over the meshes.
  const auto logs = [&](Prediction prediction) {
    std::array<double, 2> sum{};
    for (const TetMesh& mesh : meshes) {
      const PreparedMesh prepared = prepare(mesh);
      std::array<double, 2> maximum{}, square{};
      for (const std::size_t o : {0U, 1U}) {
        BuildOptions options = options_for({prediction, Evaluation::kExact, kObjectives[o]}, 0.55);
        const Built built = built_with(prepared, options);
        CHECK(built.report.stopped_by == "target");
        maximum[o] = largest_error(built.stream, 0);
        for (const double x : built.stream.squared_error)
          square[o] += x;
      }
      sum[0] += std::log(maximum[0] / maximum[1]);
      sum[1] += std::log(square[1] / square[0]);
    }
    return sum;
  };
  const auto exact = logs(Prediction::kExact);
  CHECK(exact[0] < -1);
  CHECK(exact[1] < 0);
  const auto simulated = logs(Prediction::kSimulate);
  CHECK(simulated[0] < 0);
  CHECK(simulated[1] < 0);

  TetMesh mesh = test::grid({{4, 4, 3}, {}, 3, 3});
  const PreparedMesh prepared = prepare(std::move(mesh));
  for (const Prediction prediction : kPredictionsThatDoNotSimulate) {
    const Built one = built_with(prepared, options_for({prediction, Evaluation::kVertices, Objective::kMaximum}));
    const Built other =
        built_with(prepared, options_for({prediction, Evaluation::kVertices, Objective::kRootMeanSquare}));
    CHECK(same_bytes(one.stream, other.stream));
  }
}

TEST_CASE("a linear field on a box loses nothing, whatever the method", "[build][methods]") {
  TetMesh mesh = test::grid({{4, 4, 4}, {}, 0, 1});
  mesh.point_arrays.clear();
  test::add_array(mesh, "linear", ScalarType::kFloat64, 1,
                  [](const Point& p) { return std::vector<double>{0.3 * p[0] - 7 * p[1] + p[2] / 3 + 100}; });
  test::add_array(mesh, "vector", ScalarType::kFloat64, 2, [](const Point& p) {
    return std::vector<double>{p[0] + 0.1 * p[1], 1e-3 * p[2] - 5};
  });
  const PreparedMesh prepared = prepare(mesh);
  for (const Way& way : all_ways()) {
    if (way.evaluation == Evaluation::kNone) continue;
    INFO(describe(way));
    BuildOptions options = options_for(way);
    options.max_domain_error = {0, true};
    options.max_field_error = {{"", {0, true}}};
    const Built built = built_with(prepared, options);
    CHECK(vertices_left(prepared, built) < prepared.used_vertex_count / 4);
    CHECK(largest_error(built.stream, 0) == 0);
    CHECK(largest_error(built.stream, 1) == 0);
    CHECK(built.report.domain_error == 0);
    double worst = 0;
    for (std::size_t i = 0; i < built.stream.squared_error.size(); ++i)
      worst = std::max(worst, std::abs(built.stream.squared_error[i]) /
                                  (std::pow(built.stream.fields[i % 2].range, 2) * built.stream.volume));
    CHECK(worst < 1e-26);
  }
}

TEST_CASE("a field that does not vary has no range and no errors, whatever the method", "[build][methods]") {
  TetMesh mesh = test::grid({{4, 4, 4}, {}, 3, 1});
  mesh.point_arrays.clear();
  test::add_array(mesh, "same", ScalarType::kFloat64, 1, [](const Point&) { return std::vector<double>{0.1}; });
  test::add_array(mesh, "vector", ScalarType::kFloat32, 2, [](const Point&) { return std::vector<double>{7, -1e30}; });
  const PreparedMesh prepared = prepare(mesh);
  for (const Way& way : all_ways()) {
    INFO(describe(way));
    const Built built = built_with(prepared, options_for(way));
    CHECK(vertices_left(prepared, built) < prepared.used_vertex_count / 2);
    for (const double squared : built.stream.squared_error)
      CHECK(squared == 0);
    const auto info = Dataset::open_memory(file::encode(prepared.mesh, built.stream, {}))->info();
    for (const FieldInfo& field : info.fields)
      CHECK(field.range == 0);
    CHECK(info.max_field_error == std::vector<double>{0, 0});
  }
}

TEST_CASE("a vertex that the boundary leaves outside has the error of the closest point", "[build][methods]") {
  // One vertex in the middle of the top of a box, raised, is all that may go. Its neighbours stay.
  std::mt19937 random(61);
  std::size_t differs_inside = 0;
  for (int repeat = 0; repeat < 12; ++repeat) {
    TetMesh mesh = test::grid({{2, 2, 1}, {}, 1, 60U + static_cast<unsigned>(repeat)});
    mesh.point_arrays.clear();
    // The middle of the top: the one vertex with all of x, y in the middle and z above.
    const auto is_tip = [](const Point& p) { return std::abs(p[0] - 16) < 4 && std::abs(p[1] - 16) < 4 && p[2] > 8; };
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      if (!is_tip(mesh.position(VertexId{static_cast<std::uint32_t>(v)}))) continue;
      const auto raised = static_cast<float>(20 + random() % 12);
      std::memcpy(mesh.positions.bytes.data() + (3 * v + 2) * sizeof raised, &raised, sizeof raised);
    }
    test::add_array(mesh, "noise", ScalarType::kFloat64, 1,
                    [&](const Point&) { return std::vector<double>{static_cast<double>(random() % 100)}; });
    test::add_array(mesh, "pair", ScalarType::kFloat64, 2, [&](const Point&) {
      return std::vector<double>{static_cast<double>(random() % 100), static_cast<double>(random() % 10)};
    });
    PreparedMesh prepared = prepare(mesh);
    VertexId tip;
    for (std::uint32_t v = 0; v < prepared.used_vertex_count; ++v) {
      if (is_tip(prepared.points[v]))
        tip = VertexId{v};
      else
        prepared.frozen[v] = 1;
    }
    for (const Way& way : all_ways()) {
      if (way.evaluation == Evaluation::kNone || way.evaluation == Evaluation::kSamples) continue;
      INFO(repeat << "; " << describe(way));
      BuildOptions options = options_for(way);
      options.max_domain_error = {1, true};
      const Built built = built_with(prepared, options);
      const RecordStream& stream = built.stream;
      REQUIRE(stream.size() == 1);
      REQUIRE(stream.removed[0] == tip);
      const test::Versions all(stream);
      std::array<double, 2> at_closest{};
      double nearest = std::numeric_limits<double>::infinity();
      for (std::uint32_t m = 0; m < stream.modified_count[0]; ++m) {
        const Tet& tet = all.tets[all.coarse_begin[0].index() + m];
        if (is_ghost(tet)) continue;
        const auto on = test::nearest_on_tet(prepared.points[tip.index()], corners(prepared, tet));
        if (on.distance >= nearest) continue;
        nearest = on.distance;
        for (const std::size_t f : {0U, 1U})
          at_closest[f] = test::interpolation_error(prepared.mesh.point_arrays[f], tip, tet, on.weight);
      }
      REQUIRE(nearest > 1);
      for (const std::size_t f : {0U, 1U}) {
        if (way.evaluation == Evaluation::kVertices) {
          CHECK(stream.field_error[f] == Approx(at_closest[f]).epsilon(1e-9).margin(1e-9));
        } else {
          // The tip is not covered: what it differs by is told apart from what is measured.
          CHECK(stream.outside_error[f] == Approx(at_closest[f]).epsilon(1e-9).margin(1e-9));
          differs_inside += stream.field_error[f] > 0.01 * stream.outside_error[f] ? 1 : 0;
        }
      }
    }
  }
  CHECK(differs_inside > 0); // the collapse changes the field inside as well
}
