// What the builder promises, on sample meshes and random grids: sound meshes at every step and in every cut, targets
// and limits that are kept. Its errors: build_errors_property.cpp; the same records: same_records_property.cpp.
#include "mesh/predicates.hpp"
#include "ptet/error.hpp"
#include "support/built.hpp"
#include "support/topology_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <set>

#include <catch2/catch.hpp>

using namespace ptet;
using test::Built, test::build_all, test::check_sound, test::mesh_after, test::meshes_to_build, test::to_the_end,
    test::vertices_left;

namespace {

void check_boundary_does_not_meet_itself(const Built& built, const test::CutMesh& cut) {
  const std::vector<Face> faces = test::faces_of(cut.ghosts);
  std::size_t meetings = 0;
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (std::size_t j = i + 1; j < faces.size(); ++j)
      meetings += faces_meet_improperly(faces[i], faces[j], built.prepared.points) ? 1 : 0;
  CHECK(meetings == 0);
}

void check_report(const Built& built) {
  const test::CutMesh base = mesh_after(built, built.stream.size());
  std::set<VertexId> used;
  for (const Tet& tet : base.tets)
    used.insert(tet.begin(), tet.end());
  CHECK(built.report.records == built.stream.size());
  CHECK(built.report.collapses[static_cast<std::size_t>(CollapseStatus::kAccepted)] == built.stream.size());
  CHECK(built.report.base_tets == base.tets.size());
  CHECK(built.report.base_vertices ==
        used.size() + built.prepared.mesh.vertex_count() - built.prepared.used_vertex_count);
  REQUIRE(built.report.field_error.size() == built.stream.fields.size());
  for (std::size_t f = 0; f < built.stream.fields.size(); ++f) {
    CHECK(built.report.field_error[f].first == test::field_array(built, f).name);
    double largest = 0;
    for (std::size_t i = 0; i < built.stream.size(); ++i)
      largest = std::max(largest, built.stream.largest_error(i, f));
    CHECK(built.report.field_error[f].second == largest);
  }
}

} // namespace

TEST_CASE("builds are valid streams, sound meshes at every step and in every cut", "[build]") {
  for (const auto& [name, mesh] : meshes_to_build()) {
    INFO(name);
    const Built built = build_all(mesh, to_the_end());
    REQUIRE(built.stream.validate() == "");
    REQUIRE(built.stream.size() > built.prepared.used_vertex_count / 3);
    test::check_rounds(built.stream);
    check_report(built);
    const test::MeshFacts original = test::examine(built.prepared.mesh);
    REQUIRE(original.inverted_tets == 0);
    for (std::size_t count = 0; count <= built.stream.size(); count += count + 7 < built.stream.size() ? 7 : 1) {
      INFO("after " << count << " collapses");
      check_sound(built, mesh_after(built, count), original);
    }
    std::mt19937 random(3);
    for (int repeat = 0; repeat < 5; ++repeat) {
      std::vector<char> is_split(built.stream.size(), 0);
      for (char& split : is_split)
        split = random() % 40 == 0 ? 1 : 0;
      test::close_cut(built.stream, is_split);
      check_sound(built, test::cut_mesh(built.stream, is_split), original);
    }
  }
}

TEST_CASE("the boundary never meets itself", "[build]") {
  for (const auto& [name, mesh] : meshes_to_build()) {
    INFO(name);
    const Built built = build_all(mesh, to_the_end());
    for (const double part : {0.0, 0.5, 0.75, 0.9, 1.0}) {
      INFO("part of the collapses " << part);
      const auto count = static_cast<std::size_t>(part * static_cast<double>(built.stream.size()));
      check_boundary_does_not_meet_itself(built, mesh_after(built, count));
    }
  }
}

TEST_CASE("limits on field and domain errors are kept, and are what stops the build", "[build]") {
  const TetMesh mesh = test::grid({{6, 6, 6}, [](int x, int y, int) { return x < 3 || y < 3; }, 3, 4});
  BuildOptions options = to_the_end();
  options.max_field_error = {{"pressure", {0.02, true}}, {"flow", {3, false}}};
  options.max_domain_error = {0.005, true};
  const Built built = build_all(mesh, options);
  REQUIRE(built.stream.size() > 10);
  REQUIRE(built.report.field_error.size() == 2);
  const double pressure_range = built.stream.fields[0].range;
  CHECK(built.report.field_error[0].second <= 0.02 * pressure_range * (1 + 1e-6));
  CHECK(built.report.field_error[0].second > 0.01 * pressure_range);
  CHECK(built.report.field_error[1].second <= 3 * (1 + 1e-6));
  CHECK(built.report.domain_error <= 0.005 * built.stream.diagonal * (1 + 1e-6));
  CHECK(built.report.domain_error > 0);
  CHECK(built.report.collapses[static_cast<std::size_t>(CollapseStatus::kFieldError)] > 0);
  CHECK(built.report.collapses[static_cast<std::size_t>(CollapseStatus::kDomainError)] > 0);
  CHECK_THAT(built.report.stopped_by, Catch::StartsWith("no candidate left") && Catch::Contains("domain error") &&
                                          Catch::Contains("field error"));

  // A limit of nothing at all still lets go what loses nothing.
  TetMesh linear = test::grid({{5, 5, 5}, {}, 0, 1});
  linear.point_arrays.clear();
  test::add_array(linear, "linear", ScalarType::kFloat64, 1,
                  [](const Point& p) { return std::vector<double>{2 * p[0] - p[1] + 3 * p[2]}; });
  options.max_field_error = {{"", {0, false}}};
  options.max_domain_error = {0, false};
  const Built lossless = build_all(linear, options);
  CHECK(vertices_left(lossless) < 40);
  CHECK(lossless.report.field_error.at(0).second == 0);
  CHECK(lossless.report.domain_error == 0);
}

TEST_CASE("frozen vertices stay, pinched places with them", "[build]") {
  const std::vector<test::NamedMesh> pinched = {
      {"along an edge", test::grid({{6, 6, 3}, [](int x, int y, int) { return (x < 3) == (y < 3); }, 2, 6})},
      {"at a vertex",
       test::grid({{6, 6, 6}, [](int x, int y, int z) { return (x < 3) == (y < 3) && (x < 3) == (z < 3); }, 2, 7})}};
  for (const auto& [name, mesh] : pinched) {
    INFO(name);
    const Built built = build_all(mesh, to_the_end());
    REQUIRE(std::count(built.prepared.frozen.begin(), built.prepared.frozen.end(), 1) >= 1);
    REQUIRE(built.stream.validate() == "");
    CHECK(vertices_left(built) < built.prepared.used_vertex_count / 2);
    for (const VertexId v : built.stream.removed)
      CHECK(built.prepared.frozen[v.index()] == 0);
    const test::MeshFacts original = test::examine(built.prepared.mesh);
    for (std::size_t count = 0; count <= built.stream.size(); count += 20)
      check_sound(built, mesh_after(built, count), original);
    check_sound(built, mesh_after(built, built.stream.size()), original);
  }
}

TEST_CASE("meshes with nothing to collapse give no records", "[build]") {
  for (const TetMesh& mesh : {test::single_tet(), test::pinched_vertex(), test::pinched_edge()}) {
    const Built built = build_all(mesh, to_the_end());
    CHECK(built.stream.validate() == "");
    CHECK(built.stream.size() == 0);
    CHECK_THAT(built.report.stopped_by, Catch::StartsWith("no candidate left"));
    CHECK(built.report.base_tets == mesh.tets.size());
    CHECK(built.report.base_vertices == mesh.vertex_count());
  }
}

TEST_CASE("the target is met exactly, as a number and as a part", "[build]") {
  const TetMesh mesh = test::grid({{6, 6, 6}, {}, 2, 2});
  REQUIRE(mesh.vertex_count() == 343);
  BuildOptions options = to_the_end();
  const auto left_with_target = [&](double target) {
    options.target_vertices = target;
    const Built built = build_all(mesh, options);
    CHECK(built.report.stopped_by == "target");
    return vertices_left(built);
  };
  CHECK(left_with_target(100) == 100);
  CHECK(left_with_target(0.5) == 172);
  CHECK(left_with_target(343) == 343);
  CHECK(left_with_target(1000) == 343);
  CHECK(left_with_target(0x1p32) == 343);
  CHECK(left_with_target(1e300) == 343);
}

/// With every position mapped, and test fields there.
TetMesh mapped_with_fields(const TetMesh& mesh, const std::function<Point(const Point&)>& map) {
  TetMesh result = test::mapped(mesh, map);
  test::add_test_fields(result);
  return result;
}

/// Cells of six tets, 16 wide; layer k of them has its lower side at `height(k)`.
TetMesh layers(int width, int count, const std::function<double(int)>& height) {
  return mapped_with_fields(test::grid({{width, width, count}, {}, 0, 1}), [&](const Point& p) {
    return Point{p[0], p[1], height(static_cast<int>(p[2] / 16))};
  });
}

// What is flat already is what has to get flatter, however round the rest is.
TEST_CASE("layers along a wall get coarser, too", "[build]") {
  constexpr double kThin = 0.02; // of a layer; two of eight are so thin
  const TetMesh mesh = layers(12, 8, [](int k) { return k < 2 ? kThin * k : 2 * kThin + 16 * (k - 2); });
  BuildOptions options;
  options.target_vertices = 0.1;
  const Built built = build_all(mesh, options);
  CHECK(built.report.min_quality == Approx(0.05 * 0.5 * kThin / 16).epsilon(0.01));
  options.min_quality = 1e-3;
  const Built kept = build_all(mesh, options);
  CHECK(kept.report.min_quality == 1e-3);
  const auto refused = [](const Built& b) {
    return b.report.collapses[static_cast<std::size_t>(CollapseStatus::kQuality)];
  };
  CHECK(refused(kept) > 100);
  CHECK(refused(built) < refused(kept) / 10);
}

TEST_CASE("the floor of shapes does not go by what is flat by chance", "[build]") {
  BuildOptions options;
  options.target_vertices = 0.95;
  const auto floor_of = [&](int count) { // two layers have no thickness to speak of
    const TetMesh mesh = layers(4, count, [](int k) { return k < 2 ? 1e-9 * k : 2e-9 + 16 * (k - 2); });
    return build_all(mesh, options).report.min_quality;
  };
  const double even = std::sqrt(2.0) / std::pow(3, 1.5); // 6 sqrt(2) V / Lmax^3 of a sixth of a cube
  CHECK(floor_of(8) == Approx(0.05 * 1e-3 * even).epsilon(0.001));
  CHECK(floor_of(50) == 1e-3);
}

TEST_CASE("no floor for shapes is none for flat tets either", "[build]") {
  // Turned: what rounding makes of the volume of flat tets is not 0.
  const TetMesh mesh =
      mapped_with_fields(layers(8, 8, [](int k) { return 16 * (k < 4 ? k : k - 1); }), [](const Point& p) {
        const double c = std::cos(0.7), s = std::sin(0.7), y = s * p[0] + c * p[1];
        return Point{c * p[0] - s * p[1], c * y - s * p[2], s * y + c * p[2]};
      });
  BuildOptions options;
  options.prediction = Prediction::kQuadric;
  options.evaluation = Evaluation::kNone;
  options.min_quality = 0;
  const Built built = build_all(mesh, options);
  CHECK(built.report.records > 400);
  CHECK(built.report.collapses[static_cast<std::size_t>(CollapseStatus::kQuality)] == 0);
}

// A coarser plate has flatter tets: a floor for their shape is one of the plate's own tets.
TEST_CASE("plates get coarser however thin they are", "[build]") {
  for (const double thickness : {16.0, 16e-3, 16e-6}) {
    INFO("thickness " << thickness);
    const TetMesh mesh = layers(16, 1, [=](int k) { return k * thickness; });
    BuildOptions options;
    options.target_vertices = 0.05;
    const Built built = build_all(mesh, options);
    CHECK(built.report.stopped_by == "target");
    CHECK(built.report.min_quality == Approx(std::min(1e-3, 0.05 * 0.5 * thickness / 16)).epsilon(0.01));
    // Where a sheet folds over by less than its thickness, the flap is held by a face that it does not lie over, and
    // what another one covers by a hair's breadth is stated as the width of the flap.
    CHECK(built.report.domain_error < (thickness < 1e-3 ? 0.01 : 0.003) * built.stream.diagonal);
    if (thickness == 16) continue;
    options.min_quality = 1e-3;
    CHECK(build_all(mesh, options).report.stopped_by != "target");
    CHECK(build_all(mesh, options).report.min_quality == 1e-3);
  }
}

TEST_CASE("budgets weigh errors as the format's words have it", "[build]") {
  const TetMesh mesh = test::grid({});
  BuildOptions options;
  options.target_vertices = 0.5;
  const auto weights_of = [&](const BuildOptions& of) { return build_all(mesh, of).stream; };
  const RecordStream plain = weights_of(options);
  REQUIRE(plain.fields.size() > 0);
  REQUIRE(plain.budget.maximum.size() == plain.fields.size());
  // Of two fifths of the diagonal, or of the range, what counts as one.
  CHECK(0.4 * plain.diagonal * plain.budget.domain == Approx(1));
  for (std::size_t f = 0; f < plain.fields.size(); ++f)
    CHECK(plain.fields[f].range * plain.budget.maximum[f] == Approx(1));
  CHECK(plain.budget.mean);

  options.max_field_error = {{"", {0.25, true}}};
  options.max_domain_error = {0.125, true};
  const RecordStream limited = weights_of(options);
  CHECK(4 * 0.125 * limited.diagonal * limited.budget.domain == Approx(1).epsilon(0.01));
  for (std::size_t f = 0; f < limited.fields.size(); ++f)
    CHECK(0.25 * limited.fields[f].range * limited.budget.maximum[f] == Approx(1).epsilon(0.01));

  options.objective = Objective::kMaximum;
  CHECK_FALSE(weights_of(options).budget.mean);
  CHECK_FALSE(weights_of(options).budget.maximum.empty());
  options.objective = Objective::kRootMeanSquare;
  CHECK(weights_of(options).budget.mean);
  CHECK(weights_of(options).budget.maximum.empty());
  options.objective = Objective::kBoth;
  options.evaluation = Evaluation::kVertices;
  options.prediction = Prediction::kQuadric;
  CHECK_FALSE(weights_of(options).budget.mean);
  CHECK(weights_of(options).budget.maximum.empty());
}

TEST_CASE("progress only grows, and cancelling throws", "[build]") {
  PreparedMesh prepared = prepare(test::grid({{5, 5, 5}, {}, 2, 2}));
  BuildReport report;
  std::uint64_t last = 0;
  std::uint64_t collapsed = 0;
  std::string stage;
  int calls = 0;
  const RecordStream stream = build::build_records(prepared, to_the_end(), report, [&](const Progress& progress) {
    if (progress.stage != stage) last = 0;
    stage = progress.stage;
    if (stage == "collapsing") collapsed = progress.done;
    CHECK(progress.done >= last);
    CHECK(progress.done <= progress.total);
    last = progress.done;
    ++calls;
    return true;
  });
  CHECK(calls > 2);
  CHECK(collapsed == stream.size());
  calls = 0;
  try {
    static_cast<void>(
        build::build_records(prepared, to_the_end(), report, [&](const Progress&) { return ++calls < 2; }));
    FAIL("nothing was thrown");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kCancelled);
  }
  CHECK(calls == 2);
}

TEST_CASE("options out of range are refused by name", "[build]") {
  PreparedMesh prepared = prepare(test::grid({{2, 2, 2}, {}, 2, 2}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const std::function<void(BuildOptions&)>& spoil) {
    BuildOptions options;
    spoil(options);
    BuildReport report;
    try {
      static_cast<void>(build::build_records(prepared, options, report, {}));
    } catch (const Error& error) {
      return error.code() == ErrorCode::kBadArgument && std::strlen(error.what()) > 10;
    }
    return false;
  };
  CHECK_FALSE(refused([](BuildOptions&) {}));
  for (const double bad : {-1.0, nan}) {
    CHECK(refused([&](BuildOptions& o) { o.target_vertices = bad; }));
    CHECK(refused([&](BuildOptions& o) { o.min_quality = bad; }));
    CHECK(refused([&](BuildOptions& o) { o.round_fraction = bad; }));
    CHECK(refused([&](BuildOptions& o) { o.max_domain_error.value = bad; }));
    CHECK(refused([&](BuildOptions& o) { o.max_field_error = {{"pressure", {bad, true}}}; }));
  }
  CHECK(refused([](BuildOptions& o) { o.target_vertices = std::numeric_limits<double>::infinity(); }));
  CHECK(refused([](BuildOptions& o) { o.min_quality = 1; }));
  CHECK(refused([](BuildOptions& o) { o.round_fraction = 0; }));
  CHECK(refused([](BuildOptions& o) { o.round_fraction = 1.01; }));
  CHECK(refused([](BuildOptions& o) { o.max_star = 7; }));
  CHECK(refused([](BuildOptions& o) { o.max_star = 4097; }));
  CHECK(refused([](BuildOptions& o) { o.fields = {"presure"}; }));
  CHECK(refused([](BuildOptions& o) { o.max_field_error = {{"marker", {1, false}}}; })); // carried, not governing
}
