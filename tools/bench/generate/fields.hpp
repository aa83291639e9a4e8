// Fields that are known at every point, and detail for those that are given.
#pragma once

#include "generate/shapes.hpp"
#include "ptet/mesh.hpp"

namespace ptet::bench {

/// The shape as a mesh with three fields, all of `type` (float32 or float64), like the positions:
///
///   smooth     sin 3x cos 2y + sin(2z + x) / 2
///   layer      tanh((|p - c| - r) / w): -1 in a ball, 1 outside, all between in a shell of some 4 w
///   velocity   (sin 4z + cos 3y, sin 4x + cos 3z, sin 4y + cos 3x): an ABC flow
///
/// c = (0.35, 0.35, 0.35), r = 0.3, w = 0.01. The values are those at the positions as they are stored.
/// Throws Error: kLimit when a tet is turned or flat once its positions are stored; kCancelled.
[[nodiscard]] TetMesh with_known_fields(Shape shape, ScalarType type, const ProgressCallback& progress = {});

/// Adds waves to every floating-point array, so that a refinement is not linear where the mesh was: `amplitude` times
/// the range of each component, some 40 waves to the diagonal.
void add_detail(TetMesh& mesh, double amplitude, const ProgressCallback& progress = {});

} // namespace ptet::bench
