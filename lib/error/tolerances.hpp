// What counts as rounding where errors are measured. Who states errors and who checks them must agree on it.
#pragma once

#include <cmath>

namespace ptet {

/// A difference of field values up to this part of the values that it is the difference of is rounding. These are
/// relative to a corner of the tet looked at: no common offset is in them, and no value elsewhere in the mesh. So is
/// the error on a part of an original tet up to this part of the differences at that tet's corners, and, where meshes
/// are compared, of those at the corners of both tets.
inline constexpr double kValueRounding = 1e-13;
/// Barycentric coordinates in a tet with the edges a, b, c from corner 0 are off by up to this, times |a| |b| |c| /
/// det, times themselves and the distance to corner 0 in lengths of the edge: so much of a difference may be rounding,
/// too. Where errors are measured such a difference is taken again with twice the digits, where they are foreseen it is
/// none.
inline constexpr double kShapeRounding = 0x1p-49;
/// Distances up to this fraction of the mesh's diagonal are rounding.
inline constexpr double kDistanceRounding = 1e-12;
/// What is left of a tet's volume, or of those around a vertex, is nothing up to this part of it.
inline constexpr double kVolumeRounding = 1e-12;
/// What the volume around a vertex has changed by; 0 where that may be rounding.
[[nodiscard]] inline double volume_change(double before, double after) {
  const double change = after - before;
  return std::abs(change) > kVolumeRounding * before ? change : 0;
}
/// A measured error may be off by this fraction of it.
inline constexpr double kErrorSlack = 1e-9;

} // namespace ptet
