// Cells of Lagrange's kinds of the third order and more, as the finite elements of MFEM, NGSolve or FEniCS have them:
// the linear cells between the points of their lattices. Every point becomes a vertex; between them values are linear,
// and edges straight, as for the quadratic cells (split_cell.hpp). The lattices of a face are the same from either
// side.
//
//   order 3   o---o---o---o      a tetrahedron gives upright tetrahedra, turned ones and octahedra between them,
//              \ / \ / \ /       a hexahedron hexahedra, a wedge wedges
//               o---o---o
//                \ / \ /
//                 o---o
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace ptet::vtkio {

/// Of one kind and order, by the numbers of the cell's points.
struct LagrangeParts {
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<std::array<std::uint32_t, 6>> octahedra; ///< three pairs of opposite corners, see split_octahedron()
  std::vector<std::array<std::uint32_t, 8>> hexahedra; ///< in VTK's order
  std::vector<std::array<std::uint32_t, 6>> wedges;    ///< in VTK's order
};

/// Of a tetrahedron, a hexahedron or a wedge of Lagrange's; 0 for other types.
[[nodiscard]] std::uint64_t lagrange_points(int vtk_cell_type, std::uint64_t order);

class LagrangeCells {
public:
  /// The parts of a cell of this VTK type with so many points, if it is a tetrahedron, a hexahedron or a wedge of
  /// Lagrange's of one order from 3 to 64 along all its edges; else nullptr. Valid as long as the object.
  [[nodiscard]] const LagrangeParts* parts_of(int vtk_cell_type, std::uint64_t points);

private:
  std::map<std::pair<int, std::uint64_t>, LagrangeParts> known_;
};

} // namespace ptet::vtkio
