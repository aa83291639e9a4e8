#include "generate/jitter.hpp"
#include "generate/shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace ptet::bench {
namespace {

/// Where the cells are finest, on each axis, and over which width.
constexpr double kFinest = 0.35, kWidth = 0.25;
/// By how much less than elsewhere a cell measures there.
constexpr double kLess = 0.75;
/// In cells; below 1/6 a tet of a cell cannot turn, for the edges of its path, moved, stay a dominant diagonal.
constexpr double kJitter = 0.1;

double stretched(double s) {
  return s - kLess * kWidth * std::sqrt(std::numbers::pi) / 2 *
                 (std::erf((s - kFinest) / kWidth) + std::erf(kFinest / kWidth));
}

/// Monotone from [0, 1] onto itself.
double graded(double s) {
  static const double kWhole = stretched(1);
  return s == 0 || s == 1 ? s : stretched(s) / kWhole;
}

struct Path {
  std::array<std::uint32_t, 3> axes;
  bool even;
};
/// A tet for each way from a cell's first corner to its last along three edges.
constexpr std::array<Path, 6> kPaths{{{{0, 1, 2}, true},
                                      {{1, 2, 0}, true},
                                      {{2, 0, 1}, true},
                                      {{0, 2, 1}, false},
                                      {{1, 0, 2}, false},
                                      {{2, 1, 0}, false}}};

} // namespace

Shape graded_cube(std::uint64_t tets, const ProgressCallback& progress) {
  const auto n = static_cast<std::uint32_t>(std::max(1.0, std::round(std::cbrt(static_cast<double>(tets) / 6))));
  const std::uint32_t row = n + 1, layer = row * row;
  Shape shape;
  shape.points.reserve(std::size_t{layer} * row);
  for (std::uint32_t k = 0; k <= n; ++k)
    for (std::uint32_t j = 0; j <= n; ++j)
      for (std::uint32_t i = 0; i <= n; ++i) {
        const std::array<std::uint32_t, 3> at{i, j, k};
        const Point move = jitter(shape.points.size());
        Point p;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const bool inside = at[axis] > 0 && at[axis] < n;
          p[axis] = graded((at[axis] + (inside ? kJitter * move[axis] : 0)) / n);
        }
        shape.points.push_back(p);
      }

  const std::array<std::uint32_t, 3> step{1, row, layer};
  shape.tets.reserve(std::size_t{6} * n * n * n);
  for (std::uint32_t k = 0; k < n; ++k) {
    tell(progress, "cutting cells into tets", k, n);
    for (std::uint32_t j = 0; j < n; ++j)
      for (std::uint32_t i = 0; i < n; ++i)
        for (const Path& path : kPaths) {
          std::uint32_t v = i + j * row + k * layer;
          Tet tet{VertexId{v}};
          for (std::size_t c = 0; c < 3; ++c)
            tet[c + 1] = VertexId{v += step[path.axes[c]]};
          if (!path.even) std::swap(tet[2], tet[3]);
          shape.tets.push_back(tet);
        }
  }
  return shape;
}

} // namespace ptet::bench
