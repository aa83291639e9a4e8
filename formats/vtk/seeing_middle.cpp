#include "formats/vtk/seeing_middle.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace ptet::vtkio {
namespace {

/// Of the middle of the surface, one a point: where one end of a cell has many more points than the other their mean
/// may be too near it.
std::vector<double> weights_by_area(const std::vector<VertexId>& points, const std::vector<Face>& triangles,
                                    const TetMesh& mesh) {
  using namespace vec;
  std::vector<double> weights(points.size(), 0);
  double whole = 0;
  for (const auto& [a, b, c] : triangles) {
    const Point at = mesh.position(a);
    const double area = norm(cross(mesh.position(b) - at, mesh.position(c) - at));
    for (const VertexId v : {a, b, c}) {
      const auto of_point = std::lower_bound(points.begin(), points.end(), v) - points.begin();
      weights[static_cast<std::size_t>(of_point)] += area;
      whole += area;
    }
  }
  for (double& weight : weights)
    weight /= whole;
  return weights;
}

/// A game of two: one names a point of the polyhedron, the other a triangle of its surface, and the first gets how far
/// the point lies within the plane of the triangle. The mean of what is best to name is a point as far within the plane
/// that is nearest as any: it sees the whole surface, where any does. Played with regret matching, as often as is
/// worth it for a cell that is odd anyway.
/// Source: Tammelin, Solving Large Imperfect Information Games Using CFR+, 2014.
class SeeingPoint {
public:
  /// Cells with more points times triangles are left as they are.
  static constexpr std::size_t kMost = std::size_t{1} << 14;

  SeeingPoint(const std::vector<VertexId>& points, const std::vector<Face>& triangles, const TetMesh& mesh)
      : points_(points.size()) {
    using namespace vec;
    for (const auto& [a, b, c] : triangles) {
      const Point at = mesh.position(a);
      const auto outward = direction_of(cross(mesh.position(b) - at, mesh.position(c) - at));
      if (!outward) continue; // no plane
      ++triangles_;
      for (const VertexId v : points)
        within_.push_back(dot(*outward, at - mesh.position(v)));
    }
  }

  /// Calls `is_good(weights)`, one a point, until it is or there is no more to be had; some milliseconds for a cell of
  /// twenty points.
  template <class IsGood>
  void play(IsGood&& is_good) const {
    constexpr int kFirstLook = 32, kRounds = 1024;
    Player chooser(points_), opponent(triangles_);
    std::vector<double> sum(points_), gains(points_), losses(triangles_);
    for (int round = 1, look_at = kFirstLook; round <= kRounds; ++round) {
      for (std::size_t i = 0; i < points_; ++i) {
        gains[i] = 0;
        for (std::size_t t = 0; t < triangles_; ++t)
          gains[i] += opponent.part[t] * within_[t * points_ + i];
      }
      chooser.learn(gains);
      for (std::size_t t = 0; t < triangles_; ++t) {
        losses[t] = 0;
        for (std::size_t i = 0; i < points_; ++i)
          losses[t] -= chooser.part[i] * within_[t * points_ + i];
      }
      opponent.learn(losses);
      for (std::size_t i = 0; i < points_; ++i) // later rounds know more
        sum[i] += round * chooser.part[i];
      if (round != look_at) continue;
      look_at *= 2;
      const double whole = std::accumulate(sum.begin(), sum.end(), 0.0);
      std::vector<double> weights = sum;
      for (double& weight : weights)
        weight /= whole;
      if (is_good(std::move(weights))) return;
    }
  }

private:
  /// How often each choice is made, and how much better it would have been so far.
  struct Player {
    explicit Player(std::size_t choices) : part(choices, 1 / static_cast<double>(choices)), regret(choices) {}

    void learn(const std::vector<double>& gains) {
      const double gained = std::inner_product(gains.begin(), gains.end(), part.begin(), 0.0);
      double whole = 0;
      for (std::size_t i = 0; i < regret.size(); ++i) {
        regret[i] = std::max(0.0, regret[i] + gains[i] - gained);
        whole += regret[i];
      }
      if (!(whole > 0)) return;
      for (std::size_t i = 0; i < regret.size(); ++i)
        part[i] = regret[i] / whole;
    }

    std::vector<double> part, regret;
  };

  std::size_t points_, triangles_ = 0;
  std::vector<double> within_; ///< triangle x point
};

} // namespace

std::size_t count_turned(const MeanPoint& mean, const std::vector<Face>& triangles, const TetMesh& mesh) {
  const Point middle = position_of(mean, mesh.positions);
  return static_cast<std::size_t>(std::count_if(triangles.begin(), triangles.end(), [&](const Face& t) {
    return sure_orientation(middle, mesh.position(t[0]), mesh.position(t[1]), mesh.position(t[2])) < 0;
  }));
}

MeanPoint seeing_middle(const std::vector<VertexId>& points, const std::vector<Face>& surface, const TetMesh& positions,
                        const std::function<void()>& look) {
  MeanPoint middle{points, std::vector<double>(points.size(), 1 / static_cast<double>(points.size()))};
  std::size_t turned = count_turned(middle, surface, positions);
  const auto try_weights = [&](std::vector<double> weights) {
    if (!std::all_of(weights.begin(), weights.end(), [](double w) { return std::isfinite(w); })) return false;
    MeanPoint other{points, std::move(weights)};
    if (const std::size_t turned_then = count_turned(other, surface, positions); turned_then < turned) {
      turned = turned_then;
      middle = std::move(other);
    }
    return turned == 0;
  };
  if (turned != 0) try_weights(weights_by_area(points, surface, positions));
  if (turned != 0 && points.size() * surface.size() <= SeeingPoint::kMost) {
    look();
    SeeingPoint(points, surface, positions).play(try_weights);
  }
  return middle;
}

} // namespace ptet::vtkio
