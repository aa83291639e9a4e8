// A cell into tetrahedra, conformingly and without new points: what a cell puts on a face depends on the order of that
// face's points alone, so that two cells that share a face agree whatever their kinds.
//
// A linear cell is coned from its first point over the faces without that point; a quadrilateral is split by the
// diagonal at its first point. (On the faces with the apex the cone leaves just that diagonal: the apex is the first
// there too.) A quadratic tetrahedron is split at its mid-edge points: each face into 4, the inner octahedron, whose
// diagonal no neighbour sees, at its shortest diagonal. Other quadratic cells lose their corners at the mid-edge
// points, and what is left is coned like a linear cell; those with points in their quadrilaterals are eight linear
// cells. All points become vertices; between them values are linear, and edges straight.
//
// VTK's own vtkDataSetTriangleFilter was measured and not taken: it splits each quadratic tetrahedron by the geometry
// of its parametric cell, so that neighbours disagree (2,232 unmatched inner faces in a box of 743 such cells).
//
// Source: Dompierre, Labbe, Vallet, Camarero, How to subdivide pyramids, prisms, and hexahedra into tetrahedra, 8th
// International Meshing Roundtable, 1999.
#pragma once

#include "ptet/mesh.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ptet::vtkio {

/// No cell has more points.
constexpr std::size_t kMaxCellPoints = 27;
using Ranks = std::array<std::uint8_t, kMaxCellPoints>;

struct CellSize {
  std::size_t points;
  std::size_t most_tets; ///< that it gives
};
/// Of a cell of this VTK type if it is a tetrahedron or a kind that split_cell() takes; zeros: it is neither.
[[nodiscard]] CellSize cell_size(int vtk_cell_type);

/// The type of the same cell with the same points under another name: of Lagrange's cells of orders 1 and 2. Other
/// types are returned as they are.
[[nodiscard]] int plain_type(int vtk_cell_type, std::uint64_t points);
/// Puts the points of a cell in the order that its plain_type() has them in: VTK numbers all alike but wedges of six.
void to_plain_order(int vtk_cell_type, std::span<VertexId> points);

/// Whether such a cell has quadrilaterals to be cut, so that an order of its points has a say in how it is split.
[[nodiscard]] bool has_diagonals(int vtk_cell_type);

/// Appends the tets of one cell that is no tetrahedron. A tet with a repeated point, which a degenerate cell gives, is
/// left out. Tets are positively oriented where the cell is.
/// `points`: cell_size().points ids of rows of `positions`, in VTK's order. `ranks`: of the points of a cell that
/// has_diagonals(), by an order that is the same for all cells; those of equal ids, and no others, are equal.
void split_cell(int vtk_cell_type, std::span<const VertexId> points, const Ranks& ranks, const TetMesh& positions,
                std::vector<Tet>& tets);

/// Appends a tet, but one with a repeated point.
void append_if_proper(const Tet& tet, std::vector<Tet>& tets);

/// Appends the four tets of an octahedron, split at its shortest diagonal, the first of several: corners 0 and 1, 2 and
/// 3, 4 and 5 are opposite; (0, 1, 2, 4) is positively oriented where the octahedron is.
void split_octahedron(const std::array<VertexId, 6>& corners, const TetMesh& positions, std::vector<Tet>& tets);

} // namespace ptet::vtkio
