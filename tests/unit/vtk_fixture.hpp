// Mesh files as text, to be read or refused.
#pragma once

#include "formats/vtk/read.hpp"
#include "ptet/error.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"

#include <algorithm>
#include <string>

#include <catch2/catch.hpp>

namespace ptet::test {

inline std::string fixture(const std::string& name) {
  return std::string(PTET_SOURCE_DIR "/tests/fixtures/") + name;
}

struct Failure {
  ErrorCode code{};
  std::string message;
};

inline Failure failure_of(const std::string& path) {
  try {
    (void)read_mesh(path);
  } catch (const Error& error) {
    return {error.code(), error.what()};
  }
  FAIL("nothing was thrown for " << path);
  return {};
}

/// The parts of an ascii VTU of one tet that a test may want wrong.
struct VtuText {
  std::string type = "UnstructuredGrid";
  std::string counts = R"(NumberOfPoints="4" NumberOfCells="1")";
  std::string version = "1.0";
  std::string point_data;
  std::string cell_data;
  std::string points =
      R"(<DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray>)";
  std::string connectivity = "0 1 2 3";
  std::string offsets = "4";
  std::string types = "10";

  [[nodiscard]] std::string piece() const {
    return "<Piece " + counts + "><PointData>" + point_data + "</PointData><CellData>" + cell_data +
           "</CellData><Points>" + points +
           "</Points><Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">" + connectivity +
           "</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">" + offsets +
           "</DataArray><DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">" + types +
           "</DataArray></Cells></Piece>";
  }
  [[nodiscard]] std::string file(const std::string& more_pieces = {}) const {
    return "<VTKFile type=\"" + type + "\" version=\"" + version +
           "\" byte_order=\"LittleEndian\" header_type=\"UInt64\"><" + type + ">" + piece() + more_pieces + "</" +
           type + "></VTKFile>";
  }
};

inline Failure failure_of_text(const std::string& text, const std::string& name = "mesh.vtu") {
  const TempFolder folder;
  write_bytes(folder / name, text);
  const Failure failure = failure_of(folder / name);
  CHECK(failure.message.starts_with(folder / name));
  CHECK(failure.message.find(".cxx") == std::string::npos);
  return failure;
}

inline TetMesh read_text(const std::string& text, ReadReport* report = nullptr) {
  const TempFolder folder;
  write_bytes(folder / "mesh.vtu", text);
  return read_mesh(folder / "mesh.vtu", report);
}

inline bool has_note(const ReadReport& report, const std::string& part) {
  return std::any_of(report.notes.begin(), report.notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

inline std::string array_text(const std::string& name, const std::string& values, const std::string& more = {}) {
  return "<DataArray type=\"Float32\" " + name + " " + more + " format=\"ascii\">" + values + "</DataArray>";
}

inline std::string legacy_text(const std::string& cells, const std::string& types, const std::string& rest = {}) {
  return "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\n"
         "POINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n" +
         cells + "\n" + types + "\n" + rest;
}

inline void check_is_sound(const MeshFacts& facts) {
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.repeated_tets == 0);
  CHECK(facts.crowded_faces == 0);
  CHECK(facts.folded_faces == 0);
}

/// No face of one tet inside the cube [0, width]^3.
inline bool is_closed_inside(const TetMesh& mesh, const MeshFacts& facts, double width) {
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

/// One ball of sound tets, without a gap: the cube [0, width]^3.
inline void check_fills_cube(const TetMesh& mesh, double width) {
  const MeshFacts facts = examine(mesh);
  check_is_sound(facts);
  CHECK(facts.components == 1);
  CHECK(facts.boundary_euler_characteristic == 2);
  CHECK(facts.volume == Approx(width * width * width));
  CHECK(is_closed_inside(mesh, facts, width));
}

} // namespace ptet::test
