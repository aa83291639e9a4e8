// What the comparison of whole tets and that of samples share: blocks of work, and sums of differences.
#pragma once

#include "error/mesh_comparison.hpp"
#include "mesh/vec3.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include <tbb/parallel_for.h>

namespace ptet::comparison {

/// Items of one partial sum: fixed, so that sums do not depend on the number of threads.
inline constexpr std::size_t kBlock = 256;
inline constexpr std::size_t kBlocksBetweenReports = 64;

/// Calls `work(block, begin, end)` for all blocks of `count` items, in parallel, with reports in between.
template <class Work>
void for_each_block(std::size_t count, const char* stage, const ProgressCallback& progress, Work&& work) {
  const std::size_t blocks = (count + kBlock - 1) / kBlock;
  for (std::size_t first = 0; first < blocks; first += kBlocksBetweenReports) {
    if (progress && !progress({stage, first * kBlock, count})) throw Error(ErrorCode::kCancelled, "cancelled");
    tbb::parallel_for(first, std::min(blocks, first + kBlocksBetweenReports),
                      [&](std::size_t block) { work(block, block * kBlock, std::min(count, (block + 1) * kBlock)); });
  }
}

[[nodiscard]] inline std::size_t block_count(std::size_t count) {
  return (count + kBlock - 1) / kBlock;
}

template <class Mesh>
[[nodiscard]] std::array<Point, 4> corners_of(const Mesh& mesh, std::size_t t) {
  const Tet& tet = mesh.tets[t];
  return {mesh.points[tet[0].index()], mesh.points[tet[1].index()], mesh.points[tet[2].index()],
          mesh.points[tet[3].index()]};
}

[[nodiscard]] inline Point combine(const std::array<Point, 4>& corners, const std::array<double, 4>& weight) {
  using namespace vec;
  Point p = corners[0];
  for (std::size_t i = 1; i < 4; ++i)
    p = p + weight[i] * (corners[i] - corners[0]);
  return p;
}

/// Keeps the greater maximum, and of equal ones the earlier; adds the sums.
inline void add(const FieldDifference& more, FieldDifference& to) {
  if (more.max > to.max) {
    to.max = more.max;
    to.at = more.at;
  }
  to.mean_square += more.mean_square;
}

inline void add(const std::vector<FieldDifference>& more, std::vector<FieldDifference>& to) {
  for (std::size_t f = 0; f < more.size(); ++f)
    add(more[f], to[f]);
}

inline void divide(std::vector<FieldDifference>& sum, double by) {
  for (FieldDifference& field : sum)
    field.mean_square = by > 0 ? field.mean_square / by : 0;
}

} // namespace ptet::comparison
