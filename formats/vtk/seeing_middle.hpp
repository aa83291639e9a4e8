// A point in the middle of a cell that sees its surface from within.
#pragma once

#include "formats/vtk/mean_point.hpp"
#include "mesh/predicates.hpp"

#include <array>
#include <functional>
#include <vector>

namespace ptet::vtkio {

using Quadrilateral = std::array<VertexId, 4>;

/// The faces of a cell, outward oriented. A quadrilateral may be cut by either diagonal.
struct CellSurface {
  std::vector<Face> triangles;
  std::vector<Quadrilateral> quadrilaterals;
};

/// The mean of the points; where that does not see all of the surface from within the middle of the surface, or else a
/// point that sees all of it, if there is one; of these that which sees most. A quadrilateral is seen where it is by
/// one of its diagonals. `points`: all of the surface's, ascending. `look` may be called, and throw.
[[nodiscard]] MeanPoint seeing_middle(const std::vector<VertexId>& points, const CellSurface& surface,
                                      const TetMesh& positions, const std::function<void()>& look);

} // namespace ptet::vtkio
