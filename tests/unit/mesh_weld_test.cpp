// Points that stand more than once, made one: which are, which stay apart, and what a mesh of parts becomes.
#include "mesh/prepare.hpp"
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"
#include "ptet/validate.hpp"
#include "ptet/weld.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using test::make_mesh;

namespace {

/// The tets `t` with `part_of(t)` p have points of their own for each p; the points of a part in random order.
template <class PartOf>
TetMesh in_parts(const TetMesh& whole, std::uint32_t parts, PartOf&& part_of, std::mt19937& random) {
  std::vector<std::vector<VertexId>> of_part(parts);
  for (std::uint32_t p = 0; p < parts; ++p) {
    std::vector<VertexId>& used = of_part[p];
    for (std::uint32_t t = 0; t < whole.tets.size(); ++t)
      if (part_of(t) == p) used.insert(used.end(), whole.tets[t].begin(), whole.tets[t].end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    std::shuffle(used.begin(), used.end(), random);
  }
  TetMesh mesh;
  mesh.positions = {"", whole.positions.type, 3, {}};
  for (const PointArray& array : whole.point_arrays)
    mesh.point_arrays.push_back({array.name, array.type, array.components, {}});
  const auto add_row = [](PointArray& to, const PointArray& from, VertexId v) {
    const auto row = from.bytes.begin() + static_cast<std::ptrdiff_t>(v.index() * from.row_bytes());
    to.bytes.insert(to.bytes.end(), row, row + static_cast<std::ptrdiff_t>(from.row_bytes()));
  };
  for (std::uint32_t p = 0; p < parts; ++p) {
    std::map<VertexId, VertexId> id;
    for (const VertexId v : of_part[p]) {
      id[v] = VertexId{static_cast<std::uint32_t>(mesh.vertex_count())};
      add_row(mesh.positions, whole.positions, v);
      for (std::size_t a = 0; a < whole.point_arrays.size(); ++a)
        add_row(mesh.point_arrays[a], whole.point_arrays[a], v);
    }
    for (std::uint32_t t = 0; t < whole.tets.size(); ++t) {
      if (part_of(t) != p) continue;
      const Tet& tet = whole.tets[t];
      mesh.tets.push_back({id[tet[0]], id[tet[1]], id[tet[2]], id[tet[3]]});
    }
  }
  return mesh;
}

/// Two tets on either side of the face 0 1 2, the second with points of its own.
TetMesh two_parts(const std::vector<float>& values) {
  TetMesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 0}, {0, 0, -1}, {1, 0, 0}},
                           {{0, 1, 2, 3}, {5, 4, 7, 6}});
  PointArray array{"f", ScalarType::kFloat32, 1, {}};
  array.resize(values.size());
  std::copy_n(reinterpret_cast<const std::byte*>(values.data()), array.bytes.size(), array.bytes.begin());
  mesh.point_arrays.push_back(array);
  return mesh;
}

} // namespace

TEST_CASE("welding: points of the same place and values become the first of them", "[weld]") {
  TetMesh mesh = two_parts({1, 2, 3, 4, 3, 1, 5, 2});
  CHECK(weld_points(mesh) == 3);
  const TetMesh wanted =
      make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}}, {{0, 1, 2, 3}, {0, 2, 1, 4}});
  CHECK(mesh.positions == wanted.positions);
  CHECK(mesh.tets == wanted.tets);
  for (std::uint32_t v = 0; v < 5; ++v)
    CHECK(mesh.point_arrays[0].value(v, 0) == v + 1.0);
  CHECK(weld_points(mesh) == 0);
}

TEST_CASE("welding: what differs in a bit stays apart", "[weld]") {
  TetMesh jump = two_parts({1, 2, 3, 4, 3, 1, 5, 2.5});
  CHECK(weld_points(jump) == 2);
  CHECK(jump.vertex_count() == 6);
  TetMesh zeros = two_parts({1, 2, 0, 4, -0.0F, 1, 5, 2});
  CHECK(weld_points(zeros) == 2);
  const float nan = std::nanf("");
  TetMesh nans = two_parts({1, nan, 3, 4, 3, 1, 5, nan});
  CHECK(weld_points(nans) == 3);
}

TEST_CASE("welding: a tet keeps its four corners", "[weld]") {
  // The second tet is flat: two of its corners are alike, and a third point elsewhere is like both.
  TetMesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 1}, {2, 0, 0}, {0, 0, 1}, {2, 0, 0}},
                           {{0, 1, 2, 3}, {1, 2, 3, 4}, {0, 1, 5, 6}, {2, 3, 7, 0}});
  const TetMesh before = mesh;
  CHECK(weld_points(mesh) == 1); // of (2, 0, 0)
  CHECK(mesh.vertex_count() == 7);
  CHECK(mesh.tets[1] == before.tets[1]);
  CHECK(mesh.tets[2] == before.tets[2]);
  CHECK(mesh.tets[3][2] == VertexId{5});
}

TEST_CASE("welding: what is no mesh is left as it is", "[weld]") {
  TetMesh short_array = two_parts({1, 2, 3, 4, 3, 1, 5, 2});
  short_array.point_arrays[0].bytes.pop_back();
  TetMesh no_vertex = two_parts({1, 2, 3, 4, 3, 1, 5, 2});
  no_vertex.tets[1][3] = VertexId{8};
  for (TetMesh mesh : {short_array, no_vertex, TetMesh{}}) {
    const TetMesh before = mesh;
    CHECK(weld_points(mesh) == 0);
    CHECK(mesh.positions == before.positions);
    CHECK(mesh.point_arrays == before.point_arrays);
    CHECK(mesh.tets == before.tets);
  }
}

TEST_CASE("welding: parts become the mesh that they are of, and it can get as coarse", "[weld]") {
  std::mt19937 random(11);
  const TetMesh whole = test::grid({{8, 8, 8}, {}, 2, 3});
  const TetMesh parts = in_parts(
      whole, 5, [](std::uint32_t t) { return t / 6 * 2654435761U % 5; }, random); // cells here and there
  const std::uint64_t more = parts.vertex_count() - whole.vertex_count();
  REQUIRE(more > whole.vertex_count());
  CHECK(validate(parts).components > 5);
  TetMesh welded = parts;
  CHECK(weld_points(welded) == more);
  const MeshReport is = validate(welded), was = validate(whole);
  CHECK(is.findings.empty());
  CHECK(is.vertices == was.vertices);
  CHECK(is.boundary_faces == was.boundary_faces);
  CHECK(is.components == 1);
  CHECK(is.euler_characteristic == was.euler_characteristic);

  BuildOptions options;
  options.prediction = Prediction::kQuadric;
  options.evaluation = Evaluation::kVertices;
  options.target_vertices = 0.2;
  BuildReport apart, together;
  (void)build_memory(parts, options, &apart);
  options.weld = true;
  options.keep_order = true;
  const auto bytes = build_memory(parts, options, &together);
  CHECK(apart.stopped_by != "target");
  CHECK(together.stopped_by == "target");
  CHECK(together.input_vertices == whole.vertex_count());
  CHECK(together.base_vertices <= 0.21 * static_cast<double>(whole.vertex_count()));
  REQUIRE(!together.notes.empty());
  CHECK(together.notes[0] == std::to_string(more) + " points were welded with others of the same place and values");
  // The order that is kept is that of the welded mesh.
  const auto dataset = Dataset::open_memory(bytes);
  Request request;
  request.input_order = true;
  const Extraction all = dataset->extract(request);
  CHECK(all.mesh.positions.bytes == welded.positions.bytes);
  CHECK(all.mesh.tets == welded.tets);
  CHECK(all.mesh.point_arrays == welded.point_arrays);
  CHECK(dataset->info().provenance_json.find("\"weld\"") != std::string::npos);
}
