#include "build/mesh_scales.hpp"

#include "mesh/box_tree.hpp"
#include "mesh/vec3.hpp"

#include <cmath>

namespace ptet::build {
namespace {

/// By field, exact integrals over the tets; `volume`: of all.
std::vector<double> deviations_of(const PreparedMesh& prepared, const NormalizedFields& fields, double volume) {
  if (!(volume > 0)) return std::vector<double>(fields.field_count(), 1.0);
  const std::size_t channels = fields.channel_count();
  std::vector<double> mean(channels), variance(channels), deviations;
  for (const Tet& tet : prepared.mesh.tets) {
    const double part = volume_of(prepared, tet);
    for (const VertexId v : tet)
      for (std::size_t c = 0; c < channels; ++c)
        mean[c] += part / 4 * fields.at(v.index())[c];
  }
  for (double& m : mean)
    m /= volume;
  for (const Tet& tet : prepared.mesh.tets) {
    const double part = volume_of(prepared, tet) / 20;
    for (std::size_t c = 0; c < channels; ++c) {
      double sum = 0, squares = 0;
      for (const VertexId v : tet) {
        const double from_mean = fields.at(v.index())[c] - mean[c];
        sum += from_mean;
        squares += from_mean * from_mean;
      }
      variance[c] += part * (sum * sum + squares);
    }
  }
  double of_field = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    of_field += variance[c];
    if (!fields.ends_field(c)) continue;
    const double deviation = std::sqrt(of_field / volume);
    deviations.push_back(deviation > 0 ? deviation : 1);
    of_field = 0;
  }
  return deviations;
}

} // namespace

double volume_of(const PreparedMesh& prepared, const Tet& tet) {
  const auto at = [&](std::size_t i) -> const Point& { return prepared.points[tet[i].index()]; };
  return tet_volume({at(0), at(1), at(2), at(3)});
}

double volume_of(const PreparedMesh& prepared) {
  double volume = 0;
  for (const Tet& tet : prepared.mesh.tets)
    volume += volume_of(prepared, tet);
  return volume;
}

MeshScales scales_of(const PreparedMesh& prepared, const NormalizedFields& fields) {
  BoundingBox box;
  for (std::uint32_t v = 0; v < prepared.used_vertex_count; ++v)
    box.add(prepared.points[v]);
  const double diagonal = std::hypot(box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]);
  const double volume = volume_of(prepared);
  MeshScales scales{diagonal > 0 ? diagonal : 1,
                    volume,
                    prepared.used_vertex_count,
                    static_cast<std::uint32_t>(prepared.mesh.tets.size()),
                    {},
                    deviations_of(prepared, fields, volume)};
  for (const GoverningField& field : fields.fields())
    scales.field_range.push_back(field.range);
  return scales;
}

std::vector<double> vertex_volumes(const PreparedMesh& prepared, const MeshScales& scales) {
  const double quarter = 4 * scales.vertex_volume();
  std::vector<double> volumes(prepared.used_vertex_count);
  for (const Tet& tet : prepared.mesh.tets)
    for (const double part = volume_of(prepared, tet) / quarter; const VertexId v : tet)
      volumes[v.index()] += part;
  return volumes;
}

} // namespace ptet::build
