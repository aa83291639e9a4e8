// Tets some at a time: those that come one after the other in a mesh are near to one another as a rule, so that most
// are dealt with by the box around them.
#pragma once

#include "mesh/box_tree.hpp"
#include "ptet/mesh.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace ptet {

using TetRun = std::span<const Tet>;
inline constexpr std::size_t kRunLength = 128;

/// The run that begins at `first`, a multiple of kRunLength below the number of tets.
[[nodiscard]] inline TetRun run_from(TetRun tets, std::size_t first) {
  return tets.subspan(first, std::min(kRunLength, tets.size() - first));
}

[[nodiscard]] inline BoundingBox box_around(const TetMesh& mesh, TetRun run) {
  BoundingBox box;
  for (const Tet& tet : run)
    for (const VertexId v : tet)
      box.add(mesh.position(v));
  return box;
}

[[nodiscard]] inline std::array<Point, 4> corners_of(const TetMesh& mesh, const Tet& tet) {
  return {mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3])};
}

} // namespace ptet
