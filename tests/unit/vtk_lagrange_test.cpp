// Cells of Lagrange's kinds: of the first and second order as what they are, of others by the points of their lattices.
#include "formats/vtk/read.hpp"
#include "ptet/validate.hpp"
#include "ptet/weld.hpp"
#include "support/mesh_checks.hpp"
#include "vtk_fixture.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

TEST_CASE("Lagrange cells of the first and second order are those of their points", "[vtk]") {
  // One cell of each kind alone; its mesh is the same by either type.
  struct Kind {
    int lagrange, plain;
    std::size_t points;
  };
  const Kind kind =
      GENERATE(Kind{71, 10, 4}, Kind{71, 24, 10}, Kind{73, 13, 6}, Kind{73, 32, 18}, Kind{72, 12, 8}, Kind{72, 29, 27});
  VtuText text;
  std::mt19937 random(3);
  std::string coordinates;
  text.connectivity.clear();
  for (std::size_t i = 0; i < kind.points; ++i) {
    text.connectivity += std::to_string(i) + " ";
    for (int axis = 0; axis < 3; ++axis)
      coordinates += std::to_string(random() % 1000) + " ";
  }
  text.counts = "NumberOfPoints=\"" + std::to_string(kind.points) + "\" NumberOfCells=\"1\"";
  text.version = "2.2"; // before, VTK numbers the edges of Lagrange's hexahedra otherwise
  text.points = array_text("NumberOfComponents=\"3\"", coordinates);
  text.offsets = std::to_string(kind.points);
  text.types = std::to_string(kind.plain);
  const TetMesh plain = read_text(text.file());
  text.types = std::to_string(kind.lagrange);
  const TetMesh lagrange = read_text(text.file());
  CHECK(lagrange.tets.size() == plain.tets.size());
  if (kind.points != 6) CHECK(lagrange.tets == plain.tets);
  // Of the points of another kind: of a higher order, or none.
  text.types = kind.lagrange == 71 ? "72" : "71";
  CHECK_THAT(failure_of_text(text.file()).message, Catch::Contains("Lagrange"));
}

TEST_CASE("a Lagrange wedge of six points has its triangles the other way round than VTK's linear one", "[vtk]") {
  VtuText text;
  text.counts = R"(NumberOfPoints="6" NumberOfCells="1")";
  text.points = array_text("NumberOfComponents=\"3\"", "0 0 0 1 0 0 0 1 0 0 0 1 1 0 1 0 1 1");
  text.connectivity = "0 1 2 3 4 5";
  text.offsets = "6";
  text.types = "73";
  CHECK(examine(read_text(text.file())).volume == Approx(0.5));
  text.types = "13";
  CHECK(examine(read_text(text.file())).volume == Approx(-0.5));
}

TEST_CASE("Lagrange cells of any order become the cells between the points of their lattices", "[vtk]") {
  // Written by VTK: two cubes side by side of twelve tets of order 4 each, of a hexahedron of order 3, of two wedges of
  // order 5.
  struct Kind {
    const char* name;
    std::size_t points, tets, boundary_faces;
    const char* note;
  };
  const auto kind =
      GENERATE(Kind{"lagrange_tets.vtu", 9 * 5 * 5 + 8 * 4 * 4, 24 * 64, 20 * 16,
                    "split 24 Lagrange tetrahedra into tetrahedra"},
               Kind{"lagrange_hexahedra.vtu", 7 * 4 * 4, 2 * 27 * 6, 10 * 9 * 2, "split 2 Lagrange hexahedra"},
               Kind{"lagrange_wedges.vtu", 11 * 6 * 6, 4 * 125 * 3, 10 * 25 * 2, "split 4 Lagrange wedges"});
  ReadReport report;
  TetMesh mesh = read_mesh(fixture(kind.name), &report);
  (void)weld_points(mesh, {1e-9, true}); // VTK's tets differ by rounding where they meet
  CHECK(mesh.vertex_count() == kind.points);
  CHECK(mesh.tets.size() == kind.tets);
  const MeshFacts facts = examine(mesh);
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.crowded_faces == 0);
  CHECK(facts.components == 1);
  CHECK(facts.boundary.size() == kind.boundary_faces);
  CHECK(facts.boundary_euler_characteristic == 2);
  CHECK(facts.volume == Approx(2));
  CHECK(validate(mesh).boundary_area == Approx(10));
  CHECK(has_note(report, kind.note));
}

TEST_CASE("Lagrange cells that ptet cannot split are refused, with what to do", "[vtk]") {
  VtuText text;
  std::string coordinates, connectivity;
  for (int i = 0; i < 64; ++i) {
    connectivity += std::to_string(i) + " ";
    coordinates += std::to_string(i % 4) + " " + std::to_string(i / 4 % 4) + " " + std::to_string(i / 16) + " ";
  }
  text.version = "2.2";
  text.counts = R"(NumberOfPoints="64" NumberOfCells="1")";
  text.points = array_text("NumberOfComponents=\"3\"", coordinates);
  text.connectivity = connectivity;
  text.offsets = "64";
  text.types = "72";
  CHECK(read_text(text.file()).tets.size() == 27 * 6);
  const std::string degrees = text.file();
  const auto with_degrees = [&](const std::string& of_cell) {
    std::string changed = degrees;
    const std::string head = "<CellData>";
    changed.replace(changed.find(head), head.size(),
                    "<CellData HigherOrderDegrees=\"d\"><DataArray type=\"Float64\" Name=\"d\" "
                    "NumberOfComponents=\"3\" format=\"ascii\">" +
                        of_cell + "</DataArray>");
    return changed;
  };
  CHECK(read_text(with_degrees("3 3 3")).tets.size() == 27 * 6);
  CHECK_THAT(failure_of_text(with_degrees("1 3 7")).message,
             Catch::Contains("cell 0 has another degree along each axis"));
  for (const char* wrong : {"5 5 5", "0 0 0", "-3 -3 -3", "3.5 3.5 3.5", "1e300 1e300 1e300"})
    CHECK_THAT(failure_of_text(with_degrees(wrong)).message, Catch::Contains("degree"));
  text.types = "74";
  CHECK_THAT(failure_of_text(text.file()).message, Catch::Contains("of Lagrange's kind"));
  text.types = "79"; // of Bezier's
  CHECK_THAT(failure_of_text(text.file()).message, Catch::Contains("of Lagrange's kind"));
  // A point that is named twice: what has no volume is left out.
  text.types = "72";
  text.connectivity.replace(0, 2, "8 "); // the next along an edge
  CHECK(read_text(text.file()).tets.size() < 27 * 6);
}
