// Boundary surfaces out: .obj, .ply, .off with coordinates as they are, .stl through OpenMesh.
//
// What is lost: an STL file holds positions as 32-bit floats and shares no vertices between triangles. In the others
// numbers come back bit for bit, of integers those up to 2^53. Fields are not carried.
#pragma once

#include "ptet/mesh.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace ptet {

/// What the numbers of a format made of a surface. Only .stl loses anything; for the others all are 0.
struct SurfaceLoss {
  double largest_move = 0;            ///< of a vertex, mesh units
  double diagonal = 0;                ///< of the bounding box of the vertices that were written, mesh units
  std::uint64_t degenerate_faces = 0; ///< that had an area, and have none as they were written
};

/// Whether the name ends as one that write_surface() takes: .obj, .ply, .stl or .off.
[[nodiscard]] bool is_surface_name(const std::string& path);

/// Writes `faces` (triangles of ids of `mesh`, outward oriented) to `path`; the format goes by the ending.
///
/// Only the vertices that faces use are written, in the order of their ids. Where the surface is not a manifold (an
/// edge of more than two faces, fans that meet in one vertex) a vertex is written once for each fan: no face is lost
/// and the shape is the same. The file is written beside `path`, synced and renamed.
/// Throws Error: kBadArgument (another ending), kBadInput (a face with an id out of range, a repeated vertex or a
/// position that is not finite, or for .stl beyond 32-bit floats), kIo. Nothing is left behind then. Prints nothing.
/// Thread rule: one call at a time in a process (OpenMesh's IO manager and error stream are global).
SurfaceLoss write_surface(const std::string& path, const TetMesh& mesh, std::span<const std::array<VertexId, 3>> faces);

} // namespace ptet
