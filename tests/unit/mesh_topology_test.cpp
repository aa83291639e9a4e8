// The face table, the boundary and the vertex links, on meshes small enough to know by heart.
#include "mesh/topology.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"

#include <catch2/catch.hpp>

namespace {

using namespace ptet;

struct Topology {
  explicit Topology(const std::vector<std::array<std::uint32_t, 4>>& rows, std::size_t vertex_count) {
    for (const auto& row : rows)
      tets.push_back({VertexId{row[0]}, VertexId{row[1]}, VertexId{row[2]}, VertexId{row[3]}});
    examine(vertex_count);
  }
  explicit Topology(const TetMesh& mesh) : tets(mesh.tets) { examine(mesh.vertex_count()); }

  void examine(std::size_t vertex_count) {
    faces = build_face_table(tets, vertex_count);
    boundary = build_boundary(tets, faces, vertex_count);
    links = examine_links(tets, faces, boundary, vertex_count);
  }
  [[nodiscard]] std::int64_t euler() const {
    return static_cast<std::int64_t>(links.used_count - links.edge_count + faces.face_count - tets.size());
  }
  [[nodiscard]] std::int64_t boundary_euler() const {
    return static_cast<std::int64_t>(boundary.vertex_count - boundary.edge_count + boundary.faces.size());
  }

  std::vector<Tet> tets;
  FaceTable faces;
  BoundarySurface boundary;
  VertexLinks links;
};

std::vector<VertexId> ids(std::initializer_list<std::uint32_t> values) {
  std::vector<VertexId> result;
  for (const std::uint32_t v : values)
    result.emplace_back(v);
  return result;
}

TetMesh cells(std::array<int, 3> size, const std::function<bool(int, int, int)>& keep) {
  return test::grid({size, keep, 0, 1});
}

} // namespace

TEST_CASE("topology of single_tet", "[topology]") {
  const Topology t(test::single_tet());
  CHECK(t.faces.mate == std::vector<HalfFace>{0, 1, 2, 3});
  CHECK(t.boundary.faces.size() == 4);
  CHECK(t.links.non_manifold.empty());
  CHECK(t.links.edge_count == 6);
  CHECK(t.euler() == 1);
  CHECK(t.boundary_euler() == 2);
  const TetMesh mesh = test::single_tet();
  for (HalfFace h = 0; h < 4; ++h) {
    const Face face = face_of(t.tets, h);
    CHECK(orientation(mesh.position(face[0]), mesh.position(face[1]), mesh.position(face[2]),
                      mesh.position(apex_of(t.tets, h))) == -1);
  }
}

TEST_CASE("topology of two_tets_sharing_a_face", "[topology]") {
  const Topology t(test::two_tets_sharing_a_face());
  // {0, 1, 2, 3} and {4, 2, 1, 3}: the faces opposite 0 and 4.
  CHECK(t.faces.mate == std::vector<HalfFace>{4, 1, 2, 3, 0, 5, 6, 7});
  CHECK_FALSE(is_folded(t.tets, t.faces, 0));
  CHECK(t.faces.face_count == 7);
  CHECK(t.boundary.faces.size() == 6);
  CHECK(t.links.non_manifold.empty());
  CHECK(count_components(t.tets, t.faces) == 1);
}

TEST_CASE("two tets that see their face from the same side are folded", "[topology]") {
  const Topology t({{0, 1, 2, 3}, {4, 1, 2, 3}}, 5);
  CHECK(is_folded(t.tets, t.faces, 0));
  CHECK(is_folded(t.tets, t.faces, 4));
}

TEST_CASE("topology of three tets on a face", "[topology]") {
  const Topology t({{0, 1, 2, 3}, {4, 2, 1, 3}, {1, 2, 3, 5}}, 6);
  CHECK(t.faces.mate[0] == 4);
  CHECK(t.faces.mate[4] == 11);
  CHECK(t.faces.mate[11] == 0);
  CHECK(t.faces.crowded == std::vector<HalfFace>{0});
  CHECK_FALSE(t.faces.is_interior(0));
  CHECK(t.boundary.faces.size() == 9);
  CHECK(t.boundary.non_manifold_edges.size() == 3);
  CHECK(t.links.non_manifold == ids({1, 2, 3}));
  CHECK(t.links.edge_count == 12);
  CHECK(count_components(t.tets, t.faces) == 1);
}

TEST_CASE("duplicate tets are found whatever their order of vertices", "[topology]") {
  CHECK(Topology({{0, 1, 2, 3}, {3, 1, 0, 2}}, 4).faces.duplicates == std::vector<TetId>{TetId{1}});
  CHECK(Topology({{0, 1, 2, 3}, {4, 2, 1, 3}, {0, 1, 2, 3}, {4, 1, 2, 3}, {1, 2, 3, 4}}, 5).faces.duplicates ==
        std::vector<TetId>{TetId{2}, TetId{3}, TetId{4}});
}

TEST_CASE("tets that share an edge only", "[topology]") {
  const Topology t(test::pinched_edge());
  CHECK(t.boundary.non_manifold_edges == std::vector<std::array<VertexId, 2>>{{VertexId{0}, VertexId{1}}});
  CHECK(t.links.non_manifold == ids({0, 1}));
  CHECK(t.boundary.components == 1);
  CHECK(t.links.edge_count == 11);
  CHECK(count_components(t.tets, t.faces) == 2);
}

TEST_CASE("tets that share a vertex only", "[topology]") {
  const Topology t(test::pinched_vertex());
  CHECK(t.boundary.non_manifold_edges.empty());
  CHECK(t.links.non_manifold == ids({0}));
  CHECK(t.boundary.components == 2);
  CHECK(t.links.edge_count == 12);
  CHECK(count_components(t.tets, t.faces) == 2);
}

TEST_CASE("a vertex whose link is a torus", "[topology]") {
  // The cone over Csaszar's torus, the one of seven vertices and fourteen triangles.
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t i = 0; i < 7; ++i) {
    tets.push_back({7, i, (i + 1) % 7, (i + 3) % 7});
    tets.push_back({7, i, (i + 3) % 7, (i + 2) % 7});
  }
  const Topology t(tets, 8);
  CHECK(t.boundary.faces.size() == 14);
  CHECK(t.boundary_euler() == 0);
  CHECK(t.links.non_manifold == ids({7}));
  CHECK(t.euler() == 1);
}

TEST_CASE("a vertex whose link is two spheres that share an edge", "[topology]") {
  // Both are boundaries of tets: of 1, 2, 3, 4 and of 1, 2, 5, 6.
  const Topology t(
      {{0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 3, 4}, {0, 2, 3, 4}, {0, 1, 2, 5}, {0, 1, 2, 6}, {0, 1, 5, 6}, {0, 2, 5, 6}},
      7);
  CHECK(t.faces.crowded.size() == 1);
  CHECK(t.links.non_manifold == ids({0, 1, 2}));
}

TEST_CASE("Euler characteristics tell a ball, a ring and a shell", "[topology]") {
  const Topology ball(cells({3, 3, 3}, {}));
  CHECK(ball.euler() == 1);
  CHECK(ball.boundary_euler() == 2);
  const Topology ring(cells({3, 3, 1}, [](int x, int y, int) { return x != 1 || y != 1; }));
  CHECK(ring.euler() == 0);
  CHECK(ring.boundary_euler() == 0);
  CHECK(ring.boundary.components == 1);
  const Topology shell(cells({3, 3, 3}, [](int x, int y, int z) { return x != 1 || y != 1 || z != 1; }));
  CHECK(shell.euler() == 2);
  CHECK(shell.boundary_euler() == 4);
  CHECK(shell.boundary.components == 2);
  CHECK(count_components(shell.tets, shell.faces) == 1);
  for (const Topology* t : {&ball, &ring, &shell})
    CHECK(t->links.non_manifold.empty());
}

TEST_CASE("a cavity that touches the outside in an edge pinches the domain there", "[topology]") {
  const Topology t(cells({3, 3, 1}, [](int x, int y, int) { return x + y != 1; }));
  CHECK(t.boundary.non_manifold_edges.size() == 1);
  CHECK(t.links.non_manifold.size() == 2);
}

TEST_CASE("the face table agrees with a plain search", "[topology]") {
  for (const test::NamedMesh& sample : test::sample_meshes(5)) {
    INFO(sample.name);
    const Topology t(sample.mesh);
    const test::MeshFacts facts = test::examine(sample.mesh);
    std::vector<Face> boundary;
    for (const Face& face : t.boundary.faces)
      boundary.push_back(test::turned(face));
    std::sort(boundary.begin(), boundary.end());
    CHECK(boundary == facts.boundary);
    CHECK(t.boundary_euler() == facts.boundary_euler_characteristic);
    CHECK(count_components(t.tets, t.faces) == facts.components);
    for (HalfFace h = 0; h < t.faces.mate.size(); ++h) {
      Face here = face_of(t.tets, h), there = face_of(t.tets, t.faces.mate[h]);
      std::sort(here.begin(), here.end());
      std::sort(there.begin(), there.end());
      REQUIRE(here == there);
    }
  }
}
