// Points between others, with the mean of what these have.
#pragma once

#include "ptet/mesh.hpp"

#include <vector>

namespace ptet::vtkio {

/// The mean of some rows: weight[i] times row points[i], together.
struct MeanPoint {
  std::vector<VertexId> points; ///< each once; at least one
  std::vector<double> weights;  ///< at least 0; their sum is 1
};

/// Where that is, in the type of the positions.
[[nodiscard]] Point position_of(const MeanPoint& mean, const PointArray& positions);

/// Appends a row: the mean of others, rounded to the type of the array, and between the least and the greatest of them.
/// Of values that are not finite it is not either, but NaN is where there are both infinities or NaN.
void append_mean(PointArray& array, const MeanPoint& mean);

} // namespace ptet::vtkio
