// The real meshes: sound, of known size and topology, and prepared without loss.
#include "formats/vtk/read.hpp"
#include "mesh/prepare.hpp"
#include "ptet/validate.hpp"
#include "support/meshes.hpp"

#include <algorithm>

#include <catch2/catch.hpp>

namespace {

struct RealMesh {
  std::string name;
  std::uint64_t vertices, tets, boundary_faces, boundary_components;
  std::int64_t boundary_euler_characteristic; // of one surface of genus g: 2 - 2 g
  std::uint64_t near_flat_tets;
  std::uint64_t crossing_faces; ///< pairs
};

const std::vector<RealMesh> kRealMeshes = {
    {"fire_ug.vtu", 12323, 62772, 7092, 1, 2, 0, 0},
    {"pulley.vtu", 14762, 63767, 15582, 1, -16, 0, 0},
    {"fea_bracket.vtu", 16468, 56786, 25696, 1, -16, 0, 0},
    {"seamount.vtu", 20004, 100450, 9116, 1, 2, 0, 0},
    {"bluntfin.vtu", 40921, 187356, 13438, 1, 2, 49, 0},
    {"motorbike.vtu", 455682, 2573753, 125976, 204, 248, 2, 30437},
};

} // namespace

TEST_CASE("real meshes are sound and of known topology", "[validate][prepare][data]") {
  for (const RealMesh& expected : kRealMeshes) {
    const auto path = ptet::test::data_file(expected.name);
    if (!path) {
      WARN("skipped: no " << expected.name << " in " << ptet::test::data_dir() << " (set PTET_DATA)");
      continue;
    }
    INFO(expected.name);
    ptet::TetMesh mesh = ptet::read_mesh(*path);
    const ptet::MeshReport report = ptet::validate(mesh);
    CHECK(report.vertices == expected.vertices);
    CHECK(report.tets == expected.tets);
    CHECK(report.boundary_faces == expected.boundary_faces);
    CHECK(report.components == 1);
    CHECK(report.boundary_components == expected.boundary_components);
    CHECK(report.boundary_euler_characteristic == expected.boundary_euler_characteristic);
    // A 3-manifold's Euler characteristic is half that of its boundary.
    CHECK(2 * report.euler_characteristic == expected.boundary_euler_characteristic);
    REQUIRE(report.findings.size() ==
            (expected.near_flat_tets > 0 ? 1U : 0U) + (expected.crossing_faces > 0 ? 2U : 0U));
    if (expected.near_flat_tets > 0) {
      CHECK(report.findings[0].code == "near-flat-tets");
      CHECK(report.findings[0].count == expected.near_flat_tets);
    }
    if (expected.crossing_faces > 0) {
      CHECK(report.findings[1].code == "crossing-boundary-faces");
      CHECK(report.findings[1].count == expected.crossing_faces);
      CHECK(report.findings[2].code == "overlapping-tets");
    }

    std::vector<ptet::Tet> given = mesh.tets;
    const ptet::PreparedMesh prepared = ptet::prepare(std::move(mesh));
    CHECK(std::count(prepared.frozen.begin(), prepared.frozen.end(), 1) == 0);
    CHECK(prepared.used_vertex_count == expected.vertices);
    CHECK(prepared.boundary_faces.size() == expected.boundary_faces);
    // Nothing was reoriented, so tets come back in the very order of their vertices.
    std::vector<ptet::Tet> back = prepared.mesh.tets;
    for (ptet::Tet& tet : back)
      for (ptet::VertexId& v : tet)
        v = prepared.original_vertex[v.index()];
    std::sort(given.begin(), given.end());
    std::sort(back.begin(), back.end());
    CHECK(given == back);
  }
}
