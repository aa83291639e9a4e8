#include "support/meshes.hpp"

#include "mesh/scalar_dispatch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <numeric>
#include <random>
#include <utility>

namespace ptet::test {
namespace {

void set_value(PointArray& array, std::size_t row, std::uint32_t component, double value) {
  dispatch(array.type, [&]<class T>(T) {
    store<T>(array.bytes.data() + (row * array.components + component) * sizeof(T), static_cast<T>(value));
  });
}

} // namespace

TetMesh make_mesh(const std::vector<Point>& positions, const std::vector<std::array<std::uint32_t, 4>>& tets,
                  ScalarType position_type) {
  TetMesh mesh;
  mesh.positions.type = position_type;
  mesh.positions.resize(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v)
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      set_value(mesh.positions, v, axis, positions[v][axis]);
  for (const auto& tet : tets)
    mesh.tets.push_back({VertexId{tet[0]}, VertexId{tet[1]}, VertexId{tet[2]}, VertexId{tet[3]}});
  return mesh;
}

void add_array(TetMesh& mesh, const std::string& name, ScalarType type, std::uint32_t components,
               const std::function<std::vector<double>(const Point&)>& value) {
  PointArray array{name, type, components, {}};
  array.resize(mesh.vertex_count());
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const std::vector<double> row = value(mesh.position(VertexId{v}));
    for (std::uint32_t c = 0; c < components; ++c)
      set_value(array, v, c, row.at(c));
  }
  mesh.point_arrays.push_back(std::move(array));
}

TetMesh mapped(const TetMesh& mesh, const std::function<Point(const Point&)>& map) {
  std::vector<Point> positions;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    positions.push_back(map(mesh.position(VertexId(v))));
  TetMesh result = make_mesh(positions, {}, ScalarType::kFloat64);
  result.tets = mesh.tets;
  return result;
}

void add_test_fields(TetMesh& mesh) {
  add_array(mesh, "pressure", ScalarType::kFloat32, 1,
            [](const Point& p) { return std::vector<double>{std::sin(p[0] / 19) + std::cos(p[1] / 23) * p[2] / 40}; });
  add_array(mesh, "flow", ScalarType::kFloat64, 3, [](const Point& p) {
    return std::vector<double>{p[1] * p[2] / 100, -p[0] / 3, std::sqrt(1 + p[0] * p[0])};
  });
  PointArray marker{"marker", ScalarType::kUInt8, 1, {}};
  marker.resize(mesh.vertex_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    marker.bytes[v] = static_cast<std::byte>(v % 251);
  mesh.point_arrays.push_back(std::move(marker));
}

TetMesh single_tet() {
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}});
}

TetMesh two_tets_sharing_a_face() {
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, {{0, 1, 2, 3}, {4, 2, 1, 3}});
}

TetMesh six_cycle() {
  std::vector<Point> positions = {{0, 0, -2}, {0, 0, 2}};
  std::vector<std::array<std::uint32_t, 4>> tets;
  const std::array<std::array<int, 2>, 6> ring = {{{2, 0}, {1, 2}, {-1, 2}, {-2, 0}, {-1, -2}, {1, -2}}};
  for (const auto& at : ring)
    positions.push_back({static_cast<double>(at[0]), static_cast<double>(at[1]), 0});
  for (std::uint32_t i = 0; i < 6; ++i)
    tets.push_back({0, 2 + i, 2 + (i + 1) % 6, 1});
  return make_mesh(positions, tets);
}

TetMesh pinched_vertex() {
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                   {{0, 1, 2, 3}, {0, 5, 4, 6}});
}

TetMesh pinched_edge() {
  return make_mesh({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 2, 3, 1}, {0, 4, 5, 1}});
}

TetMesh grid(const GridOptions& options) {
  const auto [nx, ny, nz] = options.cells;
  std::mt19937 random(options.seed);
  std::map<std::array<int, 3>, std::uint32_t> ids;
  std::vector<Point> positions;
  const auto vertex = [&](std::array<int, 3> at) {
    const auto [found, is_new] = ids.emplace(at, static_cast<std::uint32_t>(positions.size()));
    if (is_new) {
      Point p{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const int span = 2 * options.jitter + 1;
        p[axis] = 16 * at[axis] + static_cast<int>(random() % static_cast<unsigned>(span)) - options.jitter;
      }
      positions.push_back(p);
    }
    return found->second;
  };
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        if (options.keep && !options.keep(x, y, z)) continue;
        // One tet for each order of the axes in which one can walk from the low corner to the high one.
        std::array<std::size_t, 3> axes = {0, 1, 2};
        do {
          std::array<int, 3> at = {x, y, z};
          std::array<std::uint32_t, 4> tet{};
          tet[0] = vertex(at);
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[axes[step]];
            tet[step + 1] = vertex(at);
          }
          const bool is_even = axes[0] == (axes[1] + 2) % 3;
          if (!is_even) std::swap(tet[2], tet[3]);
          tets.push_back(tet);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  TetMesh mesh = make_mesh(positions, tets);
  add_test_fields(mesh);
  return mesh;
}

TetMesh pinched_layers(unsigned seed) {
  constexpr double kCell = 16, kWidth = 1e5, kThickness = 3;
  constexpr int kAcross = 4, kLayers = 4;
  const TetMesh layers = grid({{kAcross, kAcross, kLayers}, {}, 0, 1});
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);
  std::map<std::pair<double, double>, Point> column; // where the vertices of one stand
  std::vector<Point> points;
  std::vector<double> layer;
  for (std::uint32_t v = 0; v < layers.vertex_count(); ++v) {
    const Point p = layers.position(VertexId{v});
    const auto [it, is_new] = column.try_emplace({p[0], p[1]});
    if (is_new) it->second = {p[0] / kCell + jitter(random), p[1] / kCell + jitter(random), 0};
    const double depth = std::clamp((it->second[0] / kAcross - 0.2) * 1.7, 0.0, 1.0) * kLayers * kThickness;
    layer.push_back(kLayers - p[2] / kCell);
    points.push_back({kWidth * it->second[0], kWidth * it->second[1], -std::min(depth, kThickness * layer.back())});
  }
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (const Tet& tet : layers.tets)
    tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
  TetMesh mesh = make_mesh(points, tets, ScalarType::kFloat64);
  std::size_t row = 0;
  add_array(mesh, "layer", ScalarType::kFloat64, 1, [&](const Point&) { return std::vector{layer[row++]}; });
  add_array(mesh, "smooth", ScalarType::kFloat64, 1,
            [&](const Point& p) { return std::vector{20 * std::exp(p[2] / 10) + std::sin(p[0] / kWidth)}; });
  return mesh;
}

std::vector<NamedMesh> sample_meshes(unsigned seed) {
  std::vector<NamedMesh> meshes;
  meshes.push_back({"cube", grid({{5, 5, 5}, {}, 2, seed})});
  meshes.push_back({"l-shape", grid({{6, 6, 3}, [](int x, int y, int) { return x < 3 || y < 3; }, 2, seed})});
  meshes.push_back(
      {"frame", grid({{7, 7, 2}, [](int x, int y, int) { return x < 2 || x > 4 || y < 2 || y > 4; }, 2, seed})});
  meshes.push_back(
      {"cavity", grid({{5, 5, 5}, [](int x, int y, int z) { return x != 2 || y != 2 || z != 2; }, 2, seed})});
  meshes.push_back({"two components", grid({{9, 4, 4}, [](int x, int, int) { return x != 4; }, 2, seed})});
  meshes.push_back({"plate", grid({{9, 9, 1}, {}, 2, seed})});
  return meshes;
}

std::string data_dir() {
  const char* from_environment = std::getenv("PTET_DATA");
  return from_environment != nullptr ? from_environment : PTET_SOURCE_DIR "/../shared/data";
}

std::optional<std::string> data_file(const std::string& name) {
  const auto path = std::filesystem::path(data_dir()) / name;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return std::nullopt;
  return path.string();
}

} // namespace ptet::test
