#include "generate/fields.hpp"

#include "generate/jitter.hpp"
#include "mesh/predicates.hpp"
#include "mesh/scalar_dispatch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

namespace ptet::bench {
namespace {

constexpr Point kLayerCentre{0.35, 0.35, 0.35};
constexpr double kLayerRadius = 0.3, kLayerWidth = 0.01;
constexpr double kWaves = 40;

double smooth(const Point& p) {
  return std::sin(3 * p[0]) * std::cos(2 * p[1]) + 0.5 * std::sin(2 * p[2] + p[0]);
}

double layer(const Point& p) {
  const double away = std::hypot(p[0] - kLayerCentre[0], p[1] - kLayerCentre[1], p[2] - kLayerCentre[2]);
  return std::tanh((away - kLayerRadius) / kLayerWidth);
}

Point velocity(const Point& p) {
  return {std::sin(4 * p[2]) + std::cos(3 * p[1]), std::sin(4 * p[0]) + std::cos(3 * p[2]),
          std::sin(4 * p[1]) + std::cos(3 * p[0])};
}

void set(PointArray& array, std::size_t row, std::uint32_t component, double value) {
  std::byte* const at = array.bytes.data() + row * array.row_bytes() + component * size_of(array.type);
  dispatch(array.type, [&]<class T>(T) { store(at, static_cast<T>(value)); });
}

void check_tets(const TetMesh& mesh, const ProgressCallback& progress) {
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (t % 65536 == 0) tell(progress, "checking tets", t, mesh.tets.size());
    const Tet& tet = mesh.tets[t];
    if (orientation(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3])) <= 0)
      throw Error(ErrorCode::kLimit, "tet " + std::to_string(t) + " is turned or flat as " +
                                         std::string(name_of(mesh.positions.type)) +
                                         ": the mesh is too fine for such positions");
  }
}

} // namespace

TetMesh with_known_fields(Shape shape, ScalarType type, const ProgressCallback& progress) {
  TetMesh mesh;
  const std::size_t count = shape.points.size();
  mesh.positions = {"", type, 3, {}};
  mesh.positions.resize(count);
  for (std::size_t v = 0; v < count; ++v)
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      set(mesh.positions, v, axis, shape.points[v][axis]);
  shape.points = std::vector<Point>();
  mesh.tets = std::move(shape.tets);
  check_tets(mesh, progress);

  mesh.point_arrays = {{"smooth", type, 1, {}}, {"layer", type, 1, {}}, {"velocity", type, 3, {}}};
  for (PointArray& array : mesh.point_arrays)
    array.resize(count);
  for (std::uint32_t v = 0; v < count; ++v) {
    if (v % 65536 == 0) tell(progress, "evaluating fields", v, count);
    const Point at = mesh.position(VertexId{v});
    set(mesh.point_arrays[0], v, 0, smooth(at));
    set(mesh.point_arrays[1], v, 0, layer(at));
    const Point flow = velocity(at);
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      set(mesh.point_arrays[2], v, axis, flow[axis]);
  }
  return mesh;
}

void add_detail(TetMesh& mesh, double amplitude, const ProgressCallback& progress) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const auto count = static_cast<std::uint32_t>(mesh.vertex_count());
  Point low{kInf, kInf, kInf}, high{-kInf, -kInf, -kInf};
  for (std::uint32_t v = 0; v < count; ++v)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = mesh.position(VertexId{v})[axis];
      low[axis] = std::min(low[axis], x);
      high[axis] = std::max(high[axis], x);
    }
  const double diagonal = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  if (!(diagonal > 0) || !std::isfinite(diagonal)) return;
  for (PointArray& array : mesh.point_arrays) {
    if (array.type != ScalarType::kFloat32 && array.type != ScalarType::kFloat64) continue;
    tell(progress, "adding detail", 0, 1);
    for (std::uint32_t c = 0; c < array.components; ++c) {
      double least = kInf, greatest = -kInf;
      for (std::uint32_t v = 0; v < count; ++v) {
        least = std::min(least, array.value(v, c));
        greatest = std::max(greatest, array.value(v, c));
      }
      if (!std::isfinite(greatest - least)) continue;
      for (std::uint32_t v = 0; v < count; ++v) {
        const Point p = mesh.position(VertexId{v});
        double wave = 1;
        for (std::size_t axis = 0; axis < 3; ++axis)
          wave *= std::sin(2 * std::numbers::pi * kWaves * (p[axis] - low[axis]) / diagonal + c);
        set(array, v, c, array.value(v, c) + amplitude * (greatest - least) * wave);
      }
    }
  }
}

} // namespace ptet::bench
