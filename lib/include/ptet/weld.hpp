// Points that stand more than once in a mesh, made one.
#pragma once

#include "ptet/mesh.hpp"

#include <cstdint>
#include <string>

namespace ptet {

/// Makes one point of all that have the same position and the same values in every point array, bit for bit: where the
/// parts of a mesh were written one by one, the points that they share stand once in each of them, and without that the
/// seams are boundaries. The first of such points stays; all that stay keep their order, and so do the tets and their
/// corners. Points of one place with different values stay apart, and so do those of which one tet has two.
///
/// Returns how many points went. A mesh whose arrays have not one row for each vertex, or whose tets name vertices that
/// there are not, or with more vertices than ids, is left as it is. Cost: a sort of the points.
std::uint64_t weld_points(TetMesh& mesh);

/// A sentence for who should know: "3 points were welded with others of the same place and values".
[[nodiscard]] std::string welding_note(std::uint64_t points);

} // namespace ptet
