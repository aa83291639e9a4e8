// Meshes for tests: tiny named ones, grids of tets with holes and corners cut out, and where the real ones are.
//
// Grid positions are small integers, so volumes and orientations can be computed without any rounding.
#pragma once

#include "ptet/mesh.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace ptet::test {

/// A mesh from positions (stored as float32 unless said otherwise) and tets; no fields.
[[nodiscard]] TetMesh make_mesh(const std::vector<Point>& positions,
                                const std::vector<std::array<std::uint32_t, 4>>& tets,
                                ScalarType position_type = ScalarType::kFloat32);
/// Appends a point array: `value(position)` has `components` numbers.
void add_array(TetMesh& mesh, const std::string& name, ScalarType type, std::uint32_t components,
               const std::function<std::vector<double>(const Point&)>& value);
/// The same tets with every position mapped, in doubles; no fields.
[[nodiscard]] TetMesh mapped(const TetMesh& mesh, const std::function<Point(const Point&)>& map);
/// "pressure" (float32), "flow" (float64 x 3) and "marker" (uint8, the vertex id modulo 251).
void add_test_fields(TetMesh& mesh);

[[nodiscard]] TetMesh single_tet();
[[nodiscard]] TetMesh two_tets_sharing_a_face();
/// Six tets around one edge.
[[nodiscard]] TetMesh six_cycle();
/// Two tets that share one vertex only.
[[nodiscard]] TetMesh pinched_vertex();
/// Two tets that share one edge only: four boundary faces meet there.
[[nodiscard]] TetMesh pinched_edge();

struct GridOptions {
  std::array<int, 3> cells{4, 4, 4};
  /// Which cells are there; all when empty.
  std::function<bool(int, int, int)> keep;
  /// Each vertex is moved by up to this much along each axis; a cell is 16 wide and 3 is safe.
  int jitter = 2;
  unsigned seed = 1;
};
/// Cells of six tets each, conforming; only used vertices; with test fields.
[[nodiscard]] TetMesh grid(const GridOptions& options);

/// Layers that pinch out towards one side, as those of the ground or the sea do: a grid pressed down to a depth that
/// falls to nothing, so that many tets are flat and many vertices stand in the same place. Wide and thin. Fields:
/// "layer" (which of them, float64), of several values in one place; "smooth" (float64).
[[nodiscard]] TetMesh pinched_layers(unsigned seed);

struct NamedMesh {
  std::string name;
  TetMesh mesh;
};
/// Cube, L-shape, frame with a hole through it, box with a cavity, two components, flat plate: some hundred vertices
/// each.
[[nodiscard]] std::vector<NamedMesh> sample_meshes(unsigned seed);

/// The path of a real mesh such as "fire_ug.vtu", or nothing when it is not on this machine: the folder is the
/// environment variable PTET_DATA or else <source>/../shared/data.
[[nodiscard]] std::optional<std::string> data_file(const std::string& name);
[[nodiscard]] std::string data_dir();

} // namespace ptet::test
