#include "formats/surface/write.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "ptet/error.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <sstream>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

using Triangle = std::array<Point, 3>;

struct Surface {
  std::size_t vertices = 0;
  std::vector<Triangle> triangles;
};

Surface read_obj(const std::string& path) {
  std::istringstream text(read_bytes(path));
  std::vector<Point> points;
  Surface surface;
  for (std::string line; std::getline(text, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Point p{};
      words >> p[0] >> p[1] >> p[2];
      points.push_back(p);
    } else if (kind == "f") {
      std::array<std::size_t, 3> id{};
      words >> id[0] >> id[1] >> id[2];
      surface.triangles.push_back({points.at(id[0] - 1), points.at(id[1] - 1), points.at(id[2] - 1)});
    }
  }
  surface.vertices = points.size();
  return surface;
}

Surface read_off(const std::string& path) {
  std::istringstream text(read_bytes(path));
  std::string word;
  std::size_t vertices = 0;
  std::size_t faces = 0;
  text >> word >> vertices >> faces >> word;
  std::vector<Point> points(vertices);
  for (Point& p : points)
    text >> p[0] >> p[1] >> p[2];
  Surface surface{vertices, {}};
  for (std::size_t i = 0; i < faces; ++i) {
    std::array<std::size_t, 4> id{};
    text >> id[0] >> id[1] >> id[2] >> id[3];
    REQUIRE(id[0] == 3);
    surface.triangles.push_back({points.at(id[1]), points.at(id[2]), points.at(id[3])});
  }
  return surface;
}

template <class T>
Point point_at(const char* bytes) {
  const auto* from = reinterpret_cast<const std::byte*>(bytes);
  return {load<T>(from), load<T>(from + sizeof(T)), load<T>(from + 2 * sizeof(T))};
}

Surface read_stl(const std::string& path) {
  const std::string bytes = read_bytes(path);
  const auto count = load<std::uint32_t>(reinterpret_cast<const std::byte*>(bytes.data()) + 80);
  REQUIRE(bytes.size() == 84 + 50 * count);
  Surface surface;
  for (std::size_t i = 0; i < count; ++i) {
    const char* record = bytes.data() + 84 + 50 * i;
    surface.triangles.push_back(
        {point_at<float>(record + 12), point_at<float>(record + 24), point_at<float>(record + 36)});
  }
  return surface;
}

Surface read_ply(const std::string& path) {
  const std::string bytes = read_bytes(path);
  const auto number_after = [&](const std::string& text) {
    return std::stoul(bytes.substr(bytes.find(text) + text.size()));
  };
  const std::size_t vertices = number_after("element vertex ");
  const std::size_t faces = number_after("element face ");
  const char* at = bytes.data() + bytes.find("end_header\n") + 11;
  const bool is_double = bytes.find("property double x\nproperty double y\nproperty double z\n") != std::string::npos;
  if (!is_double) REQUIRE(bytes.find("property float x\nproperty float y\nproperty float z\n") != std::string::npos);
  const std::size_t row_bytes = is_double ? 24 : 12;
  REQUIRE(bytes.data() + bytes.size() - at == static_cast<std::ptrdiff_t>(row_bytes * vertices + 13 * faces));
  std::vector<Point> points;
  for (std::size_t i = 0; i < vertices; ++i, at += row_bytes)
    points.push_back(is_double ? point_at<double>(at) : point_at<float>(at));
  Surface surface{vertices, {}};
  for (std::size_t i = 0; i < faces; ++i, at += 13) {
    const auto* ids = reinterpret_cast<const std::byte*>(at + 1);
    surface.triangles.push_back({points.at(load<std::uint32_t>(ids)), points.at(load<std::uint32_t>(ids + 4)),
                                 points.at(load<std::uint32_t>(ids + 8))});
  }
  return surface;
}

/// Turned so that the least corner is first; ascending.
std::vector<Triangle> sorted(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles)
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

std::vector<Triangle> triangles_of(const TetMesh& mesh, const std::vector<Face>& faces) {
  std::vector<Triangle> triangles;
  for (const Face& f : faces)
    triangles.push_back({mesh.position(f[0]), mesh.position(f[1]), mesh.position(f[2])});
  return sorted(triangles);
}

} // namespace

TEST_CASE("a boundary surface comes out in every format", "[surface]") {
  const TempFolder folder;
  for (const auto& [name, mesh] : sample_meshes(1)) {
    INFO(name);
    const std::vector<Face> faces = examine(mesh).boundary;
    const std::vector<Triangle> expected = triangles_of(mesh, faces);
    for (const char* ending : {"obj", "off", "ply", "stl"})
      write_surface(folder / (std::string("s.") + ending), mesh, faces);
    CHECK(sorted(read_obj(folder / "s.obj").triangles) == expected);
    CHECK(sorted(read_off(folder / "s.off").triangles) == expected);
    CHECK(sorted(read_ply(folder / "s.ply").triangles) == expected);
    CHECK(sorted(read_stl(folder / "s.stl").triangles) == expected);
    CHECK(folder.names().size() == 4);

    std::vector<VertexId> used;
    for (const Face& face : faces)
      used.insert(used.end(), face.begin(), face.end());
    std::sort(used.begin(), used.end());
    const auto count = static_cast<std::size_t>(std::unique(used.begin(), used.end()) - used.begin());
    CHECK(read_obj(folder / "s.obj").vertices == count);
  }
}

TEST_CASE("32-bit positions come back exactly from decimal files", "[surface]") {
  TetMesh mesh = make_mesh({{0.1, 1.0 / 3, 1e-20}, {123456.789, 0, 0}, {0, 1e20, 0}, {0, 0, 1}}, {{0, 1, 2, 3}});
  const std::vector<Face> faces = examine(mesh).boundary;
  const TempFolder folder;
  write_surface(folder / "s.obj", mesh, faces);
  std::vector<Triangle> read = read_obj(folder / "s.obj").triangles;
  for (Triangle& t : read) {
    for (Point& p : t) {
      for (double& x : p)
        x = static_cast<float>(x);
    }
  }
  CHECK(sorted(read) == triangles_of(mesh, faces));
}

TEST_CASE("coordinates come out in the fewest digits that give them back", "[surface]") {
  const TempFolder folder;
  TetMesh mesh =
      make_mesh({{0.1, 0, 0}, {16777216, 0, 0.25}, {0, 1e20F, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}, ScalarType::kFloat32);
  const std::vector<Face> faces = examine(mesh).boundary;
  write_surface(folder / "s.obj", mesh, faces);
  CHECK_THAT(read_bytes(folder / "s.obj"), Catch::Contains("# 4 vertices, 4 faces\nv 0.1 0 0\nv 16777216 0 0.25\n"
                                                           "v 0 1e+20 0\nv 0 0 1\nf "));
  write_surface(folder / "s.off", mesh, faces);
  CHECK_THAT(read_bytes(folder / "s.off"), Catch::StartsWith("OFF\n4 4 0\n0.1 0 0\n16777216 0 0.25\n"));
}

TEST_CASE("double positions come out as they are, except in .stl, which says what became of them", "[surface]") {
  const TempFolder folder;
  GridOptions options;
  options.cells = {4, 4, 4};
  const TetMesh plain = grid(options);
  std::vector<Point> points;
  const auto put_at = [&](double offset, double size) {
    TetMesh mesh = plain;
    mesh.positions = {"", ScalarType::kFloat64, 3, {}};
    points.clear();
    for (std::uint32_t v = 0; v < plain.vertex_count(); ++v) {
      const Point p = plain.position(VertexId(v));
      points.push_back({offset + size * p[0] / 3, offset + size * p[1] / 3, offset + size * p[2] / 3});
    }
    mesh.positions.resize(points.size());
    std::memcpy(mesh.positions.bytes.data(), points.data(), mesh.positions.bytes.size());
    return mesh;
  };
  SECTION("far from the origin") {
    const TetMesh mesh = put_at(1e7, 0.05);
    const std::vector<Face> faces = examine(mesh).boundary;
    const std::vector<Triangle> expected = triangles_of(mesh, faces);
    for (const char* ending : {"obj", "off", "ply"}) {
      const SurfaceLoss loss = write_surface(folder / (std::string("s.") + ending), mesh, faces);
      CHECK(loss.largest_move == 0);
      CHECK(loss.degenerate_faces == 0);
    }
    CHECK(sorted(read_obj(folder / "s.obj").triangles) == expected);
    CHECK(sorted(read_off(folder / "s.off").triangles) == expected);
    CHECK(sorted(read_ply(folder / "s.ply").triangles) == expected);
    const SurfaceLoss loss = write_surface(folder / "s.stl", mesh, faces);
    CHECK(loss.degenerate_faces > 0);
    CHECK(loss.degenerate_faces <= faces.size());
    CHECK(loss.largest_move > 0.01 * loss.diagonal);
    // 32-bit floats there are 1 apart.
    CHECK(loss.largest_move <= std::sqrt(3) / 2);
  }
  SECTION("near it") {
    const TetMesh mesh = put_at(0, 1);
    const SurfaceLoss loss = write_surface(folder / "s.stl", mesh, examine(mesh).boundary);
    CHECK(loss.degenerate_faces == 0);
    CHECK(loss.largest_move > 0);
    CHECK(loss.largest_move < 1e-7 * loss.diagonal);
  }
  SECTION("beyond 32-bit floats") {
    const TetMesh mesh = put_at(0, 1e200);
    const std::vector<Face> faces = examine(mesh).boundary;
    for (const char* ending : {"obj", "off", "ply"})
      write_surface(folder / (std::string("s.") + ending), mesh, faces);
    CHECK(sorted(read_obj(folder / "s.obj").triangles) == triangles_of(mesh, faces));
    CHECK(sorted(read_off(folder / "s.off").triangles) == triangles_of(mesh, faces));
    CHECK(sorted(read_ply(folder / "s.ply").triangles) == triangles_of(mesh, faces));
  }
}

TEST_CASE("no face is lost where the surface is not a manifold", "[surface]") {
  const TempFolder folder;
  SECTION("a pinched vertex is written once for each fan") {
    const TetMesh mesh = pinched_vertex();
    const std::vector<Face> faces = examine(mesh).boundary;
    write_surface(folder / "s.obj", mesh, faces);
    CHECK(sorted(read_obj(folder / "s.obj").triangles) == triangles_of(mesh, faces));
    CHECK(read_obj(folder / "s.obj").vertices == mesh.vertex_count() + 1);
  }
  SECTION("a pinched edge") {
    const TetMesh mesh = pinched_edge();
    const std::vector<Face> faces = examine(mesh).boundary;
    write_surface(folder / "s.obj", mesh, faces);
    CHECK(sorted(read_obj(folder / "s.obj").triangles) == triangles_of(mesh, faces));
    CHECK(read_obj(folder / "s.obj").vertices == mesh.vertex_count() + 2);
  }
  SECTION("faces that no surface could hold: repeated, reversed, three at an edge") {
    const TetMesh mesh = two_tets_sharing_a_face();
    const auto v = [](std::uint32_t i) { return VertexId(i); };
    const std::vector<Face> faces = {{v(0), v(1), v(2)}, {v(0), v(1), v(2)}, {v(0), v(2), v(1)}, {v(0), v(1), v(3)},
                                     {v(1), v(0), v(4)}, {v(1), v(2), v(4)}, {v(2), v(0), v(4)}};
    write_surface(folder / "s.off", mesh, faces);
    CHECK(sorted(read_off(folder / "s.off").triangles) == triangles_of(mesh, faces));
  }
  SECTION("every face of every tet of a grid, both sides") {
    const TetMesh mesh = grid({});
    std::vector<Face> faces;
    for (const Tet& t : mesh.tets) {
      for (const Face& f :
           {Face{t[0], t[2], t[1]}, Face{t[0], t[1], t[3]}, Face{t[1], t[2], t[3]}, Face{t[2], t[0], t[3]}})
        faces.push_back(f);
    }
    write_surface(folder / "s.obj", mesh, faces);
    CHECK(sorted(read_obj(folder / "s.obj").triangles) == triangles_of(mesh, faces));
  }
}

TEST_CASE("surfaces that cannot be written are refused and leave nothing behind", "[surface]") {
  const TempFolder folder;
  const TetMesh mesh = single_tet();
  const auto code = [&](const std::string& path, const std::vector<Face>& faces) {
    try {
      write_surface(path, mesh, faces);
    } catch (const Error& error) {
      return error.code();
    }
    FAIL("nothing was thrown");
    return ErrorCode{};
  };
  const VertexId a(0);
  const VertexId b(1);
  CHECK(code(folder / "s.vtu", {}) == ErrorCode::kBadArgument);
  CHECK(code(folder / "s.obj", {{a, b, VertexId(4)}}) == ErrorCode::kBadInput);
  CHECK(code(folder / "s.obj", {{a, b, a}}) == ErrorCode::kBadInput);
  const TetMesh wide = make_mesh({{0, 0, 0}, {1e39, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}, ScalarType::kFloat64);
  CHECK_THROWS_WITH(write_surface(folder / "s.stl", wide, examine(wide).boundary),
                    Catch::Contains("beyond the range of 32-bit floats"));
  CHECK(code(folder / "none" + "/s.obj", {}) == ErrorCode::kIo);
  CHECK(folder.names().empty());
}
