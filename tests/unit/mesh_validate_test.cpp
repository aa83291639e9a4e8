// What validate() says of each kind of defect, and of sound meshes; and that it says it of anything.
#include "mesh/examination.hpp"
#include "mesh/overlaps.hpp"
#include "ptet/error.hpp"
#include "ptet/validate.hpp"
#include "support/meshes.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <catch2/catch.hpp>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace {

using namespace ptet;
using test::make_mesh;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Expected {
  std::string code;
  Severity severity;
  std::uint64_t count;
  std::vector<std::uint64_t> first_ids;
};

void check_findings(const TetMesh& mesh, const std::vector<Expected>& expected) {
  const MeshReport report = validate(mesh);
  std::string all;
  for (const Finding& finding : report.findings)
    all += finding.code + ": " + finding.message + "\n";
  INFO(all);
  REQUIRE(report.findings.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Finding& finding = report.findings[i];
    CHECK(finding.code == expected[i].code);
    CHECK(finding.severity == expected[i].severity);
    CHECK(finding.count == expected[i].count);
    CHECK(finding.first_ids == expected[i].first_ids);
    CHECK_FALSE(finding.message.empty());
  }
}

const std::vector<Point> kFivePoints = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};

} // namespace

TEST_CASE("the report of a sound mesh", "[validate]") {
  TetMesh mesh = test::two_tets_sharing_a_face();
  test::add_array(mesh, "p", ScalarType::kFloat32, 1, [](const Point& p) { return std::vector<double>{p[0] - p[1]}; });
  test::add_array(mesh, "u", ScalarType::kFloat64, 2, [](const Point& p) {
    return std::vector<double>{3 * p[0], -4 * p[0]};
  });
  test::add_array(mesh, "n", ScalarType::kUInt8, 1, [](const Point& p) { return std::vector<double>{p[2] + 7}; });
  const MeshReport report = validate(mesh);
  CHECK(report.findings.empty());
  CHECK(report.first_error() == nullptr);
  CHECK(report.vertices == 5);
  CHECK(report.tets == 2);
  CHECK(report.boundary_faces == 6);
  CHECK(report.boundary_vertices == 5);
  CHECK(report.components == 1);
  CHECK(report.boundary_components == 1);
  CHECK(report.euler_characteristic == 1);
  CHECK(report.boundary_euler_characteristic == 2);
  CHECK(report.volume == Approx(1.0 / 6 + 1.0 / 3));
  CHECK(report.boundary_area == Approx(3 * 0.5 + 3 * std::sqrt(3.0) / 2));
  CHECK(report.box_min == Point{0, 0, 0});
  CHECK(report.box_max == Point{1, 1, 1});
  CHECK(report.diagonal() == Approx(std::sqrt(3.0)));
  REQUIRE(report.fields.size() == 3);
  CHECK(report.fields[0].min == -1);
  CHECK(report.fields[0].max == 1);
  CHECK(report.fields[1].min == 0);
  CHECK(report.fields[1].max == 5);
  CHECK(report.fields[2].min == 7);
  CHECK(report.fields[2].max == 8);
  CHECK(report.fields[2].name == "n");
}

TEST_CASE("a mesh without tets", "[validate]") {
  check_findings(TetMesh{}, {{"no-tets", Severity::kError, 1, {}}});
  check_findings(make_mesh({{0, 0, 0}}, {}),
                 {{"no-tets", Severity::kError, 1, {}}, {"unused-points", Severity::kNote, 1, {0}}});
  CHECK(validate(TetMesh{}).diagonal() == 0);
}

TEST_CASE("ids out of range are reported, the other tets are examined", "[validate]") {
  const TetMesh mesh = make_mesh(kFivePoints, {{0, 1, 2, 5}, {0, 1, 2, 3}, {4, 4294967295, 1, 3}});
  check_findings(mesh, {{"ids-out-of-range", Severity::kError, 2, {0, 2}}});
  CHECK(validate(mesh).boundary_faces == 4);
  CHECK(validate(mesh).first_error()->message ==
        "2 tets with vertex ids that name no vertex (0, 2): the mesh has 5 vertices, ptet cannot build from it");
}

TEST_CASE("repeated vertices in a tet", "[validate]") {
  check_findings(make_mesh(kFivePoints, {{0, 1, 2, 3}, {4, 2, 4, 3}}),
                 {{"repeated-vertices", Severity::kError, 1, {1}}});
}

TEST_CASE("duplicate tets are one finding and no crowded faces", "[validate]") {
  check_findings(make_mesh(kFivePoints, {{0, 1, 2, 3}, {4, 2, 1, 3}, {1, 2, 0, 3}}),
                 {{"duplicate-tets", Severity::kError, 1, {2}}});
  // Nor is it known whether tets overlap: these do.
  CHECK_FALSE(validate(make_mesh(kFivePoints, {{0, 1, 2, 3}, {4, 2, 1, 3}, {1, 2, 0, 3}})).overlaps_examined);
  CHECK(validate(make_mesh(kFivePoints, {{0, 1, 2, 3}, {4, 2, 1, 3}})).overlaps_examined);
}

TEST_CASE("a face of three tets is an error", "[validate]") {
  std::vector<Point> points = kFivePoints;
  points.push_back({2, 2, 2});
  const TetMesh mesh = make_mesh(points, {{0, 1, 2, 3}, {4, 2, 1, 3}, {5, 2, 1, 3}});
  check_findings(mesh, {{"faces-of-many-tets", Severity::kError, 1, {1, 2, 3}},
                        {"non-manifold-edges", Severity::kWarning, 3, {1, 2, 1, 3, 2, 3}},
                        {"non-manifold-vertices", Severity::kWarning, 3, {1, 2, 3}}});
}

TEST_CASE("both tets of a face on the same side", "[validate]") {
  std::vector<Point> points = kFivePoints;
  points[4] = {-1, -1, -1};
  check_findings(make_mesh(points, {{0, 1, 2, 3}, {4, 1, 2, 3}}), {{"folded-faces", Severity::kWarning, 1, {1, 2, 3}}});
}

TEST_CASE("one inverted tet, and all of them", "[validate]") {
  check_findings(make_mesh(kFivePoints, {{0, 1, 2, 3}, {4, 1, 2, 3}}), {{"inverted-tets", Severity::kWarning, 1, {1}}});
  check_findings(make_mesh(kFivePoints, {{0, 2, 1, 3}, {4, 1, 2, 3}}), {{"inverted-tets", Severity::kNote, 2, {0, 1}}});
}

TEST_CASE("flat and nearly flat tets", "[validate]") {
  check_findings(make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2, 3}}),
                 {{"flat-tets", Severity::kWarning, 1, {0}}});
  check_findings(make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1e-9}}, {{0, 1, 2, 3}}),
                 {{"near-flat-tets", Severity::kNote, 1, {0}}});
}

TEST_CASE("a flat tet against the order of its neighbour is no folded face", "[validate]") {
  std::vector<Point> points = kFivePoints;
  points[4] = {1, 1, -1}; // in the plane of 1, 2, 3
  for (const auto& flat : {std::array<std::uint32_t, 4>{4, 1, 2, 3}, std::array<std::uint32_t, 4>{4, 2, 1, 3}})
    check_findings(make_mesh(points, {{0, 1, 2, 3}, flat}), {{"flat-tets", Severity::kWarning, 1, {1}}});
}

TEST_CASE("non-manifold places", "[validate]") {
  check_findings(test::pinched_edge(), {{"non-manifold-edges", Severity::kWarning, 1, {0, 1}},
                                        {"non-manifold-vertices", Severity::kWarning, 2, {0, 1}}});
  check_findings(test::pinched_vertex(), {{"non-manifold-vertices", Severity::kWarning, 1, {0}}});
}

TEST_CASE("parts that overlap, and those that touch", "[validate]") {
  // A grid of cells of width 16 and the same once more, elsewhere and in another size.
  const auto with = [](const TetMesh& one, double scale, const Point& by) {
    std::vector<Point> points;
    std::vector<std::array<std::uint32_t, 4>> tets;
    for (const bool moved : {false, true}) {
      const auto first = static_cast<std::uint32_t>(points.size());
      for (std::uint32_t v = 0; v < one.vertex_count(); ++v) {
        const Point p = one.position(VertexId{v});
        points.push_back(moved ? Point{scale * p[0] + by[0], scale * p[1] + by[1], scale * p[2] + by[2]} : p);
      }
      for (const Tet& t : one.tets)
        tets.push_back({first + t[0].index(), first + t[1].index(), first + t[2].index(), first + t[3].index()});
    }
    return make_mesh(points, tets, ScalarType::kFloat64);
  };
  const auto count = [](const TetMesh& mesh, const std::string& code) {
    std::uint64_t found = 0;
    for (const Finding& finding : validate(mesh).findings)
      if (finding.code == code) found += finding.count;
    return found;
  };
  const TetMesh jittered = test::grid({{3, 3, 3}, {}, 2, 1});
  CHECK(validate(with(jittered, 1, {60, 3, 5})).findings.empty());
  const TetMesh crossing = with(jittered, 1, {20, 21, 22});
  CHECK(count(crossing, "crossing-boundary-faces") > 0);
  CHECK(count(crossing, "overlapping-tets") > 0);
  const TetMesh nested = with(jittered, 0.25, {18, 18, 18});
  CHECK(count(nested, "crossing-boundary-faces") == 0);
  const std::uint64_t at_boundary = count(nested, "overlapping-tets"); // of the inner one
  CHECK(at_boundary > 54);
  const TetMesh twice = with(jittered, 1, {0, 0, 0});
  CHECK(count(twice, "crossing-boundary-faces") == 0);
  CHECK(count(twice, "overlapping-tets") == 2 * at_boundary);
  // In line with one another no face crosses another properly, and many rays come upon edges.
  const TetMesh plain = test::grid({{3, 3, 3}, {}, 0, 1});
  CHECK(count(with(plain, 1, {24, 0, 0}), "overlapping-tets") > 0);
  const TetMesh common_wall = with(plain, 1, {48, 0, 0});
  CHECK(count(common_wall, "crossing-boundary-faces") == 0);
  CHECK(count(common_wall, "overlapping-tets") == 0);
  // A body that fills a hollow, and one that reaches over its wall by less than a tet.
  const TetMesh hollow = test::grid({{3, 3, 3}, [](int x, int y, int z) { return x != 1 || y != 1 || z != 1; }, 0, 1});
  CHECK(count(with(hollow, 15.0 / 48, {16.5, 16.5, 16.5}), "overlapping-tets") == 0);
  const TetMesh filled = with(hollow, 17.0 / 48, {15.5, 15.5, 15.5});
  CHECK(count(filled, "crossing-boundary-faces") == 0);
  CHECK(count(filled, "overlapping-tets") > 54);
  // Rays go along the shortest axis, whichever that is.
  const TetMesh flat = test::grid({{5, 4, 2}, {}, 2, 1});
  const auto turned = [&](const TetMesh& one, std::size_t by) {
    std::vector<Point> points;
    std::vector<std::array<std::uint32_t, 4>> tets;
    for (std::uint32_t v = 0; v < one.vertex_count(); ++v) {
      const Point p = one.position(VertexId{v});
      points.push_back({p[by % 3], p[(by + 1) % 3], p[(by + 2) % 3]});
    }
    for (const Tet& t : one.tets)
      tets.push_back({t[0].index(), t[1].index(), t[2].index(), t[3].index()});
    return make_mesh(points, tets, ScalarType::kFloat64);
  };
  const std::uint64_t of_flat = count(with(flat, 1, {0, 0, 0}), "overlapping-tets");
  for (const std::size_t by : {0, 1, 2}) {
    CHECK(count(with(turned(flat, by), 1, {0, 0, 0}), "overlapping-tets") == of_flat);
    CHECK(count(with(turned(flat, by), 0.25, {18, 18, 18}), "overlapping-tets") > 54);
    CHECK(validate(with(turned(flat, by), 1, {90, 3, 5})).findings.empty());
  }
}

TEST_CASE("vertices that hang on larger cells", "[validate]") {
  // A wall of one square, two faces, before a wall of four squares, of which it has the corners; both on points of
  // their own where they meet, or the same.
  const auto offset = GENERATE(0.0, 0.37, 1000.0 / 3);
  const auto type = GENERATE(ScalarType::kFloat32, ScalarType::kFloat64);
  std::vector<Point> points;
  for (const double x : {0.0, 1.0, 2.0})
    for (const double y : {0.0, 1.0, 2.0})
      points.push_back({x + offset, y / 3 + offset, 0.25 + offset});
  points.push_back({1 + offset, 1.0 / 3 + offset, 1 + offset});  // 9, above
  points.push_back({1 + offset, 1.0 / 3 + offset, -1 + offset}); // 10, below
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (const std::uint32_t corner : {0U, 1U, 3U, 4U}) {
    tets.push_back({corner, corner + 3, corner + 4, 9});
    tets.push_back({corner, corner + 4, corner + 1, 9});
  }
  tets.push_back({0, 8, 6, 10});
  tets.push_back({0, 2, 8, 10});
  const MeshReport report = validate(make_mesh(points, tets, type));
  const auto found = std::find_if(report.findings.begin(), report.findings.end(),
                                  [](const Finding& finding) { return finding.code == "hanging-vertices"; });
  REQUIRE(found != report.findings.end());
  CHECK(found->first_ids == std::vector<std::uint64_t>{1, 3, 4, 5, 7});
  // What is refined on both sides hangs nowhere, and bodies with points of their own do not, either.
  tets.resize(8);
  const std::size_t above = points.size();
  points.insert(points.end(), points.begin(), points.begin() + 9);
  for (const std::uint32_t corner : {0U, 1U, 3U, 4U}) {
    const auto own = static_cast<std::uint32_t>(above) + corner;
    tets.push_back({own, own + 4, own + 3, 10});
    tets.push_back({own, own + 1, own + 4, 10});
  }
  for (const Finding& finding : validate(make_mesh(points, tets, type)).findings)
    CHECK(std::string(finding.code) != "hanging-vertices");
}

TEST_CASE("unused and coincident points", "[validate]") {
  std::vector<Point> points = kFivePoints;
  points.push_back(points[0]);
  check_findings(make_mesh(points, {{0, 1, 2, 3}}), {{"unused-points", Severity::kNote, 2, {4, 5}}});
  points.insert(points.end(), {{-1, 0, 0}, {0, -1, 0}, {-0.0, 0, -1}});
  check_findings(make_mesh(points, {{0, 1, 2, 3}, {4, 2, 1, 3}, {5, 7, 6, 8}}),
                 {{"coincident-points", Severity::kWarning, 1, {5}}});
}

TEST_CASE("positions that are not finite, or too large to compute with", "[validate]") {
  std::vector<Point> points = kFivePoints;
  points[4] = {1, kNaN, 1};
  const TetMesh mesh = make_mesh(points, {{0, 1, 2, 3}, {4, 2, 1, 3}});
  check_findings(mesh, {{"non-finite-positions", Severity::kError, 1, {4}}});
  CHECK(validate(mesh).box_max == Point{1, 1, 1});
  points[4] = {1, -kInfinity, 1};
  check_findings(make_mesh(points, {{0, 1, 2, 3}, {4, 2, 1, 3}}), {{"non-finite-positions", Severity::kError, 1, {4}}});
  points[4] = {1, -1e51, 1};
  check_findings(make_mesh(points, {{0, 1, 2, 3}, {4, 2, 1, 3}}, ScalarType::kFloat64),
                 {{"huge-positions", Severity::kError, 1, {4}}});
}

TEST_CASE("values that are not finite, at vertices of tets", "[validate]") {
  std::vector<Point> points = kFivePoints;
  points.push_back({-2, -2, -2});
  TetMesh mesh = make_mesh(points, {{0, 1, 2, 3}, {4, 2, 1, 3}});
  test::add_array(mesh, "p", ScalarType::kFloat32, 1, [](const Point& p) {
    return std::vector<double>{p[0] == 1 ? kNaN : p[0] < 0 ? kInfinity : p[1]};
  });
  test::add_array(mesh, "u", ScalarType::kFloat64, 3, [](const Point& p) {
    return std::vector<double>{0, 0, p[2] == 1 ? -kInfinity : 1};
  });
  test::add_array(mesh, "sound", ScalarType::kInt16, 1, [](const Point&) { return std::vector<double>{1}; });
  check_findings(mesh, {{"unused-points", Severity::kNote, 1, {5}},
                        {"non-finite-values", Severity::kWarning, 2, {1, 4}},
                        {"non-finite-values", Severity::kWarning, 2, {3, 4}}});
  const MeshReport report = validate(mesh);
  CHECK(report.findings[1].message.find("'p'") != std::string::npos);
  CHECK(report.findings[2].message.find("'u'") != std::string::npos);
  CHECK(report.fields[0].min == 0);
  CHECK(report.fields[0].max == 1);
  const auto govern = [&](std::size_t f) {
    return std::pair(report.fields[f].governs_by_default, report.fields[f].can_govern);
  };
  CHECK(govern(0) == std::pair(true, false));
  CHECK(govern(1) == std::pair(true, false));
  CHECK(govern(2) == std::pair(false, true));
}

TEST_CASE("values that range over more than can be measured, at vertices of tets", "[validate]") {
  std::vector<Point> points = kFivePoints;
  points.push_back({-2, -2, -2});
  TetMesh mesh = make_mesh(points, {{0, 1, 2, 3}, {4, 2, 1, 3}});
  const auto add = [&](const char* name, double at_unused, double least, double greatest) {
    test::add_array(mesh, name, ScalarType::kFloat64, 2, [&](const Point& p) {
      return std::vector<double>{0, p[0] < 0 ? at_unused : p[0] == 1 ? greatest : least};
    });
  };
  add("wide", 0, -1e308, 1e308);
  add("unused", -1.7e308, 0, 1e308);
  mesh.point_arrays.push_back({"n", ScalarType::kInt64, 1, {}});
  mesh.point_arrays.back().resize(points.size());
  check_findings(mesh, {{"unused-points", Severity::kNote, 1, {5}}, {"too-wide-values", Severity::kWarning, 1, {}}});
  const std::int64_t far = std::int64_t{1} << 53;
  std::memcpy(mesh.point_arrays.back().bytes.data(), &far, sizeof far);
  check_findings(mesh, {{"unused-points", Severity::kNote, 1, {5}},
                        {"too-wide-values", Severity::kWarning, 1, {}},
                        {"too-wide-values", Severity::kWarning, 1, {}}});
  const MeshReport report = validate(mesh);
  CHECK(report.findings[1].message.find("'wide'") != std::string::npos);
  CHECK(report.findings[2].message.find("'n'") != std::string::npos);
  CHECK_FALSE(report.fields[0].can_govern);
  CHECK(report.fields[1].can_govern);
  CHECK_FALSE(report.fields[2].can_govern);
}

TEST_CASE("values that stand apart from all others are taken for fill values", "[validate]") {
  const TetMesh mesh = test::grid({});
  std::vector<double> values(mesh.vertex_count());
  for (std::size_t v = 0; v < values.size(); ++v)
    values[v] = 5 + static_cast<double>(v % 97) / 10;
  const auto told_of = [&] {
    TetMesh with = mesh;
    std::size_t next = 0;
    test::add_array(with, "f", ScalarType::kFloat64, 1,
                    [&](const Point&) { return std::vector<double>{values[next++]}; });
    for (const Finding& finding : validate(with).findings)
      if (finding.code == "fill-values") return finding.message;
    return std::string();
  };
  CHECK(told_of().empty());
  const double fill = GENERATE(-999.0, 9.969209968386869e36, -32768.0, 1e-300);
  values[7] = fill;
  if (std::abs(fill) > 1e6) {
    CHECK_THAT(told_of(), Catch::Contains("they range over 9.97e+36")); // one alone, but beyond all measure
  } else {
    CHECK(told_of().empty()); // a value that one vertex has may be one like others
  }
  values[20] = fill;
  if (std::abs(fill) > 1) {
    CHECK_THAT(told_of(), Catch::Contains("'f'") && Catch::Contains("2 are ") && Catch::Contains("from 5 to 14.6"));
  } else {
    CHECK(told_of().empty()); // 0 beside 5 to 14.6
  }
  for (double& value : values)
    if (value != fill) value = 1;
  CHECK(told_of().empty()); // a mask
  for (std::size_t v = 0; v < values.size(); ++v)
    values[v] = v % 5 == 0 ? 300 : 1166 + static_cast<double>(v % 47);
  CHECK(told_of().empty()); // a wall that is kept cool
}

TEST_CASE("a vector that is finite is counted so, whatever its length", "[validate]") {
  TetMesh mesh = test::two_tets_sharing_a_face();
  const std::vector<double> values(3 * mesh.vertex_count(), 1.5e308);
  PointArray array{"long", ScalarType::kFloat64, 3, std::vector<std::byte>(values.size() * sizeof(double))};
  std::memcpy(array.bytes.data(), values.data(), array.bytes.size());
  mesh.point_arrays = {array};
  CHECK(validate(mesh).fields[0].not_finite == 0);
  CHECK(validate(mesh).fields[0].can_govern);
  std::memcpy(mesh.point_arrays.back().bytes.data() + 2 * sizeof kNaN, &kNaN, sizeof kNaN);
  CHECK(validate(mesh).fields[0].not_finite == 1);
  CHECK_FALSE(validate(mesh).fields[0].can_govern);
}

TEST_CASE("arrays of the wrong size", "[validate]") {
  TetMesh mesh = test::single_tet();
  mesh.point_arrays.push_back({"short", ScalarType::kFloat32, 1, std::vector<std::byte>(15)});
  mesh.point_arrays.push_back({"empty rows", ScalarType::kFloat32, 0, {}});
  check_findings(mesh, {{"bad-array", Severity::kError, 1, {}}, {"bad-array", Severity::kError, 1, {}}});
  mesh = test::single_tet();
  mesh.positions.components = 2;
  check_findings(mesh, {{"bad-positions", Severity::kError, 1, {}}});
  mesh = test::single_tet();
  mesh.positions.bytes.pop_back();
  check_findings(mesh, {{"bad-positions", Severity::kError, 1, {}}});
}

TEST_CASE("at most eight ids are listed", "[validate]") {
  std::vector<Point> points = kFivePoints;
  points.resize(20);
  const MeshReport report = validate(make_mesh(points, {{0, 1, 2, 3}}));
  REQUIRE(report.findings.size() == 1);
  CHECK(report.findings[0].count == 16);
  CHECK(report.findings[0].first_ids == std::vector<std::uint64_t>{4, 5, 6, 7, 8, 9, 10, 11});
  CHECK(report.findings[0].message ==
        "16 vertices in no tet (4, 5, 6, 7, 8, 9, 10, 11, ...): kept with the original mesh");
}

TEST_CASE("every defect of a mesh is reported at once", "[validate]") {
  std::vector<Point> points = kFivePoints;
  points.insert(points.end(), {{kNaN, 0, 0}, {5, 5, 5}, {0, 0, 0}});
  const TetMesh mesh =
      make_mesh(points, {{0, 2, 1, 3}, {4, 2, 1, 3}, {4, 1, 2, 3}, {0, 0, 1, 2}, {0, 1, 5, 2}, {9, 0, 1, 2}});
  check_findings(mesh, {{"non-finite-positions", Severity::kError, 1, {5}},
                        {"ids-out-of-range", Severity::kError, 1, {5}},
                        {"repeated-vertices", Severity::kError, 1, {3}},
                        {"inverted-tets", Severity::kWarning, 2, {0, 2}},
                        {"duplicate-tets", Severity::kError, 1, {2}},
                        {"unused-points", Severity::kNote, 2, {6, 7}}});
}

TEST_CASE("validate survives any tets over few vertices", "[validate]") {
  std::mt19937 random(7);
  for (int i = 0; i < 500; ++i) {
    const unsigned vertex_count = 4 + random() % 6, tet_count = random() % 20;
    std::vector<Point> points(vertex_count);
    for (Point& p : points)
      for (double& x : p)
        x = random() % 40 == 0 ? kNaN : static_cast<double>(random() % 3);
    std::vector<std::array<std::uint32_t, 4>> tets(tet_count);
    for (auto& tet : tets)
      for (std::uint32_t& v : tet)
        v = random() % 60 == 0 ? static_cast<std::uint32_t>(random()) : random() % vertex_count;
    const MeshReport report = validate(make_mesh(points, tets));
    CHECK(report.tets == tet_count);
    CHECK(std::isfinite(report.volume));
  }
}

TEST_CASE("validate can be cancelled at each stage", "[validate]") {
  // Five stages, and two more looks while overlaps are searched for.
  for (int stop = 0; stop < 7; ++stop) {
    int calls = 0;
    try {
      (void)validate(test::single_tet(), [&](const Progress&) { return calls++ != stop; });
      FAIL("not cancelled");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kCancelled);
      CHECK(calls == stop + 1);
    }
  }
}

TEST_CASE("what is found is the same on any number of threads", "[validate]") {
  // Cells left out at random pinch the domain all over; a second such body reaches into the first.
  const auto porous = [](unsigned seed) {
    return test::grid({{18, 18, 18},
                       [=](int x, int y, int z) { return (x * 7 + y * 5 + z * 3 + x * y * z) % 6 != int(seed); },
                       2,
                       seed});
  };
  std::vector<Point> points;
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (const unsigned seed : {1U, 2U}) {
    const TetMesh one = porous(seed);
    const auto first = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t v = 0; v < one.vertex_count(); ++v) {
      const Point p = one.position(VertexId{v});
      points.push_back(seed == 1 ? p : Point{p[0] + 37, p[1] + 21, p[2] + 5});
    }
    for (const Tet& t : one.tets)
      tets.push_back({first + t[0].index(), first + t[1].index(), first + t[2].index(), first + t[3].index()});
  }
  const bool crowded = GENERATE(false, true);
  if (crowded) // a third tet on many faces, some tets twice
    for (std::size_t t = 0, count = tets.size(); t < count; t += 50) {
      tets.push_back({tets[t][0], tets[t][1], tets[t][2], tets[(t + 5000) % count][3]});
      if (t % 100 == 0) tets.push_back({tets[t][1], tets[t][0], tets[t][2], tets[t][3]});
    }
  const TetMesh mesh = make_mesh(points, tets, ScalarType::kFloat64);
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 5);
  const auto examine_on = [&](int threads) { return tbb::task_arena(threads).execute([&] { return examine(mesh); }); };
  const Examination alone = examine_on(1);
  const auto overlaps_on = [&](int threads) {
    if (crowded) return Overlaps{}; // they are not looked for
    return tbb::task_arena(threads).execute(
        [&] { return find_overlaps(alone.points, alone.tets, alone.boundary, 0, [] {}); });
  };
  const Overlaps overlaps = overlaps_on(1);
  CHECK(alone.findings.size() >= 3);
  if (crowded) {
    CHECK(alone.faces.crowded.size() > 500);
  } else {
    CHECK(alone.links.non_manifold.size() > 500);
    CHECK(overlaps.crossing.size() > 500);
    CHECK(overlaps.within.size() > 500);
  }
  for (const int threads : {2, 5}) {
    INFO(threads << " threads");
    const Examination many = examine_on(threads);
    CHECK((many.tets == alone.tets));
    CHECK((many.faces.mate == alone.faces.mate));
    CHECK((many.faces.crowded == alone.faces.crowded));
    CHECK((many.faces.duplicates == alone.faces.duplicates));
    CHECK(many.faces.face_count == alone.faces.face_count);
    CHECK((many.boundary.half_faces == alone.boundary.half_faces));
    CHECK((many.links.non_manifold == alone.links.non_manifold));
    CHECK((many.links.used == alone.links.used));
    CHECK(many.links.used_count == alone.links.used_count);
    CHECK(many.links.edge_count == alone.links.edge_count);
    CHECK((many.folded == alone.folded));
    CHECK((overlaps_on(threads).crossing == overlaps.crossing));
    CHECK((overlaps_on(threads).within == overlaps.within));
    REQUIRE(many.findings.size() == alone.findings.size());
    for (std::size_t i = 0; i < many.findings.size(); ++i) {
      CHECK(many.findings[i].code == alone.findings[i].code);
      CHECK(many.findings[i].count == alone.findings[i].count);
      CHECK(many.findings[i].first_ids == alone.findings[i].first_ids);
      CHECK(many.findings[i].message == alone.findings[i].message);
    }
  }
}

TEST_CASE("a mesh too small to compute with, and one without any extent") {
  for (const double scale : {1e-60, 0.0}) {
    const TetMesh mesh =
        test::make_mesh({{0, 0, 0}, {scale, 0, 0}, {0, scale, 0}, {0, 0, scale}}, {{0, 1, 2, 3}}, ScalarType::kFloat64);
    const MeshReport report = validate(mesh);
    REQUIRE(report.first_error() != nullptr);
    CHECK(report.first_error()->code == "tiny-extent");
    CHECK((report.first_error()->message.find("in one point") != std::string::npos) == (scale == 0));
  }
}

TEST_CASE("a mesh whose volumes would be lost, and one that only has a point far away") {
  using Points = std::vector<Point>;
  const auto first_error = [](const Points& points) {
    const MeshReport report = validate(test::make_mesh(points, {{0, 1, 2, 3}}, ScalarType::kFloat64));
    return report.first_error() == nullptr ? std::string("none") : report.first_error()->code;
  };
  CHECK(first_error({{0, 0, 0}, {1, 0, 0}, {0, 1e-155, 0}, {0, 0, 1e-155}}) == "tiny-extent");
  CHECK(first_error({{0, 0, 0}, {1, 0, 0}, {0, 1e-100, 0}, {0, 0, 1e-100}}) == "none");
  CHECK(first_error({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}) == "none"); // flat: no volume to lose
  // The last point is in no tet.
  CHECK(first_error({{0, 0, 0}, {1e-110, 0, 0}, {0, 1e-110, 0}, {0, 0, 1e-110}, {1, 1, 1}}) == "tiny-extent");
}
