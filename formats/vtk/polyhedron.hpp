// A polyhedron into pyramids and tetrahedra around a new point in its middle: over each quadrilateral a pyramid, over
// each other face the tetrahedra on the triangles that it is cut into. Two polyhedra that share a face cut it alike,
// since that depends on the positions of its corners alone.
//
// VTK's own vtkPolyhedron::Triangulate was not taken: it makes Delaunay tetrahedra of each cell by itself, so that
// neighbours disagree.
#pragma once

#include "formats/vtk/seeing_middle.hpp"
#include "mesh/predicates.hpp"
#include "ptet/mesh.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace ptet::vtkio {

/// The faces of the polyhedra of a grid, in the order of its cells. No more than 2^32 points.
struct PolyhedronFaces {
  std::vector<std::uint64_t> face_begin;   ///< by cell, and the end; none at all where the grid has no polyhedra
  std::vector<std::uint64_t> corner_begin; ///< by face, and the end
  std::vector<std::uint32_t> corners;      ///< rows of the grid's points
};

using Polygon = std::vector<VertexId>;

/// Faces with more corners are not cut.
constexpr std::size_t kMostCornersOfFace = 256;

/// What stands around a polyhedron's middle.
struct SplitPolyhedron {
  MeanPoint middle;
  CellSurface surface;
};

/// Splits the polyhedron with these faces, which may be oriented at will and are so oriented that their edges match.
/// The middle is the mean of the points, or where that does not see all faces from within the middle of the surface, or
/// else a point that does, if there is one.
/// Returns false, and leaves `to` unspecified, where the faces do not close: an edge is not on two of them.
/// Cost: the cube of a face's number of corners, at most kMostCornersOfFace.
/// `look` is called now and then, and may throw.
[[nodiscard]] bool split_polyhedron(std::vector<Polygon>& faces, const TetMesh& positions,
                                    const std::function<void()>& look, SplitPolyhedron& to);

} // namespace ptet::vtkio
