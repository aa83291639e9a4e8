// The examination of a mesh that both `validate` and `prepare` rest on: it separates the sound tets from the others,
// orients them, finds how they hang together, and puts every defect into words.
#pragma once

#include "mesh/topology.hpp"
#include "ptet/validate.hpp"

#include <vector>

namespace ptet {

struct Examination {
  std::vector<Point> points; ///< by vertex; empty when the positions are no n x 3 table
  /// The sound tets: ids in range, four different vertices, finite positions, no earlier tet on the same vertices.
  /// Positively oriented, or flat and ordered so that neighbours agree where they can.
  std::vector<Tet> tets;
  FaceTable faces;
  BoundarySurface boundary;
  VertexLinks links;
  std::vector<std::array<HalfFace, 2>> crossing; ///< boundary faces, see Overlaps
  bool overlaps_examined = false;                ///< see MeshReport
  std::vector<HalfFace> folded;                  ///< faces whose two tets are on the same side, one half-face of each
  bool overlaps_itself = false;                  ///< there are folded faces, or parts reach into one another
  std::vector<Finding> findings;                 ///< in the order of the checks
};

/// Throws Error(kCancelled) when `progress` returns false, Error(kLimit) for more tets than kMaxTets or more vertices
/// than ids. Thread rule: const on `mesh`; on the threads of the caller's arena, `progress` on the calling one.
[[nodiscard]] Examination examine(const TetMesh& mesh, const ProgressCallback& progress = {});

/// What validate() says of a mesh that has been examined.
[[nodiscard]] MeshReport report_on(const TetMesh& mesh, const Examination& found);

} // namespace ptet
