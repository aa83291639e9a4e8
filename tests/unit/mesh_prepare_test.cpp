// What a build starts from: nothing lost, tets oriented, vertices frozen where the mesh is no manifold.
#include "mesh/prepare.hpp"
#include "ptet/error.hpp"
#include "ptet/validate.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include <catch2/catch.hpp>

namespace {

using namespace ptet;
using test::make_mesh;

std::vector<Tet> oriented_tets(std::vector<Tet> tets) {
  for (Tet& tet : tets)
    tet = test::sorted_keeping_orientation(tet);
  std::sort(tets.begin(), tets.end());
  return tets;
}

/// The prepared tets in the ids of the given mesh.
std::vector<Tet> original_tets(const PreparedMesh& prepared) {
  std::vector<Tet> tets = prepared.mesh.tets;
  for (Tet& tet : tets)
    for (VertexId& v : tet)
      v = prepared.original_vertex[v.index()];
  return oriented_tets(tets);
}

std::vector<std::uint32_t> frozen_originals(const PreparedMesh& prepared) {
  std::vector<std::uint32_t> frozen;
  for (std::size_t v = 0; v < prepared.frozen.size(); ++v)
    if (prepared.frozen[v]) frozen.push_back(prepared.original_vertex[v].index());
  std::sort(frozen.begin(), frozen.end());
  return frozen;
}

void check_rows(const PointArray& given, const PointArray& prepared, const std::vector<VertexId>& original_vertex) {
  REQUIRE(given.bytes.size() == prepared.bytes.size());
  const std::size_t n = given.row_bytes();
  for (std::size_t v = 0; v < original_vertex.size(); ++v)
    REQUIRE(std::equal(prepared.bytes.data() + v * n, prepared.bytes.data() + (v + 1) * n,
                       given.bytes.data() + original_vertex[v].index() * n));
}

void check_prepared(const TetMesh& given, const PreparedMesh& prepared) {
  REQUIRE(prepared.original_vertex.size() == given.vertex_count());
  std::vector<VertexId> ids = prepared.original_vertex;
  std::sort(ids.begin(), ids.end());
  for (std::uint32_t v = 0; v < ids.size(); ++v)
    REQUIRE(ids[v] == VertexId{v});
  check_rows(given.positions, prepared.mesh.positions, prepared.original_vertex);
  REQUIRE(given.point_arrays.size() == prepared.mesh.point_arrays.size());
  for (std::size_t i = 0; i < given.point_arrays.size(); ++i)
    check_rows(given.point_arrays[i], prepared.mesh.point_arrays[i], prepared.original_vertex);

  REQUIRE(prepared.points.size() == given.vertex_count());
  REQUIRE(prepared.frozen.size() == given.vertex_count());
  std::vector<char> used(given.vertex_count());
  std::uint32_t last_smallest = 0;
  for (const Tet& tet : prepared.mesh.tets) {
    for (const VertexId v : tet)
      used.at(v.index()) = 1;
    const auto at = [&](std::size_t i) { return prepared.points[tet[i].index()]; };
    REQUIRE(at(0) == prepared.mesh.position(tet[0]));
    REQUIRE(orientation(at(0), at(1), at(2), at(3)) >= 0);
    const std::uint32_t smallest = std::min_element(tet.begin(), tet.end())->index();
    REQUIRE(smallest >= last_smallest);
    last_smallest = smallest;
  }
  CHECK(std::is_sorted(used.rbegin(), used.rend()));
  CHECK(prepared.used_vertex_count == static_cast<std::size_t>(std::count(used.begin(), used.end(), 1)));

  std::vector<Face> boundary;
  for (const Face& face : prepared.boundary_faces)
    boundary.push_back(test::turned(face));
  std::sort(boundary.begin(), boundary.end());
  CHECK(boundary == test::examine(prepared.mesh).boundary);
}

const std::vector<Point> kFivePoints = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};

} // namespace

TEST_CASE("prepare renumbers and loses nothing", "[prepare]") {
  std::mt19937 random(4);
  for (test::NamedMesh& sample : test::sample_meshes(3)) {
    INFO(sample.name);
    std::shuffle(sample.mesh.tets.begin(), sample.mesh.tets.end(), random);
    const PreparedMesh prepared = prepare(sample.mesh);
    check_prepared(sample.mesh, prepared);
    CHECK(original_tets(prepared) == oriented_tets(sample.mesh.tets));
    CHECK(frozen_originals(prepared).empty());
    CHECK(prepared.notes.empty());
    CHECK(prepared.used_vertex_count == sample.mesh.vertex_count());
  }
}

TEST_CASE("prepare puts near vertices near one another, whatever their order was", "[prepare]") {
  const TetMesh grid = test::grid({{16, 16, 16}, {}, 2, 1});
  std::vector<std::uint32_t> ids(grid.vertex_count());
  std::iota(ids.begin(), ids.end(), 0U);
  std::shuffle(ids.begin(), ids.end(), std::mt19937(1));
  std::vector<Point> points(ids.size());
  for (std::uint32_t v = 0; v < ids.size(); ++v)
    points[ids[v]] = grid.position(VertexId{v});
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (const Tet& tet : grid.tets)
    tets.push_back({ids[tet[0].index()], ids[tet[1].index()], ids[tet[2].index()], ids[tet[3].index()]});
  const PreparedMesh prepared = prepare(make_mesh(points, tets));
  double spread = 0;
  for (const Tet& tet : prepared.mesh.tets) {
    const auto [least, greatest] = std::minmax_element(tet.begin(), tet.end());
    spread += greatest->index() - least->index();
  }
  // Of ids at random, four spread over three fifths.
  CHECK(spread / static_cast<double>(prepared.mesh.tets.size()) < 0.15 * static_cast<double>(ids.size()));
}

TEST_CASE("prepare gives the same result for the same mesh", "[prepare]") {
  const TetMesh mesh = test::grid({{4, 3, 2}, {}, 2, 9});
  const PreparedMesh a = prepare(mesh), b = prepare(mesh);
  CHECK(a.mesh.tets == b.mesh.tets);
  CHECK(a.original_vertex == b.original_vertex);
  CHECK(a.boundary_faces == b.boundary_faces);
}

TEST_CASE("prepare takes an origin near the mesh off its points, exactly", "[prepare]") {
  const auto moved = [](const Point& by) {
    std::vector<Point> points = kFivePoints;
    for (Point& p : points)
      p = {p[0] / 3 + by[0], p[1] / 3 + by[1], p[2] / 3 + by[2]};
    return make_mesh(points, {{0, 2, 1, 3}, {4, 2, 1, 3}}, ScalarType::kFloat64);
  };
  const auto check = [&](const Point& by, const Point& origin) {
    const PreparedMesh prepared = prepare(moved(by));
    for (std::uint32_t v = 0; v < prepared.points.size(); ++v)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        CHECK(prepared.points[v][axis] + origin[axis] == prepared.mesh.position(VertexId{v})[axis]);
        if (origin[axis] != 0) CHECK(std::abs(prepared.points[v][axis]) <= 0.34);
      }
  };
  check({0, 0, 0}, {0, 0, 0});
  check({2, -3, -0.1}, {0, 0, 0});
  check({1e9, 2, 0}, {1e9, 0, 0});
  check({5e6, -1e9, 6}, {5e6, -1e9 + 1.0 / 3, 6});
}

TEST_CASE("prepare orients inverted tets and says so", "[prepare]") {
  const TetMesh mesh = make_mesh(kFivePoints, {{0, 2, 1, 3}, {4, 2, 1, 3}});
  const PreparedMesh prepared = prepare(mesh);
  check_prepared(mesh, prepared);
  CHECK(original_tets(prepared) == oriented_tets(test::two_tets_sharing_a_face().tets));
  CHECK(prepared.notes == std::vector<std::string>{"1 inverted tet (0): two vertices of each are swapped"});
  CHECK(frozen_originals(prepared).empty());
}

TEST_CASE("prepare keeps flat tets, ordered like their neighbours", "[prepare]") {
  std::vector<Point> points = kFivePoints;
  points[4] = {1, 1, -1};
  const TetMesh agreeing = make_mesh(points, {{0, 1, 2, 3}, {4, 2, 1, 3}});
  const TetMesh opposing = make_mesh(points, {{0, 1, 2, 3}, {4, 1, 2, 3}});
  for (const TetMesh* mesh : {&agreeing, &opposing}) {
    const PreparedMesh prepared = prepare(*mesh);
    check_prepared(*mesh, prepared);
    CHECK(original_tets(prepared) == oriented_tets(agreeing.tets));
    CHECK(prepared.notes == std::vector<std::string>{"1 flat tet (1): kept, they may never get worse"});
  }
}

TEST_CASE("a chain of flat tets is ordered from the tet with volume on", "[prepare]") {
  // A fan in the plane of 1, 2, 3: each tet has three of its points on a circle arc with the next.
  const std::vector<Point> points = {{0, 0, 1}, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {4, 4, 0}, {2, 5, 0}};
  const std::vector<std::array<std::uint32_t, 4>> rows = {{1, 2, 3, 0}, {1, 3, 2, 4}, {3, 2, 4, 5}};
  const std::vector<Tet> expected = oriented_tets(make_mesh(points, rows).tets);
  REQUIRE(test::examine(make_mesh(points, rows)).folded_faces == 0);
  for (unsigned swaps = 0; swaps < 4; ++swaps) {
    auto given = rows;
    if (swaps & 1) std::swap(given[1][0], given[1][1]);
    if (swaps & 2) std::swap(given[2][0], given[2][1]);
    CHECK(original_tets(prepare(make_mesh(points, given))) == expected);
  }
}

TEST_CASE("prepare freezes where the mesh is no manifold", "[prepare]") {
  CHECK(frozen_originals(prepare(test::pinched_edge())) == std::vector<std::uint32_t>{0, 1});
  CHECK(frozen_originals(prepare(test::pinched_vertex())) == std::vector<std::uint32_t>{0});
  std::vector<Point> points = kFivePoints;
  points[4] = {-1, -1, -1};
  points.insert(points.end(), {{0, -5, 0}, {0, -6, 0}, {1, -5, 0}, {0, -5, 1}});
  const TetMesh folded = make_mesh(points, {{0, 1, 2, 3}, {4, 1, 2, 3}, {5, 7, 8, 6}});
  CHECK(frozen_originals(prepare(folded)) == std::vector<std::uint32_t>{0, 1, 2, 3, 4});
}

TEST_CASE("prepare keeps unused points, last and in their order", "[prepare]") {
  std::vector<Point> points = kFivePoints;
  points.insert(points.begin(), {9, 9, 9});
  TetMesh mesh = make_mesh(points, {{1, 2, 3, 4}});
  test::add_test_fields(mesh);
  const PreparedMesh prepared = prepare(mesh);
  check_prepared(mesh, prepared);
  CHECK(prepared.used_vertex_count == 4);
  CHECK(prepared.original_vertex[4] == VertexId{0});
  CHECK(prepared.original_vertex[5] == VertexId{5});
}

// Three spikes through two plates: one plate is pierced by two of them, one by the third.
//
//       a   b           c
//     --|---|--       --|--         Faces of a, of b and of the plate are of one curve, as the plate's two faces meet
//       |   |           |           both; c and the other plate are of another.
TEST_CASE("prepare tells along which curves the boundary crosses itself", "[prepare]") {
  std::vector<Point> points;
  std::vector<std::array<std::uint32_t, 4>> tets;
  const auto add = [&](const std::array<Point, 4>& corners) {
    const auto first = static_cast<std::uint32_t>(points.size());
    points.insert(points.end(), corners.begin(), corners.end());
    tets.push_back({first, first + 1, first + 2, first + 3});
  };
  const auto spike = [&](double x, double y) {
    add({{{x, y, -3}, {x - 0.1, y - 0.1, 3}, {x + 0.2, y - 0.1, 3}, {x, y + 0.3, 3}}});
  };
  const auto plate = [&](double x) { add({{{x - 4, -4, 0}, {x + 4, -4, 0}, {x, 6, 0}, {x, -2, -0.7}}}); };
  plate(0);
  spike(-0.5, 0.31);
  spike(0.7, 0.37);
  plate(20);
  spike(20.3, 0.33);
  const PreparedMesh prepared = prepare(make_mesh(points, tets));
  REQUIRE(prepared.crossing_curves.size() == prepared.boundary_faces.size());
  std::array<std::set<std::uint32_t>, 5> curves_of_body; // but 0
  for (std::size_t f = 0; f < prepared.boundary_faces.size(); ++f)
    if (prepared.crossing_curves[f] != 0)
      curves_of_body.at(prepared.original_vertex[prepared.boundary_faces[f][0].index()].index() / 4)
          .insert(prepared.crossing_curves[f]);
  for (const auto& curves : curves_of_body)
    CHECK(curves.size() == 1);
  CHECK(curves_of_body[1] == curves_of_body[0]);
  CHECK(curves_of_body[2] == curves_of_body[0]);
  CHECK(curves_of_body[4] == curves_of_body[3]);
  CHECK(curves_of_body[3] != curves_of_body[0]);
  CHECK(*std::max_element(prepared.crossing_curves.begin(), prepared.crossing_curves.end()) == 2);
  // The caps of the spikes cross nothing.
  CHECK(std::count(prepared.crossing_curves.begin(), prepared.crossing_curves.end(), 0) >= 3);

  CHECK(prepare(test::pinched_vertex()).crossing_curves.empty());
}

TEST_CASE("prepare refuses what validate calls an error, in its words", "[prepare]") {
  std::vector<Point> with_nan = kFivePoints;
  with_nan[1][0] = std::numeric_limits<double>::quiet_NaN();
  TetMesh bad_array = test::single_tet();
  bad_array.point_arrays.push_back({"p", ScalarType::kFloat32, 1, std::vector<std::byte>(15)});
  TetMesh bad_positions = test::single_tet();
  bad_positions.positions.components = 1;
  for (const TetMesh& mesh : {
           TetMesh{},
           make_mesh(kFivePoints, {{0, 1, 2, 3}, {0, 1, 2, 5}}),
           make_mesh(kFivePoints, {{0, 1, 2, 3}, {0, 1, 2, 2}}),
           make_mesh(kFivePoints, {{0, 1, 2, 3}, {1, 0, 3, 2}}),
           make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {2, 2, 2}},
                     {{0, 1, 2, 3}, {4, 2, 1, 3}, {5, 2, 1, 3}}),
           make_mesh(with_nan, {{0, 1, 2, 3}}),
           bad_array,
           bad_positions,
       }) {
    const MeshReport report = validate(mesh);
    REQUIRE(report.first_error() != nullptr);
    INFO(report.first_error()->code);
    try {
      (void)prepare(mesh);
      FAIL("accepted");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kBadInput);
      CHECK(error.what() == report.first_error()->message);
    }
  }
}
