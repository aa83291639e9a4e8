// The order of the input, kept in a file: what comes out is what went in, and of a part of it we are told which
// vertices it has.
#include "mesh/rows.hpp"
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"
#include "support/file_parts.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <numeric>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

/// Vertices, tets and corners in any order, so half of the tets are inverted; with some vertices of no tet.
TetMesh shuffled(TetMesh mesh, unsigned seed) {
  std::mt19937 random(seed);
  const std::size_t used = mesh.vertex_count();
  for (PointArray* const array : {&mesh.positions, &mesh.point_arrays[0], &mesh.point_arrays[1], &mesh.point_arrays[2]})
    array->resize(used + 3);
  std::vector<VertexId> old_ids;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    old_ids.emplace_back(v);
  std::shuffle(old_ids.begin(), old_ids.end(), random);
  std::vector<VertexId> new_ids(old_ids.size());
  for (std::uint32_t v = 0; v < old_ids.size(); ++v)
    new_ids[old_ids[v].index()] = VertexId{v};
  mesh.positions = gather(mesh.positions, old_ids);
  for (PointArray& array : mesh.point_arrays)
    array = gather(array, old_ids);
  std::shuffle(mesh.tets.begin(), mesh.tets.end(), random);
  for (Tet& tet : mesh.tets) {
    for (VertexId& v : tet)
      v = new_ids[v.index()];
    std::shuffle(tet.begin(), tet.end(), random);
  }
  return mesh;
}

std::vector<std::byte> build(const TetMesh& mesh, bool keeps_order, std::uint32_t pieces = 1) {
  BuildOptions options;
  options.keep_order = keeps_order;
  options.pieces = pieces;
  options.target_vertices = 0.05;
  return build_memory(mesh, options);
}

Request in_order() {
  Request request;
  request.input_order = true;
  return request;
}

std::vector<Point> places(const TetMesh& mesh, const std::vector<VertexId>& of) {
  std::vector<Point> points;
  for (const VertexId v : of)
    points.push_back(mesh.position(v));
  std::sort(points.begin(), points.end());
  return points;
}

} // namespace

TEST_CASE("input order: the original comes back as it stood, whatever it was and however it was built") {
  for (const std::uint32_t pieces : {1U, 3U})
    for (auto& [name, mesh] : test::sample_meshes(3)) {
      INFO(name << ", " << pieces << " pieces");
      const TetMesh given = shuffled(mesh, 5);
      const auto data = Dataset::open_memory(build(given, true, pieces));
      CHECK(data->info().has_input_order);
      Request request = in_order();
      request.origins = true;
      const Extraction whole = data->extract(request);
      CHECK(whole.mesh.positions.bytes == given.positions.bytes);
      CHECK(whole.mesh.point_arrays == given.point_arrays);
      CHECK(whole.mesh.tets == given.tets);
      std::vector<std::uint32_t> all(given.vertex_count());
      std::iota(all.begin(), all.end(), 0U);
      CHECK(whole.input_vertex == all);
      CHECK(whole.made_by.size() == given.tets.size());
      // Faces are renumbered with the vertices: the same places as without.
      const Extraction plain = data->extract({});
      CHECK(plain.input_vertex.empty());
      REQUIRE(whole.boundary_faces.size() == plain.boundary_faces.size());
      for (std::size_t f = 0; f < plain.boundary_faces.size(); f += 7)
        CHECK(places(whole.mesh, {whole.boundary_faces[f].begin(), whole.boundary_faces[f].end()}) ==
              places(plain.mesh, {plain.boundary_faces[f].begin(), plain.boundary_faces[f].end()}));
    }
}

TEST_CASE("input order: of a part of the mesh the vertices stand as they did, and are named") {
  const TetMesh given = shuffled(test::grid({{5, 4, 6}, {}, 2, 9}), 11);
  const auto data = Dataset::open_memory(build(given, true));
  Request request;
  request.max_tets = 200;
  request.origins = true;
  const Extraction plain = data->extract(request);
  request.input_order = true;
  const Extraction part = data->extract(request);
  REQUIRE(part.mesh.tets.size() == plain.mesh.tets.size());
  REQUIRE(part.input_vertex.size() == part.mesh.vertex_count());
  CHECK(part.mesh.vertex_count() < given.vertex_count());
  CHECK(std::is_sorted(part.input_vertex.begin(), part.input_vertex.end(), std::less_equal<>()));
  for (std::uint32_t v = 0; v < part.mesh.vertex_count(); ++v)
    CHECK(part.mesh.position(VertexId{v}) == given.position(VertexId{part.input_vertex[v]}));
  for (std::size_t t = 0; t < part.mesh.tets.size(); ++t)
    for (std::size_t i = 0; i < 4; ++i)
      CHECK(part.vertex_in_file[part.mesh.tets[t][i].index()] == plain.vertex_in_file[plain.mesh.tets[t][i].index()]);
  CHECK(part.made_by == plain.made_by);
}

TEST_CASE("input order: a file without it says so, and a session has none") {
  const TetMesh given = test::grid({{3, 3, 3}, {}, 2, 9});
  const auto without = Dataset::open_memory(build(given, false));
  CHECK_FALSE(without->info().has_input_order);
  CHECK_THROWS_WITH(without->extract(in_order()), Catch::Contains("does not keep the order"));
  const auto with = Dataset::open_memory(build(given, true));
  Session session(with);
  CHECK_THROWS_WITH(session.update(in_order()), Catch::Contains("an order of their own"));
  CHECK(session.update({}).complete);
}

TEST_CASE("input order: it costs one read, and one for its row of the directory") {
  const TetMesh given = shuffled(test::grid({{3, 3, 4}, {}, 2, 9}), 4);
  const auto plain = std::make_shared<test::FailingSource>(build(given, false));
  const auto kept = std::make_shared<test::FailingSource>(build(given, true));
  Request coarsest;
  coarsest.max_tets = 0;
  static_cast<void>(Dataset::open(plain)->extract(coarsest));
  coarsest.input_order = true;
  const Extraction base = Dataset::open(kept)->extract(coarsest);
  CHECK(kept->reads() == plain->reads() + 2);
  CHECK(base.input_vertex.size() == base.mesh.vertex_count());
}

TEST_CASE("input order: it is there while a thread reads the rest") {
  const TetMesh given = shuffled(test::grid({{3, 3, 4}, {}, 2, 9}), 4);
  OpenOptions options;
  options.background = true;
  const auto data = Dataset::open_memory(build(given, true), options);
  Extraction cut = data->extract(in_order());
  CHECK(cut.input_vertex.size() == cut.mesh.vertex_count());
  for (; !cut.complete; cut = data->extract(in_order()))
    data->wait_until_loaded();
  CHECK(cut.mesh.tets == given.tets);
}

TEST_CASE("input order: what is wrong in it is told to who asks for it, and to nobody else") {
  const TetMesh given = shuffled(test::grid({{3, 2, 3}, {}, 2, 9}), 2);
  const auto good = build(given, true);
  const std::size_t vertices = given.vertex_count();
  for (const std::size_t at :
       {std::size_t{0}, 4 * vertices - 1, 4 * vertices, 4 * (vertices + given.tets.size()) - 1}) {
    test::FileParts parts(good);
    parts.of(file::SectionKind::kInputOrder)[at] ^= std::byte{0x40};
    const auto data = Dataset::open_memory(parts.join());
    CHECK_THROWS_WITH(data->extract(in_order()), Catch::Contains("each once"));
    CHECK(data->extract({}).mesh.tets.size() == given.tets.size());
  }
  test::FileParts corners(good);
  corners.of(file::SectionKind::kInputOrder).back() = std::byte{24};
  CHECK_THROWS_WITH(Dataset::open_memory(corners.join())->extract(in_order()), Catch::Contains("order of corners"));

  // A source that fails when the order is read, and then does not.
  bool fails = false;
  const auto source = std::make_shared<test::FailingSource>(good, [&](std::uint64_t, std::uint64_t) { return fails; });
  const auto data = Dataset::open(source);
  static_cast<void>(data->extract({}));
  fails = true;
  CHECK_THROWS_WITH(data->extract(in_order()), Catch::Contains("the line is dead"));
  CHECK(data->extract({}).mesh.tets.size() == given.tets.size());
  fails = false;
  CHECK(data->extract(in_order()).mesh.tets == given.tets);
}
