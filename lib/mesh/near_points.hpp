// Points that lie near to one another: a tree over them.
#pragma once

#include "mesh/box_tree.hpp"
#include "mesh/vec3.hpp"

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace ptet {

class NearPoints {
public:
  /// Finite points, fewer than 2^32 - 1. Cost: n log n.
  explicit NearPoints(std::vector<Point> points) : points_(std::move(points)), tree_(boxes_of(points_)) {}

  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(points_.size()); }

  /// How far a point j > i is away that is no farther than `distance` and that `takes(j, d)` takes, if there is one.
  /// Thread rule: const.
  template <class Takes>
  [[nodiscard]] std::optional<double> any_after(std::uint32_t i, double distance, Takes&& takes) const {
    std::optional<double> found;
    const BoundingBox near = around(i, distance);
    tree_.each_where([&](const BoundingBox& box) { return !found && box.meets(near); }, i + 1,
                     [&](std::uint32_t j) {
                       const double away = distance_between(i, j);
                       if (away <= distance && takes(j, away)) found = away;
                     });
    return found;
  }

private:
  [[nodiscard]] double distance_between(std::uint32_t i, std::uint32_t j) const {
    using namespace vec;
    return norm(points_[i] - points_[j]);
  }
  [[nodiscard]] BoundingBox around(std::uint32_t i, double distance) const {
    BoundingBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low[axis] = points_[i][axis] - distance;
      box.high[axis] = points_[i][axis] + distance;
    }
    return box;
  }
  static std::vector<BoundingBox> boxes_of(const std::vector<Point>& points) {
    std::vector<BoundingBox> boxes;
    boxes.reserve(points.size());
    for (const Point& p : points)
      boxes.push_back({p, p});
    return boxes;
  }

  std::vector<Point> points_;
  BoxTree tree_;
};

} // namespace ptet
