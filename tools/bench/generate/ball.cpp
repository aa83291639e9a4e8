// Cutting a body-centred lattice, step by step:
//
//   values   at lattice vertices: the distance to the surface, > 0 in the domain
//   snap     a vertex beside the place where an edge goes through the surface moves there; its value is 0
//   cut      tets with vertices on both sides keep their part inside:
//
//            + 1     tet          one inside
//            + 2 0   pyramid      quadrilateral on the face of the vertex outside
//            + 2     prism        between two that are inside and the four places where edges leave
//            + 3     prism        between the three that are inside and the places where their edges leave
#include "generate/jitter.hpp"
#include "generate/shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <unordered_map>
#include <utility>

namespace ptet::bench {
namespace {

struct Hole {
  Point centre;
  double radius;
};
/// Apart from one another and from the ball's surface by 0.18 and more.
constexpr std::array<Hole, kMostHoles> kHoles{{{{0.45, 0, 0}, 0.25},
                                               {{-0.3, 0.4, 0.1}, 0.2},
                                               {{-0.25, -0.4, -0.2}, 0.22},
                                               {{0.1, 0.1, -0.6}, 0.18},
                                               {{0, 0.05, 0.6}, 0.2}}};
/// Edges of the lattice from one cell's corner to the next's, and from corners to centres, snap over so much of their
/// length: Labelle and Shewchuk, table 1.
constexpr double kSnapLong = 0.2499, kSnapShort = 0.4118;
/// In cells.
constexpr double kJitter = 0.05;
/// Cells that a hole measures across, at least.
constexpr double kCellsAcross = 4;

double length(const Point& p) {
  return std::hypot(p[0], p[1], p[2]);
}

Point between(const Point& a, const Point& b, double t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

class Stuffing {
public:
  Stuffing(std::uint64_t tets, std::uint32_t holes, const ProgressCallback& progress)
      : holes_(holes), progress_(progress) {
    double volume = 1, narrowest = 1;
    for (std::uint32_t h = 0; h < holes; ++h) {
      volume -= std::pow(kHoles[h].radius, 3);
      narrowest = std::min(narrowest, kHoles[h].radius);
    }
    volume *= 4 * std::numbers::pi / 3;
    cell_ = std::cbrt(12 * volume / static_cast<double>(std::max<std::uint64_t>(tets, 1)));
    if (2 * narrowest / cell_ < kCellsAcross) {
      const double least = 12 * volume / std::pow(2 * narrowest / kCellsAcross, 3);
      throw Error(ErrorCode::kBadArgument,
                  "a ball with " + std::to_string(holes) + " holes takes at least " +
                      std::to_string(static_cast<std::uint64_t>(std::ceil(least / 100) * 100)) + " tets");
    }
    // A cell on each side holds nothing of the ball.
    cells_ = static_cast<std::uint32_t>(std::ceil(2 / cell_)) + 2;
    row_ = cells_ + 1;
    origin_ = -cell_ * cells_ / 2;
    corner_count_ = row_ * row_ * row_;
    value_.resize(corner_count_ + cells_ * cells_ * cells_);
    vertex_of_.assign(value_.size(), kNone);
    shape_.tets.reserve(static_cast<std::size_t>(static_cast<double>(tets) * 1.1) + 1000);
  }

  Shape run() {
    evaluate();
    snap();
    cut();
    return std::move(shape_);
  }

private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  using Node = std::uint32_t; ///< of the lattice: the corners of cells, then their centres

  [[nodiscard]] Node corner(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    return i + row_ * (j + row_ * k);
  }
  [[nodiscard]] Node centre(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    return corner_count_ + i + cells_ * (j + cells_ * k);
  }
  [[nodiscard]] bool is_corner(Node n) const { return n < corner_count_; }
  [[nodiscard]] std::array<std::uint32_t, 3> place_of(Node n) const {
    const std::uint32_t row = is_corner(n) ? row_ : cells_;
    const std::uint32_t rest = is_corner(n) ? n : n - corner_count_;
    return {rest % row, rest / row % row, rest / row / row};
  }
  [[nodiscard]] Point unsnapped(Node n) const {
    const auto place = place_of(n);
    const Point move = jitter(n);
    Point p;
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] = origin_ + cell_ * (place[axis] + (is_corner(n) ? 0 : 0.5) + kJitter * move[axis]);
    return p;
  }
  [[nodiscard]] Point position(Node n) const {
    const auto found = snapped_.find(n);
    return found == snapped_.end() ? unsnapped(n) : found->second;
  }

  [[nodiscard]] double distance(const Point& p) const {
    double least = 1 - length(p);
    for (std::uint32_t h = 0; h < holes_; ++h) {
      const Point& c = kHoles[h].centre;
      least = std::min(least, length({p[0] - c[0], p[1] - c[1], p[2] - c[2]}) - kHoles[h].radius);
    }
    return least;
  }

  void evaluate() {
    for (Node n = 0; n < value_.size(); ++n) {
      if (n % 65536 == 0) tell(progress_, "measuring the lattice", n, value_.size());
      value_[n] = static_cast<float>(distance(unsnapped(n)));
    }
  }

  /// Where the surface crosses a b, as a fraction of the way; the ends are on different sides.
  [[nodiscard]] double crossing(const Point& a, const Point& b) const {
    double low = 0, high = 1;
    const bool inside = distance(a) > 0;
    constexpr int kHalvings = 40;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = (low + high) / 2;
      ((distance(between(a, b, middle)) > 0) == inside ? low : high) = middle;
    }
    return (low + high) / 2;
  }

  template <class Visit>
  void each_neighbour(Node n, Visit&& visit) const {
    const auto at = place_of(n);
    const std::uint32_t row = is_corner(n) ? row_ : cells_;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        auto to = at;
        to[axis] += static_cast<std::uint32_t>(step); // below 0 it is far beyond the row
        if (to[axis] < row) visit(is_corner(n) ? corner(to[0], to[1], to[2]) : centre(to[0], to[1], to[2]), true);
      }
    for (std::uint32_t c = 0; c < 8; ++c) {
      const std::uint32_t x = c & 1, y = c >> 1 & 1, z = c >> 2;
      if (!is_corner(n)) {
        visit(corner(at[0] + x, at[1] + y, at[2] + z), false);
      } else if (at[0] - x < cells_ && at[1] - y < cells_ && at[2] - z < cells_) {
        visit(centre(at[0] - x, at[1] - y, at[2] - z), false);
      }
    }
  }

  [[nodiscard]] bool are_apart(Node a, Node b) const {
    return (value_[a] > 0 && value_[b] < 0) || (value_[a] < 0 && value_[b] > 0);
  }

  void snap() {
    for (Node n = 0; n < value_.size(); ++n) {
      if (n % 65536 == 0) tell(progress_, "moving vertices to the surface", n, value_.size());
      if (std::abs(value_[n]) > cell_) continue; // no edge is so long
      double nearest = std::numeric_limits<double>::infinity();
      Point to{};
      each_neighbour(n, [&](Node other, bool is_long) {
        if (!are_apart(n, other)) return;
        const Point a = unsnapped(n), b = unsnapped(other);
        const double t = crossing(a, b);
        const Point p = between(a, b, t);
        const double away = length({p[0] - a[0], p[1] - a[1], p[2] - a[2]});
        if (t > (is_long ? kSnapLong : kSnapShort) || away >= nearest) return;
        nearest = away;
        to = p;
      });
      if (!std::isfinite(nearest)) continue;
      snapped_.emplace(n, to);
      value_[n] = 0;
    }
  }

  [[nodiscard]] std::uint32_t vertex(Node n) {
    if (vertex_of_[n] == kNone) {
      vertex_of_[n] = static_cast<std::uint32_t>(shape_.points.size());
      shape_.points.push_back(position(n));
    }
    return vertex_of_[n];
  }
  /// Where the surface crosses the edge a b.
  [[nodiscard]] std::uint32_t cut_vertex(Node a, Node b) {
    const std::uint64_t key = std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    const auto [found, is_new] = cut_vertex_.emplace(key, static_cast<std::uint32_t>(shape_.points.size()));
    if (is_new) {
      const Point p = unsnapped(std::min(a, b)), q = unsnapped(std::max(a, b));
      shape_.points.push_back(between(p, q, crossing(p, q)));
    }
    return found->second;
  }

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    Tet tet{VertexId{a}, VertexId{b}, VertexId{c}, VertexId{d}};
    const auto& at = shape_.points;
    const Point &o = at[a], &p = at[b], &q = at[c], &r = at[d];
    const Point x{p[0] - o[0], p[1] - o[1], p[2] - o[2]}, y{q[0] - o[0], q[1] - o[1], q[2] - o[2]},
        z{r[0] - o[0], r[1] - o[1], r[2] - o[2]};
    const double volume =
        x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
    if (volume < 0) std::swap(tet[2], tet[3]);
    shape_.tets.push_back(tet);
  }

  /// Quadrilateral a b c d, from whose least vertex the diagonal goes, and the apex.
  void add_pyramid(const std::array<std::uint32_t, 4>& quad, std::uint32_t apex) {
    const auto least = static_cast<std::size_t>(std::min_element(quad.begin(), quad.end()) - quad.begin());
    const auto q = [&](std::size_t i) { return quad[(least + i) % 4]; };
    add(q(0), q(1), q(2), apex);
    add(q(0), q(2), q(3), apex);
  }

  /// The triangles `low` and `high`, low[i] beside high[i]. A tet at the least vertex and the triangle across from it;
  /// what remains is a pyramid over the quadrilateral across from it, with that vertex as apex.
  void add_prism(std::array<std::uint32_t, 3> low, std::array<std::uint32_t, 3> high) {
    if (*std::min_element(high.begin(), high.end()) < *std::min_element(low.begin(), low.end())) std::swap(low, high);
    const auto i = static_cast<std::size_t>(std::min_element(low.begin(), low.end()) - low.begin());
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    add(low[i], high[0], high[1], high[2]);
    add_pyramid({low[j], low[k], high[k], high[j]}, low[i]);
  }

  void cut_tet(const std::array<Node, 4>& tet) {
    std::array<Node, 4> in{}, out{}, on{};
    std::size_t ins = 0, outs = 0, ons = 0;
    for (const Node n : tet)
      (value_[n] > 0 ? in[ins++] : value_[n] < 0 ? out[outs++] : on[ons++]) = n;
    if (ins == 0) return;
    if (outs == 0) {
      add(vertex(tet[0]), vertex(tet[1]), vertex(tet[2]), vertex(tet[3]));
    } else if (ins == 1) {
      std::array<std::uint32_t, 3> base{};
      for (std::size_t i = 0; i < outs; ++i)
        base[i] = cut_vertex(in[0], out[i]);
      for (std::size_t i = 0; i < ons; ++i)
        base[outs + i] = vertex(on[i]);
      add(vertex(in[0]), base[0], base[1], base[2]);
    } else if (ins == 2 && outs == 1) {
      add_pyramid({vertex(in[0]), vertex(in[1]), cut_vertex(in[1], out[0]), cut_vertex(in[0], out[0])}, vertex(on[0]));
    } else if (ins == 2) {
      add_prism({vertex(in[0]), cut_vertex(in[0], out[0]), cut_vertex(in[0], out[1])},
                {vertex(in[1]), cut_vertex(in[1], out[0]), cut_vertex(in[1], out[1])});
    } else {
      add_prism({vertex(in[0]), vertex(in[1]), vertex(in[2])},
                {cut_vertex(in[0], out[0]), cut_vertex(in[1], out[0]), cut_vertex(in[2], out[0])});
    }
  }

  /// The tets around the faces between cells: two centres and an edge of the face.
  void cut() {
    for (std::uint32_t k = 0; k < cells_; ++k) {
      tell(progress_, "cutting the lattice", k, cells_);
      for (std::uint32_t j = 0; j < cells_; ++j)
        for (std::uint32_t i = 0; i < cells_; ++i)
          for (std::uint32_t axis = 0; axis < 3; ++axis) {
            std::array<std::uint32_t, 3> next{i, j, k};
            if (++next[axis] == cells_) continue;
            const Node here = centre(i, j, k), there = centre(next[0], next[1], next[2]);
            if (value_[here] < -2 * cell_) continue; // far from all of it
            for (std::uint32_t side = 0; side < 4; ++side)
              cut_tet({here, there, face_corner(next, axis, side), face_corner(next, axis, (side + 1) % 4)});
          }
    }
  }

  /// Around the face of the cell at `cell` that is towards lower places on `axis`.
  [[nodiscard]] Node face_corner(std::array<std::uint32_t, 3> cell, std::uint32_t axis, std::uint32_t number) const {
    cell[(axis + 1) % 3] += number == 1 || number == 2 ? 1 : 0;
    cell[(axis + 2) % 3] += number >= 2 ? 1 : 0;
    return corner(cell[0], cell[1], cell[2]);
  }

  std::uint32_t holes_;
  const ProgressCallback& progress_;
  double cell_ = 0; ///< edge of a cell
  std::uint32_t cells_ = 0, row_ = 0, corner_count_ = 0;
  double origin_ = 0;
  std::vector<float> value_;                                    ///< by node
  std::vector<std::uint32_t> vertex_of_;                        ///< by node
  std::unordered_map<Node, Point> snapped_;                     ///< nodes that have moved
  std::unordered_map<std::uint64_t, std::uint32_t> cut_vertex_; ///< by edge of the lattice
  Shape shape_;
};

} // namespace

Shape ball_with_holes(std::uint64_t tets, std::uint32_t holes, const ProgressCallback& progress) {
  return Stuffing(tets, std::min(holes, kMostHoles), progress).run();
}

} // namespace ptet::bench
