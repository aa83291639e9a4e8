// A slow half-edge collapse simplifier that is plain enough to be believed: sets of sets, no shared code with the
// builder. For meshes of up to a few thousand tets.
//
// Every collapse keeps the link condition with the boundary closed by the dummy vertex, every modified tet positively
// oriented (exact), boundary vertices on edges of the boundary, and every vertex that is left in some tet.
// The boundary may meet itself: that is geometry, and not looked at here.
#pragma once

#include "ptet/mesh.hpp"
#include "record/stream.hpp"

namespace ptet::test {

struct NaiveOptions {
  unsigned seed = 1;
  std::size_t target_vertices = 0; ///< 0: until nothing can be collapsed any more
  double round_fraction = 0.15;    ///< of the vertices that are left, at most, in each round
};

/// The governing fields are the floating-point arrays of the mesh. Errors: the field at removed vertices, and the
/// distance of removed boundary vertices, each held by the version it was handed down to.
[[nodiscard]] RecordStream simplify_naively(const TetMesh& mesh, const NaiveOptions& options = {});

} // namespace ptet::test
