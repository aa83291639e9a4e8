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

/// Calls `work(part, begin, end)` for all blocks of `count` items, in parallel, each with a Part of its own that begins
/// as a copy of `none`; then `take(part)`, in the order of the blocks. Reports in between. Few parts are there at a
/// time, however many items there are.
template <class Part, class Work, class Take>
void for_each_part(std::size_t count, const char* stage, const ProgressCallback& progress, const Part& none,
                   Work&& work, Take&& take) {
  std::vector<Part> parts;
  for (std::size_t begin = 0; begin < count; begin += kBlock * kBlocksBetweenReports) {
    const std::size_t end = std::min(count, begin + kBlock * kBlocksBetweenReports);
    if (progress && !progress({stage, begin, count})) throw Error(ErrorCode::kCancelled, "cancelled");
    parts.assign((end - begin + kBlock - 1) / kBlock, none);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t block) {
      const std::size_t from = begin + block * kBlock;
      work(parts[block], from, std::min(end, from + kBlock));
    });
    for (const Part& part : parts)
      take(part);
  }
}

/// The same for work that leaves no part: `work(begin, end)`.
template <class Work>
void for_each_block(std::size_t count, const char* stage, const ProgressCallback& progress, Work&& work) {
  for_each_part(
      count, stage, progress, char{}, [&](char&, std::size_t begin, std::size_t end) { work(begin, end); },
      [](char) {});
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
