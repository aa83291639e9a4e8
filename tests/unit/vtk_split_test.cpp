#include "formats/vtk/read.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <sstream>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

enum VtkCell { kTetra = 10, kVoxel = 11, kHexahedron = 12, kWedge = 13, kPyramid = 14, kQuadraticTetra = 24 };

struct Cells {
  std::vector<Point> points;
  std::vector<std::pair<int, std::vector<int>>> cells;
};

constexpr int kHexFaces[6][4] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};

/// A cube of n^3 cells, each two units wide, of mixed kinds. Columns along z are either hexahedra, voxels and cubes of
/// six pyramids, or wedges, whose triangles then lie on the outside and on one another.
Cells mixed_cube(int n, unsigned seed) {
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
        const unsigned kind = random() % 3;
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

/// Every tet of a mesh with a point in the middle of each edge.
Cells with_mid_points(const TetMesh& mesh) {
  static constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  Cells made;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    made.points.push_back(mesh.position(VertexId(v)));
  std::map<std::pair<int, int>, int> middles;
  for (const Tet& tet : mesh.tets) {
    std::vector<int> ids;
    for (const VertexId v : tet)
      ids.push_back(static_cast<int>(v.index()));
    for (const auto& edge : kEdges) {
      const auto key = std::minmax({ids[static_cast<std::size_t>(edge[0])], ids[static_cast<std::size_t>(edge[1])]});
      const auto [at, is_new] = middles.try_emplace(key, static_cast<int>(made.points.size()));
      if (is_new) {
        const Point a = made.points[static_cast<std::size_t>(key.first)];
        const Point b = made.points[static_cast<std::size_t>(key.second)];
        made.points.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2});
      }
      ids.push_back(at->second);
    }
    made.cells.push_back({kQuadraticTetra, ids});
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

/// No face of one tet inside the cube [0, width]^3.
bool is_closed_inside(const TetMesh& mesh, const MeshFacts& facts, double width) {
  return std::all_of(facts.boundary.begin(), facts.boundary.end(), [&](const Face& face) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double side : {0.0, width}) {
        if (std::all_of(face.begin(), face.end(), [&](VertexId v) { return mesh.position(v)[axis] == side; }))
          return true;
      }
    }
    return false;
  });
}

} // namespace

TEST_CASE("mixed cells are split so that neighbours agree", "[vtk]") {
  const auto seed = GENERATE(1U, 2U, 3U, 4U, 5U);
  Cells cells = mixed_cube(5, seed);
  shuffle(cells, seed);
  ReadReport report;
  const TetMesh mesh = read_cells(cells, &report);
  CHECK(mesh.vertex_count() == cells.points.size());
  const MeshFacts facts = examine(mesh);
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.repeated_tets == 0);
  CHECK(facts.crowded_faces == 0);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.components == 1);
  CHECK(facts.boundary_euler_characteristic == 2);
  CHECK(facts.volume == Approx(1000));
  CHECK(is_closed_inside(mesh, facts, 10));
  REQUIRE(report.notes.size() == 1);
  CHECK_THAT(report.notes[0], Catch::StartsWith("split ") && Catch::EndsWith(" into tetrahedra"));
}

TEST_CASE("quadratic tets are split at their middle points so that neighbours agree", "[vtk]") {
  const auto seed = GENERATE(1U, 2U, 3U);
  GridOptions options;
  options.jitter = 0;
  const TetMesh linear = grid(options);
  Cells cells = with_mid_points(linear);
  shuffle(cells, seed);
  const TetMesh mesh = read_cells(cells);
  CHECK(mesh.tets.size() == 8 * linear.tets.size());
  const MeshFacts before = examine(linear);
  const MeshFacts facts = examine(mesh);
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.crowded_faces == 0);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.boundary.size() == 4 * before.boundary.size());
  CHECK(facts.volume == Approx(before.volume));
}

TEST_CASE("each kind of cell gives its number of tets", "[vtk]") {
  const std::vector<Point> cube = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                   {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const auto tets = [&](int type, std::vector<int> ids) { return read_cells({cube, {{type, ids}}}).tets.size(); };
  CHECK(tets(kTetra, {0, 1, 2, 5}) == 1);
  CHECK(tets(kHexahedron, {0, 1, 2, 3, 4, 5, 6, 7}) == 6);
  CHECK(tets(kVoxel, {0, 1, 3, 2, 4, 5, 7, 6}) == 6);
  CHECK(tets(kWedge, {0, 3, 1, 4, 7, 5}) == 3);
  CHECK(tets(kPyramid, {0, 1, 2, 3, 6}) == 2);
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
