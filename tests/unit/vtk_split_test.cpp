#include "formats/vtk/read.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"
#include "vtk_fixture.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <sstream>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

enum VtkCell {
  kTetra = 10,
  kVoxel = 11,
  kHexahedron = 12,
  kWedge = 13,
  kPyramid = 14,
  kQuadraticTetra = 24,
  kQuadraticHexahedron = 25,
  kQuadraticWedge = 26,
  kQuadraticPyramid = 27,
  kTriquadraticHexahedron = 29,
  kBiquadraticWedge = 32
};

struct Cells {
  std::vector<Point> points;
  std::vector<std::pair<int, std::vector<int>>> cells;
};

const std::vector<Point> kCube = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                  {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
constexpr int kHexFaces[6][4] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};

/// A cube of n^3 cells, each two units wide, of mixed kinds. Columns along z are either hexahedra, voxels and, where
/// wanted, cubes of six pyramids, or wedges, whose triangles then lie on the outside and on one another.
Cells mixed_cube(int n, unsigned seed, bool with_pyramids = true) {
  std::mt19937 random(seed);
  Cells made;
  const auto id = [n](int i, int j, int k) { return i + (n + 1) * (j + (n + 1) * k); };
  for (int k = 0; k <= n; ++k) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i)
        made.points.push_back({2.0 * i, 2.0 * j, 2.0 * k});
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const bool wedges = random() % 3 == 0;
      for (int k = 0; k < n; ++k) {
        const int h[8] = {id(i, j, k),     id(i + 1, j, k),     id(i + 1, j + 1, k),     id(i, j + 1, k),
                          id(i, j, k + 1), id(i + 1, j, k + 1), id(i + 1, j + 1, k + 1), id(i, j + 1, k + 1)};
        const unsigned kind = random() % (with_pyramids ? 3 : 2);
        if (wedges) {
          made.cells.push_back({kWedge, {h[0], h[3], h[1], h[4], h[7], h[5]}});
          made.cells.push_back({kWedge, {h[1], h[3], h[2], h[5], h[7], h[6]}});
        } else if (kind == 0) {
          made.cells.push_back({kHexahedron, {h, h + 8}});
        } else if (kind == 1) {
          made.cells.push_back({kVoxel, {h[0], h[1], h[3], h[2], h[4], h[5], h[7], h[6]}});
        } else {
          const int centre = static_cast<int>(made.points.size());
          made.points.push_back({2.0 * i + 1, 2.0 * j + 1, 2.0 * k + 1});
          for (const auto& face : kHexFaces)
            made.cells.push_back({kPyramid, {h[face[3]], h[face[2]], h[face[1]], h[face[0]], centre}});
        }
      }
    }
  }
  return made;
}

/// The corners, in the order of the quadratic cell, and after them its points in the middle of several of them.
struct Quadratic {
  int type;
  std::vector<int> corners;
  std::vector<std::vector<int>> middles;
};

/// VTK's quadratic kind of each linear one; those with points in the middle of quadrilaterals, too, or without.
const std::map<int, Quadratic>& quadratic_kinds(bool with_face_points) {
  static const std::vector<std::vector<int>> kOfHexahedron = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                                              {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  // Triangles are the other way round than those of linear wedges.
  static const std::vector<int> kWedgeCorners = {0, 2, 1, 3, 5, 4};
  static const std::vector<std::vector<int>> kOfWedge = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5},
                                                         {5, 3}, {0, 3}, {1, 4}, {2, 5}};
  const auto also = [](std::vector<std::vector<int>> middles, const std::vector<std::vector<int>>& more) {
    middles.insert(middles.end(), more.begin(), more.end());
    return middles;
  };
  static const std::map<int, Quadratic> kPlain = {
      {kTetra, {kQuadraticTetra, {0, 1, 2, 3}, {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}}},
      {kPyramid,
       {kQuadraticPyramid, {0, 1, 2, 3, 4}, {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}}},
      {kWedge, {kQuadraticWedge, kWedgeCorners, kOfWedge}},
      {kVoxel, {kQuadraticHexahedron, {0, 1, 3, 2, 4, 5, 7, 6}, kOfHexahedron}},
      {kHexahedron, {kQuadraticHexahedron, {0, 1, 2, 3, 4, 5, 6, 7}, kOfHexahedron}}};
  static const std::vector<std::vector<int>> kOfTriquadratic = also(
      kOfHexahedron,
      {{0, 3, 7, 4}, {1, 2, 6, 5}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 2, 3, 4, 5, 6, 7}});
  static const std::map<int, Quadratic> kWithFacePoints = {
      {kWedge, {kBiquadraticWedge, kWedgeCorners, also(kOfWedge, {{0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}})}},
      {kVoxel, {kTriquadraticHexahedron, {0, 1, 3, 2, 4, 5, 7, 6}, kOfTriquadratic}},
      {kHexahedron, {kTriquadraticHexahedron, {0, 1, 2, 3, 4, 5, 6, 7}, kOfTriquadratic}}};
  return with_face_points ? kWithFacePoints : kPlain;
}

/// Every cell as a quadratic one with straight edges.
Cells quadratic(const Cells& linear, bool with_face_points = false) {
  Cells made;
  made.points = linear.points;
  std::map<std::vector<int>, int> middles;
  for (const auto& [type, points] : linear.cells) {
    const Quadratic& kind = quadratic_kinds(with_face_points).at(type);
    std::vector<int> ids;
    for (const int corner : kind.corners)
      ids.push_back(points[static_cast<std::size_t>(corner)]);
    for (const std::vector<int>& of : kind.middles) {
      std::vector<int> key;
      for (const int corner : of)
        key.push_back(ids[static_cast<std::size_t>(corner)]);
      std::sort(key.begin(), key.end());
      const auto [at, is_new] = middles.try_emplace(key, static_cast<int>(made.points.size()));
      if (is_new) {
        Point middle{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for (const int v : key)
            middle[axis] += made.points[static_cast<std::size_t>(v)][axis];
          middle[axis] /= static_cast<double>(key.size());
        }
        made.points.push_back(middle);
      }
      ids.push_back(at->second);
    }
    made.cells.push_back({kind.type, ids});
  }
  return made;
}

Cells cells_of(const TetMesh& mesh) {
  Cells made;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    made.points.push_back(mesh.position(VertexId(v)));
  for (const Tet& tet : mesh.tets) {
    made.cells.push_back({kTetra, {}});
    for (const VertexId v : tet)
      made.cells.back().second.push_back(static_cast<int>(v.index()));
  }
  return made;
}

/// Renumbers the points at random.
void shuffle(Cells& cells, unsigned seed) {
  std::vector<int> to(cells.points.size());
  std::iota(to.begin(), to.end(), 0);
  std::shuffle(to.begin(), to.end(), std::mt19937(seed));
  std::vector<Point> moved(cells.points.size());
  for (std::size_t i = 0; i < to.size(); ++i)
    moved[static_cast<std::size_t>(to[i])] = cells.points[i];
  cells.points = moved;
  for (auto& cell : cells.cells) {
    for (int& id : cell.second)
      id = to[static_cast<std::size_t>(id)];
  }
}

std::string legacy_text(const Cells& cells) {
  std::ostringstream text;
  text << "# vtk DataFile Version 3.0\ncells\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS " << cells.points.size()
       << " double\n";
  for (const Point& p : cells.points)
    text << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  std::size_t size = 0;
  for (const auto& cell : cells.cells)
    size += 1 + cell.second.size();
  text << "CELLS " << cells.cells.size() << ' ' << size << '\n';
  for (const auto& cell : cells.cells) {
    text << cell.second.size();
    for (const int id : cell.second)
      text << ' ' << id;
    text << '\n';
  }
  text << "CELL_TYPES " << cells.cells.size() << '\n';
  for (const auto& cell : cells.cells)
    text << cell.first << '\n';
  return text.str();
}

TetMesh read_cells(const Cells& cells, ReadReport* report = nullptr) {
  const TempFolder folder;
  write_bytes(folder / "cells.vtk", legacy_text(cells));
  return read_mesh(folder / "cells.vtk", report);
}

} // namespace

TEST_CASE("two pyramids of a cell meet along an edge with a point on it", "[vtk]") {
  // Seen along that edge: a and e on the faces beside it, the apex between them. Either face has its diagonal from the
  // first point of the edge to the last, and a flat triangle beside it.
  const std::vector<Point> points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, -2, 0}, {1, 0, -2}, {1, -1, -1}};
  enum { kFirst, kOn, kLast, kA, kE, kApex };
  const Cells cells{points, {{kPyramid, {kFirst, kOn, kLast, kA, kApex}}, {kPyramid, {kLast, kOn, kFirst, kE, kApex}}}};
  ReadReport report;
  const TetMesh mesh = read_cells(cells, &report);
  REQUIRE(mesh.tets.size() == 2);
  CHECK(examine(mesh).volume == Approx(4.0 / 3));
  CHECK(examine(mesh).boundary.size() == 6);
  CHECK(std::any_of(report.notes.begin(), report.notes.end(),
                    [](const std::string& note) { return note.starts_with("left out 2 tetrahedra"); }));
  // One alone keeps its flat tet: its neighbour has the points on the edge, too.
  CHECK(read_cells({points, {cells.cells[0]}}).tets.size() == 2);
}

TEST_CASE("mixed cells are split so that neighbours agree", "[vtk]") {
  const auto seed = GENERATE(1U, 2U, 3U, 4U, 5U);
  Cells cells = mixed_cube(5, seed);
  shuffle(cells, seed);
  ReadReport report;
  const TetMesh mesh = read_cells(cells, &report);
  CHECK(mesh.vertex_count() == cells.points.size());
  check_fills_cube(mesh, 10);
  REQUIRE(report.notes.size() == 1);
  CHECK_THAT(report.notes[0], Catch::StartsWith("split ") && Catch::EndsWith(" into tetrahedra"));
}

namespace {

/// Layers of hexahedra, one unit wide, over a wavy ground.
Cells layers_of_hexahedra(int n, double thickness, double waves, double turned_by) {
  Cells made;
  const int layers = 4;
  const auto id = [n](int i, int j, int k) { return i + (n + 1) * (j + (n + 1) * k); };
  for (int k = 0; k <= layers; ++k) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        const double x = i, y = j, z = waves * std::sin(1.7 * i) * std::cos(2.3 * j) + thickness * k;
        const double c = std::cos(turned_by), s = std::sin(turned_by);
        made.points.push_back({c * x - s * (c * y - s * z), s * x + c * (c * y - s * z), s * y + c * z});
      }
    }
  }
  for (int k = 0; k < layers; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        made.cells.push_back({kHexahedron,
                              {id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k), id(i, j, k + 1),
                               id(i + 1, j, k + 1), id(i + 1, j + 1, k + 1), id(i, j + 1, k + 1)}});
  return made;
}

using PlacedTet = std::array<Point, 4>;
std::vector<PlacedTet> placed_tets(const TetMesh& mesh) {
  std::vector<PlacedTet> placed;
  for (const Tet& tet : mesh.tets) {
    PlacedTet corners{};
    for (std::size_t i = 0; i < 4; ++i)
      corners[i] = mesh.position(tet[i]);
    std::sort(corners.begin(), corners.end());
    placed.push_back(corners);
  }
  std::sort(placed.begin(), placed.end());
  return placed;
}

} // namespace

TEST_CASE("thin hexahedra with warped faces are split without turning tets over, however they are numbered", "[vtk]") {
  const double turned_by = GENERATE(0.0, 0.4, 1.1, 2.0);
  const auto seed = GENERATE(1U, 2U, 3U);
  Cells cells = layers_of_hexahedra(12, 0.025, 0.2, turned_by); // faces are warped by more than a layer
  const std::vector<PlacedTet> in_order = placed_tets(read_cells(cells));
  shuffle(cells, seed);
  ReadReport report;
  const TetMesh mesh = read_cells(cells, &report);
  const MeshFacts facts = examine(mesh);
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.crowded_faces == 0);
  CHECK(report.notes == std::vector<std::string>{"split 576 hexahedra into tetrahedra"});
  CHECK((placed_tets(mesh) == in_order));
}

TEST_CASE("diagonals of distorted hexahedra are chosen so that no tet is turned over", "[vtk]") {
  const auto seed = GENERATE(1U, 2U, 3U, 4U);
  Cells cells = layers_of_hexahedra(10, 1, 0, 0);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> off(-0.3, 0.3);
  for (Point& p : cells.points)
    for (double& x : p)
      x += off(random);
  shuffle(cells, seed);
  const MeshFacts facts = examine(read_cells(cells));
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.crowded_faces == 0);
}

TEST_CASE("pieces that repeat the points of a face split it alike", "[vtk]") {
  // Two layers of a wavy grid, each with points of its own.
  Cells lower = layers_of_hexahedra(5, 0.025, 0.2, 0.4);
  const std::size_t half = lower.cells.size() / 2;
  Cells apart;
  std::mt19937 random(7);
  for (const std::size_t begin : {std::size_t{0}, half}) {
    std::vector<int> to(lower.points.size(), -1), used;
    for (std::size_t c = begin; c < begin + half; ++c)
      used.insert(used.end(), lower.cells[c].second.begin(), lower.cells[c].second.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    std::shuffle(used.begin(), used.end(), random);
    for (const int id : used) {
      to[static_cast<std::size_t>(id)] = static_cast<int>(apart.points.size());
      apart.points.push_back(lower.points[static_cast<std::size_t>(id)]);
    }
    for (std::size_t c = begin; c < begin + half; ++c) {
      auto cell = lower.cells[c];
      for (int& id : cell.second)
        id = to[static_cast<std::size_t>(id)];
      apart.cells.push_back(cell);
    }
  }
  CHECK((placed_tets(read_cells(apart)) == placed_tets(read_cells(lower))));
}

TEST_CASE("cells that cannot be split without turning tets over are named", "[vtk]") {
  // The second of two cubes has one corner of its top drawn through its bottom.
  Cells cells{kCube, {{kHexahedron, {0, 1, 2, 3, 4, 5, 6, 7}}, {kHexahedron, {8, 9, 10, 11, 12, 13, 14, 15}}}};
  for (const Point& p : kCube)
    cells.points.push_back({p[0] + 3, p[1], p[2]});
  cells.points[14][2] = -2;
  ReadReport report;
  CHECK(read_cells(cells, &report).tets.size() == 12);
  REQUIRE(report.notes.size() == 2);
  CHECK_THAT(report.notes[1], Catch::StartsWith("1 cell (1) cannot be split without turning"));
}

TEST_CASE("choosing diagonals ends where points of one cell are at one place, and unused points are nowhere", "[vtk]") {
  // Cells over points of a coarse lattice, so that many coincide: twisted, and with corners at one place.
  const auto seed = GENERATE(range(1U, 60U));
  std::mt19937 random(seed);
  const auto at = [&] { return 0.5 * static_cast<double>(random() % 4); };
  Cells cells;
  for (int i = 0; i < 24; ++i)
    cells.points.push_back({at(), at(), at()});
  for (int c = 0; c < 6; ++c) {
    std::vector<int> ids(cells.points.size());
    std::iota(ids.begin(), ids.end(), 0);
    std::shuffle(ids.begin(), ids.end(), random);
    ids.resize(8);
    cells.cells.push_back({random() % 2 == 0 ? kVoxel : kHexahedron, ids});
  }
  CHECK(read_cells(cells).tets.size() > 6);
}

TEST_CASE("cells whose points repeat so that nothing is left are named", "[vtk]") {
  const Cells cells{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}},
                    {{kTetra, {0, 1, 3, 4}}, {kHexahedron, {0, 1, 2, 3, 4, 5, 0, 6}}}};
  ReadReport report;
  CHECK(read_cells(cells, &report).tets.size() == 1);
  REQUIRE(report.notes.size() == 2);
  CHECK_THAT(report.notes[1], Catch::StartsWith("1 cell (1) left out"));
}

TEST_CASE("tets stay in the order of the cells that they come from", "[vtk]") {
  const Cells cells{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0, 1}, {2, 2, 2}},
                    {{kTetra, {0, 1, 2, 3}}, {kPyramid, {1, 4, 2, 0, 6}}, {kTetra, {1, 5, 3, 6}}}};
  const TetMesh mesh = read_cells(cells);
  REQUIRE(mesh.tets.size() == 4);
  CHECK(mesh.tets.front() == Tet{VertexId(0), VertexId(1), VertexId(2), VertexId(3)});
  CHECK(mesh.tets.back() == Tet{VertexId(1), VertexId(5), VertexId(3), VertexId(6)});
}

TEST_CASE("quadratic tets are split at their middle points so that neighbours agree", "[vtk]") {
  const auto seed = GENERATE(1U, 2U, 3U);
  GridOptions options;
  options.jitter = 0;
  const TetMesh linear = grid(options);
  Cells cells = quadratic(cells_of(linear));
  shuffle(cells, seed);
  const TetMesh mesh = read_cells(cells);
  CHECK(mesh.tets.size() == 8 * linear.tets.size());
  const MeshFacts before = examine(linear);
  const MeshFacts facts = examine(mesh);
  check_is_sound(facts);
  CHECK(facts.boundary.size() == 4 * before.boundary.size());
  CHECK(facts.volume == Approx(before.volume));
}

TEST_CASE("mixed quadratic cells are split so that neighbours agree", "[vtk]") {
  const auto seed = GENERATE(1U, 2U, 3U, 4U, 5U);
  const bool with_face_points = GENERATE(false, true);
  Cells cells = quadratic(mixed_cube(4, seed, !with_face_points), with_face_points);
  shuffle(cells, seed);
  ReadReport report;
  const TetMesh mesh = read_cells(cells, &report);
  CHECK(mesh.vertex_count() == cells.points.size());
  std::vector<VertexId> used;
  for (const Tet& tet : mesh.tets)
    used.insert(used.end(), tet.begin(), tet.end());
  std::sort(used.begin(), used.end());
  CHECK(static_cast<std::size_t>(std::unique(used.begin(), used.end()) - used.begin()) == cells.points.size());
  check_fills_cube(mesh, 8);
  REQUIRE(report.notes.size() == 1);
  CHECK_THAT(report.notes[0], Catch::StartsWith("split ") && Catch::Contains("quadratic hexahedra"));
}

TEST_CASE("the nodes of Exodus' quadratic cells are where they belong", "[vtk]") {
  ReadReport report;
  const TetMesh mesh = read_mesh(fixture("quadratic.ex2"), &report);
  CHECK(mesh.vertex_count() == 93);
  const MeshFacts facts = examine(mesh);
  check_is_sound(facts);
  CHECK(facts.components == 5);
  CHECK(facts.volume == Approx(1 + 1 + 0.5 + 0.5 + 1 / 3.0));
}

TEST_CASE("quadratic cells with curved edges are split without turning tets over", "[vtk]") {
  const bool with_face_points = GENERATE(false, true);
  Cells cells = quadratic(mixed_cube(4, 7, !with_face_points), with_face_points);
  // A bend of all space: cells, two units wide, are as good as before.
  for (Point& p : cells.points)
    p = {p[0] + 0.3 * std::sin(p[1]), p[1] + 0.3 * std::sin(p[2]), p[2] + 0.3 * std::sin(p[0])};
  shuffle(cells, 3);
  const MeshFacts facts = examine(read_cells(cells));
  check_is_sound(facts);
  CHECK(facts.components == 1);
}

TEST_CASE("each kind of cell gives its number of tets", "[vtk]") {
  const auto tets = [&](int type, std::vector<int> ids) { return read_cells({kCube, {{type, ids}}}).tets.size(); };
  CHECK(tets(kTetra, {0, 1, 2, 5}) == 1);
  CHECK(tets(kHexahedron, {0, 1, 2, 3, 4, 5, 6, 7}) == 6);
  CHECK(tets(kVoxel, {0, 1, 3, 2, 4, 5, 7, 6}) == 6);
  CHECK(tets(kWedge, {0, 3, 1, 4, 7, 5}) == 3);
  CHECK(tets(kPyramid, {0, 1, 2, 3, 6}) == 2);
  const auto quadratic_tets = [&](int type, const std::vector<int>& ids, bool with_face_points) {
    return read_cells(quadratic({kCube, {{type, ids}}}, with_face_points)).tets.size();
  };
  CHECK(quadratic_tets(kTetra, {0, 1, 2, 5}, false) == 8);
  CHECK(quadratic_tets(kHexahedron, {0, 1, 2, 3, 4, 5, 6, 7}, false) == 22);
  CHECK(quadratic_tets(kHexahedron, {0, 1, 2, 3, 4, 5, 6, 7}, true) == 48);
  CHECK(quadratic_tets(kWedge, {0, 3, 1, 4, 7, 5}, true) == 24);
  CHECK(quadratic_tets(kPyramid, {0, 1, 2, 3, 6}, false) == 13);
}

TEST_CASE("a degenerate hexahedron gives proper tets only", "[vtk]") {
  // A hexahedron with one edge of its top and bottom drawn together: a wedge of volume 1/2.
  const Cells cells{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}},
                    {{kHexahedron, {0, 1, 2, 2, 3, 4, 5, 5}}}};
  const MeshFacts facts = examine(read_cells(cells));
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.volume == Approx(0.5));
}

TEST_CASE("tets keep their order, their vertices' order and their orientation", "[vtk]") {
  const Cells cells{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}},
                    {{kTetra, {1, 4, 2, 3}}, {kTetra, {0, 2, 1, 3}}}};
  const TetMesh mesh = read_cells(cells);
  const auto tet = [](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    return Tet{VertexId(a), VertexId(b), VertexId(c), VertexId(d)};
  };
  CHECK(mesh.tets == std::vector<Tet>{tet(1, 4, 2, 3), tet(0, 2, 1, 3)});
}
