// A point in the middle of a cell that sees its surface from within.
#pragma once

#include "formats/vtk/mean_point.hpp"
#include "mesh/predicates.hpp"

#include <cstddef>
#include <functional>
#include <vector>

namespace ptet::vtkio {

/// How many triangles, outward oriented, are seen from behind.
[[nodiscard]] std::size_t count_turned(const MeanPoint& from, const std::vector<Face>& triangles,
                                       const TetMesh& positions);

/// The mean of the points; where that sees some of the surface from behind the middle of the surface, or else a point
/// that sees all of it, if there is one; of these that which sees most.
/// `points`: all of the surface's, ascending. `look` may be called, and throw.
[[nodiscard]] MeanPoint seeing_middle(const std::vector<VertexId>& points, const std::vector<Face>& surface,
                                      const TetMesh& positions, const std::function<void()>& look);

} // namespace ptet::vtkio
