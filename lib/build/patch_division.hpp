// Divides a flat polygon among the triangles of a surface patch so that no part is further from its triangle than the
// polygon's farthest point is from the patch, or hardly so.
//
//    polygon         two targets           parts
//    +---------+        /|\              +----+----+
//    |         |       / | \             | a  : b  |     a -> f, b -> g
//    +---------+      / f|g \            +----+----+
//
// The distance to one triangle is convex, so over a convex part it is greatest at a corner: what is said of a part is
// exact, and any division gives an upper bound on the one-sided Hausdorff distance to the patch. A part that is too far
// from every single target is cut where two of them are equally near: in the plane through their common edge, by
// choice, which divides a flat patch exactly; else where the distances at the corners say; else in half.
//
// Source: Cignoni, Rocchini, Scopigno, Metro: measuring error on simplified surfaces, 1998 (one-sided distance); Guthe,
// Borodin, Klein, Fast and accurate Hausdorff distance calculation between meshes, 2005 (bounds per triangle).
#pragma once

#include "build/working_complex.hpp"

#include <array>
#include <span>
#include <vector>

namespace ptet::build {

inline constexpr std::size_t kMaxPartCorners = 8;

/// Convex polygon in a base triangle, counterclockwise. A corner (u, v) is x0 + u (x1 - x0) + v (x2 - x0).
struct Part {
  using Corner = std::array<double, 2>;
  std::uint32_t count = 0;
  std::array<Corner, kMaxPartCorners> corner{};

  [[nodiscard]] static Part whole() { return {3, {{{0, 0}, {1, 0}, {0, 1}}}}; }
  [[nodiscard]] bool is_whole() const;
  /// In units of (u, v): 1/2 for the whole triangle.
  [[nodiscard]] double area() const;
};

/// Merges parts of one base triangle while the union of two is convex and has no more than kMaxPartCorners corners.
/// Covers what was covered, but for rounding.
void merge_parts(std::vector<Part>& parts);

/// One triangle of the patch; ids tell which triangles share an edge.
struct PatchTriangle {
  std::array<Vertex, 3> v;
  std::array<Point, 3> x;
  double offset = 0; ///< is added to every distance to it; >= 0
};

class PatchDivision {
public:
  /// `rounding`: a distance below which all points are the same.
  explicit PatchDivision(double rounding) : rounding_(rounding) {}

  /// Forgets everything. The targets must stay where they are.
  void begin(std::span<const PatchTriangle> targets);

  /// Row of the distances of a point to all targets, for the parts that have a corner there.
  [[nodiscard]] std::uint32_t add_point(const Point& p);
  /// No division can bring the error of what has corners at the points added so far below this.
  [[nodiscard]] double lower_bound() const { return lower_bound_; }

  struct Placed {
    Part part;
    std::uint32_t target;
  };
  /// Divides `part` of the triangle `base` so far as it takes to bring the error below `enough` or close to the lower
  /// bound, or to `most_parts`; appends to `placed`. Returns the largest distance of a part to its target, offset
  /// included. `rows`: one for each corner.
  double divide(const std::array<Point, 3>& base, const Part& part, std::span<const std::uint32_t> rows, double enough,
                std::size_t most_parts, std::vector<Placed>& placed);
  /// The largest distance of a part of the triangle `base` to a target.
  [[nodiscard]] double distance(const std::array<Point, 3>& base, const Part& part, std::uint32_t target) const;

private:
  struct Polygon {
    Part part;
    std::array<std::uint32_t, kMaxPartCorners> row{};
  };
  using Signs = std::array<double, kMaxPartCorners>;

  [[nodiscard]] Point at(const Part::Corner& c) const;
  [[nodiscard]] double value(std::uint32_t row, std::size_t target) const {
    return distances_[row * targets_.size() + target];
  }
  [[nodiscard]] std::uint32_t nearest(std::uint32_t row) const;
  void cut(const Polygon& whole, std::uint32_t f, std::uint32_t g, std::uint32_t worst, Polygon& a, Polygon& b);
  bool cut_along_plane(const Polygon& whole, const Point& origin, const Point& normal, Polygon& a, Polygon& b);
  bool cut_where_signs_change(const Polygon& whole, const Signs& signs, double tolerance, Polygon& a, Polygon& b);
  void cut_in_half(const Polygon& whole, Polygon& a, Polygon& b);

  double rounding_;
  std::span<const PatchTriangle> targets_;
  std::vector<double> distances_;      ///< row by row
  std::vector<std::uint32_t> nearest_; ///< by row
  double lower_bound_ = 0;
  std::array<Point, 3> base_{};
  std::vector<Polygon> stack_;
};

} // namespace ptet::build
