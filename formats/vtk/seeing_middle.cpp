#include "formats/vtk/seeing_middle.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace ptet::vtkio {
namespace {

/// How many triangles are not seen from within, as flat ones are not. Of a quadrilateral by the better diagonal.
std::size_t count_unseen(const MeanPoint& from, const CellSurface& surface, const TetMesh& mesh) {
  const Point at = position_of(from, mesh.positions);
  const auto is_unseen = [&](VertexId a, VertexId b, VertexId c) {
    return sure_orientation(at, mesh.position(a), mesh.position(b), mesh.position(c)) > 0 ? 0 : 1;
  };
  int unseen = 0;
  for (const auto& [a, b, c] : surface.triangles)
    unseen += is_unseen(a, b, c);
  for (const auto& [a, b, c, d] : surface.quadrilaterals)
    unseen += std::min(is_unseen(a, b, c) + is_unseen(a, c, d), is_unseen(b, c, d) + is_unseen(b, d, a));
  return static_cast<std::size_t>(unseen);
}

/// Of the middle of the surface, one a point: where one end of a cell has many more points than the other their mean
/// may be too near it.
std::vector<double> weights_by_area(const std::vector<VertexId>& points, const CellSurface& surface,
                                    const TetMesh& mesh) {
  using namespace vec;
  std::vector<double> weights(points.size(), 0);
  double whole = 0;
  const auto add = [&](VertexId a, VertexId b, VertexId c) {
    const Point at = mesh.position(a);
    const double area = norm(cross(mesh.position(b) - at, mesh.position(c) - at));
    for (const VertexId v : {a, b, c}) {
      const auto of_point = std::lower_bound(points.begin(), points.end(), v) - points.begin();
      weights[static_cast<std::size_t>(of_point)] += area;
      whole += area;
    }
  };
  for (const auto& [a, b, c] : surface.triangles)
    add(a, b, c);
  for (const auto& [a, b, c, d] : surface.quadrilaterals) {
    add(a, b, c);
    add(a, c, d);
  }
  for (double& weight : weights)
    weight /= whole;
  return weights;
}

/// A game of two: one names a point of the polyhedron, the other a face, and the first gets how far the point lies
/// within the plane of that. The mean of what is best to name is a point as far within the plane
/// that is nearest as any: it sees the whole surface, where any does. Played with regret matching, as often as is
/// worth it for a cell that is odd anyway.
/// Source: Tammelin, Solving Large Imperfect Information Games Using CFR+, 2014.
class SeeingPoint {
public:
  /// Cells with more points times faces are left as they are.
  static constexpr std::size_t kMost = std::size_t{1} << 14;

  SeeingPoint(const std::vector<VertexId>& points, const CellSurface& surface, const TetMesh& mesh)
      : points_(points.size()) {
    using namespace vec;
    const auto add = [&](const Point& on, const Vec3& normal) {
      const auto outward = direction_of(normal);
      if (!outward) return; // no plane
      ++faces_;
      for (const VertexId v : points)
        within_.push_back(dot(*outward, on - mesh.position(v)));
    };
    for (const auto& [a, b, c] : surface.triangles) {
      const Point at = mesh.position(a);
      add(at, cross(mesh.position(b) - at, mesh.position(c) - at));
    }
    for (const auto& [a, b, c, d] : surface.quadrilaterals) {
      const Point p = mesh.position(a), q = mesh.position(b), r = mesh.position(c), s = mesh.position(d);
      add(0.25 * ((p + q) + (r + s)), cross(r - p, s - q)); // in the middle, if it is warped
    }
  }

  /// Calls `is_good(weights)`, one a point, until it is or there is no more to be had; some milliseconds for a cell of
  /// twenty points.
  template <class IsGood>
  void play(IsGood&& is_good) const {
    constexpr int kFirstLook = 32, kRounds = 1024;
    Player chooser(points_), opponent(faces_);
    std::vector<double> sum(points_), gains(points_), losses(faces_);
    for (int round = 1, look_at = kFirstLook; round <= kRounds; ++round) {
      for (std::size_t i = 0; i < points_; ++i) {
        gains[i] = 0;
        for (std::size_t f = 0; f < faces_; ++f)
          gains[i] += opponent.part[f] * within_[f * points_ + i];
      }
      chooser.learn(gains);
      for (std::size_t f = 0; f < faces_; ++f) {
        losses[f] = 0;
        for (std::size_t i = 0; i < points_; ++i)
          losses[f] -= chooser.part[i] * within_[f * points_ + i];
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

  std::size_t points_, faces_ = 0;
  std::vector<double> within_; ///< face x point
};

} // namespace

MeanPoint seeing_middle(const std::vector<VertexId>& points, const CellSurface& surface, const TetMesh& positions,
                        const std::function<void()>& look) {
  MeanPoint middle{points, std::vector<double>(points.size(), 1 / static_cast<double>(points.size()))};
  std::size_t unseen = count_unseen(middle, surface, positions);
  const auto try_weights = [&](std::vector<double> weights) {
    if (!std::all_of(weights.begin(), weights.end(), [](double w) { return std::isfinite(w); })) return false;
    MeanPoint other{points, std::move(weights)};
    if (const std::size_t unseen_then = count_unseen(other, surface, positions); unseen_then < unseen) {
      unseen = unseen_then;
      middle = std::move(other);
    }
    return unseen == 0;
  };
  if (unseen != 0) try_weights(weights_by_area(points, surface, positions));
  if (unseen != 0 && points.size() * (surface.triangles.size() + surface.quadrilaterals.size()) <= SeeingPoint::kMost) {
    look();
    SeeingPoint(points, surface, positions).play(try_weights);
  }
  return middle;
}

} // namespace ptet::vtkio
