#include "build/mesh_scales.hpp"

#include "build/certify.hpp"
#include "mesh/box_tree.hpp"

#include <cmath>

namespace ptet::build {

MeshScales scales_of(const PreparedMesh& prepared, const NormalizedFields& fields) {
  BoundingBox box;
  for (std::uint32_t v = 0; v < prepared.used_vertex_count; ++v)
    box.add(prepared.points[v]);
  const double diagonal = std::hypot(box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]);
  MeshScales scales{diagonal > 0 ? diagonal : 1,
                    volume_of(prepared),
                    prepared.used_vertex_count,
                    static_cast<std::uint32_t>(prepared.mesh.tets.size()),
                    {}};
  for (const GoverningField& field : fields.fields())
    scales.field_range.push_back(field.range);
  return scales;
}

} // namespace ptet::build
