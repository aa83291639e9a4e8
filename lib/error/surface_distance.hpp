// Distances to a surface of triangles, and certified bounds of how far triangles get away from it: the one-sided
// Hausdorff distance between two surfaces.
//
//       v0 ---- v1        the distance to one triangle c is convex: over a (sub-)triangle it is greatest at a vertex.
//         \ T  /          upper = least, over a few c near by, of max_i d(v_i, c);   lower = d(point) at points of T
//    -----c\--/-----      where the two differ too much, T is cut in two, or cut along the edges of c when the part
//           v2            over c is settled by c (flat patches of many triangles)
//
// Source: the bounds are those of Guthe, Borodin, Klein, Fast and Accurate Hausdorff Distance Calculation between
// Meshes, 2005; the closest point of a triangle is Ericson's (closest_point.hpp).
#pragma once

#include "mesh/box_tree.hpp"
#include "mesh/predicates.hpp"
#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ptet {

/// Bounds of a greatest distance: `lower` is attained at some point that was looked at, nothing exceeds `upper` (both
/// to rounding: some 1e-14 of the sizes of the surface and the triangle, wherever they lie).
struct DistanceBounds {
  double lower = 0;
  double upper = 0;
};

using Triangle = std::array<Point, 3>;
[[nodiscard]] std::vector<Triangle> triangles_of(std::span<const Point> points, std::span<const Face> faces);

/// An immutable set of triangles in a tree of bounding boxes. Triangles may be degenerate and need not hang together.
class TriangleSurface {
public:
  /// Coordinates must be finite. Throws Error(kLimit) for 2^32 - 1 triangles or more. Cost: n log n.
  explicit TriangleSurface(const std::vector<Triangle>& triangles);

  [[nodiscard]] std::size_t size() const { return triangles_.size(); }
  /// In the order they were given.
  [[nodiscard]] Triangle triangle(std::uint32_t index) const;

  /// The squared distance from p to the surface; infinity when there is no triangle.
  /// `nearest`, when not null: in, a triangle believed near (out of range: none), which only speeds the search; out,
  /// a triangle that is nearest. Thread rule: const. Cost: about 1 us for a point near a surface of 10^5 triangles.
  [[nodiscard]] double distance_sq(const Point& p, std::uint32_t* nearest = nullptr) const;

  /// Bounds of the greatest distance from a point of `triangle` to the surface: refined until
  /// upper <= max(lower * (1 + relative), floor). What is certainly within `floor` is not looked at further, so then
  /// `lower` may be anything below. After `most_cuts` (a floor of 0 over a surface that is nearly the same, needles)
  /// the bounds are returned as they are, true but wide. Infinite when there is no triangle.
  /// `relative`, `floor`: >= 0, the latter a distance. Thread rule: const.
  [[nodiscard]] DistanceBounds farthest(const Triangle& triangle, double relative, double floor,
                                        std::size_t most_cuts = 100'000) const;

private:
  class Subdivision;
  /// Lowers `best_sq` and `slot` to the nearest triangle there is.
  void search(const Point& p, double& best_sq, std::uint32_t& slot) const;

  Point origin_; ///< is taken off all coordinates
  BoxTree tree_;
  std::vector<Triangle> triangles_;    ///< in the tree's order: by slot
  std::vector<std::uint32_t> slot_of_; ///< by index
  double extent_ = 0;                  ///< the largest coordinate, less the origin
};

/// Bounds of the greatest distance from a point of the `triangles` to `surface`: upper <= max(lower * (1 + relative),
/// floor), but for the limit of `farthest`. Zero for no triangles.
/// In parallel; same result on any number of threads. Throws Error(kCancelled).
[[nodiscard]] DistanceBounds one_sided_hausdorff(std::span<const Triangle> triangles, const TriangleSurface& surface,
                                                 double relative, double floor, const ProgressCallback& progress = {});

} // namespace ptet
