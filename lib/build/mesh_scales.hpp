// What costs and errors are measured by: numbers of the whole mesh. The builder of a part of it is handed them, so that
// what it decides, and at what cost, is what a builder of the whole would see there.
#pragma once

#include "build/normalized_fields.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace ptet::build {

struct MeshScales {
  double diagonal = 1; ///< of the box of the used vertices; 1 when they are all in one place
  double volume = 0;
  std::uint32_t vertex_count = 0; ///< used
  std::uint32_t tet_count = 0;
  std::vector<double> field_range; ///< by governing field
  /// By governing field: its standard deviation over the domain, of the distances from its mean, as a fraction of its
  /// range; 1 for one that does not vary.
  std::vector<double> field_deviation;

  /// What an average vertex stands for.
  [[nodiscard]] double vertex_volume() const { return volume / std::max<double>(1, vertex_count); }
};

[[nodiscard]] double volume_of(const PreparedMesh& prepared, const Tet& tet);
/// Of the original mesh.
[[nodiscard]] double volume_of(const PreparedMesh& prepared);

/// Of all of `prepared`.
[[nodiscard]] MeshScales scales_of(const PreparedMesh& prepared, const NormalizedFields& fields);

/// By used vertex of `prepared`: what it stands for, a quarter of each tet around it, in volumes of an average vertex.
[[nodiscard]] std::vector<double> vertex_volumes(const PreparedMesh& prepared, const MeshScales& scales);

} // namespace ptet::build
