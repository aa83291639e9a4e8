// Boundary surfaces out, through OpenMesh: .obj, .ply, .stl, .off.
//
// What is lost: OpenMesh's writers hold positions as 32-bit floats, so that double positions are rounded to 24 bits in
// every format (.obj and .off then hold enough decimal digits to give each float back, .ply and .stl are binary). STL
// shares no vertices between triangles. Fields are not carried.
#pragma once

#include "ptet/mesh.hpp"

#include <array>
#include <span>
#include <string>

namespace ptet {

/// Writes `faces` (triangles of ids of `mesh`, outward oriented) to `path`; the format goes by the ending.
///
/// Only the vertices that faces use are written, in the order of their ids. Where the surface is not a manifold (an
/// edge of more than two faces, fans that meet in one vertex) a vertex is written once for each fan: no face is lost
/// and the shape is the same. The file is written beside `path`, synced and renamed.
/// Throws Error: kBadArgument (another ending), kBadInput (a face with an id out of range, a repeated vertex or a
/// position beyond 32-bit floats), kIo. Nothing is left behind then. Prints nothing.
/// Thread rule: one call at a time in a process (OpenMesh's IO manager and error stream are global).
void write_surface(const std::string& path, const TetMesh& mesh, std::span<const std::array<VertexId, 3>> faces);

} // namespace ptet
