// What a build starts from: a mesh that was examined, oriented and renumbered for locality.
//
//   vertices   [ used, along a Morton curve ............ | unused, by their old ids ]
//   tets       by their smallest vertex, so along the same curve
#pragma once

#include "mesh/predicates.hpp"
#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"

#include <string>
#include <vector>

namespace ptet {

struct PreparedMesh {
  /// Renumbered, every array with its vertices. Tets are positively oriented or flat (exact); flat ones are ordered
  /// so that neighbours agree wherever they can: a face that two tets share is seen from opposite sides.
  TetMesh mesh;
  std::uint32_t used_vertex_count = 0;   ///< vertices 0 .. used-1 are in some tet, the others in none
  std::vector<VertexId> original_vertex; ///< by vertex: its id in the mesh that was given
  /// By vertex: positions as doubles, less an origin of their own where the mesh lies far from 0 (local_origin.hpp),
  /// which is exact for used vertices.
  std::vector<Point> points;
  /// By vertex, 1: must not be removed. It lies on a boundary edge of other than two boundary faces, is a
  /// vertex whose closed link is no sphere, or belongs to a tet at a folded face.
  std::vector<char> frozen;
  std::vector<Face> boundary_faces; ///< outward oriented, in the order of the tets they bound
  /// By boundary face: which curve it is of, from 1 on, where the boundary crosses itself, or 0; empty when it nowhere
  /// does. Faces that cross one another are of one curve, and so are all that they cross in turn.
  std::vector<std::uint32_t> crossing_curves;
  bool overlaps_itself = false;   ///< tets were found that are folded over others, or lie in others
  std::vector<std::string> notes; ///< a sentence for each kind of thing that was found and handled
};

/// Examines `mesh`, orients its tets, finds what must be frozen and renumbers all for locality.
///
/// Throws Error(kBadInput) with the message of the first finding of `validate` that is an error: ids out of range,
/// repeated vertices, duplicate tets, faces of more than two tets, non-finite positions, arrays of the wrong size, no
/// tet. Throws Error(kLimit) for more than kMaxTets tets, or more vertices than 32-bit ids can name.
/// Non-finite field values are left alone. Same mesh, same result. Cost: O(tets), plus a sort of the vertices and the
/// search for overlaps (overlaps.hpp).
/// Throws Error(kCancelled) when `progress` returns false.
[[nodiscard]] PreparedMesh prepare(TetMesh mesh, const ProgressCallback& progress = {});

} // namespace ptet
