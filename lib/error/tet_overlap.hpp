// The overlap of two tets, as small tets: the first one cut by the four face planes of the other. Everything is told by
// barycentric coordinates, so that a field is known at each corner in both.
//
//      weights of S's corners in O all <= 0 for one face of O, or the other way round:  apart
//      else: O cut by one face of S after the other, each piece into one tet or three
#pragma once

#include "mesh/predicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ptet {

/// Overlaps that are narrower than this, as a share of a tet's height, are rounding where tets only touch.
inline constexpr double kTouching = 1e-12;

/// Barycentric coordinates with respect to one tet.
template <class Real>
class Frame {
public:
  explicit Frame(const std::array<Point, 4>& tet) : origin_(tet[0]) {
    std::array<std::array<Real, 3>, 3> edge;
    for (std::size_t i = 0; i < 3; ++i)
      edge[i] = from_origin(tet[i + 1]);
    const auto crossed = [](const std::array<Real, 3>& a, const std::array<Real, 3>& b) {
      return std::array<Real, 3>{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    row_ = {crossed(edge[1], edge[2]), crossed(edge[2], edge[0]), crossed(edge[0], edge[1])};
    const Real det = edge[0][0] * row_[0][0] + edge[0][1] * row_[0][1] + edge[0][2] * row_[0][2];
    for (auto& row : row_)
      for (Real& x : row)
        x /= det;
  }

  [[nodiscard]] std::array<Real, 4> weights(const Point& p) const {
    const auto q = from_origin(p);
    std::array<Real, 4> weight;
    for (std::size_t i = 0; i < 3; ++i)
      weight[i + 1] = row_[i][0] * q[0] + row_[i][1] * q[1] + row_[i][2] * q[2];
    weight[0] = 1 - weight[1] - weight[2] - weight[3];
    return weight;
  }

private:
  [[nodiscard]] std::array<Real, 3> from_origin(const Point& p) const {
    return {Real(p[0]) - Real(origin_[0]), Real(p[1]) - Real(origin_[1]), Real(p[2]) - Real(origin_[2])};
  }
  Point origin_;
  std::array<std::array<Real, 3>, 3> row_;
};

/// Whether all four corners lie on or behind one face of a tet, going by their weights in it.
template <class Real>
bool is_apart(const std::array<std::array<Real, 4>, 4>& weights) {
  for (std::size_t k = 0; k < 4; ++k)
    if (std::max({weights[0][k], weights[1][k], weights[2][k], weights[3][k]}) <= Real(kTouching)) return true;
  return false;
}

/// The overlap of two tets as small tets on a common list of corners.
template <class Real>
class Overlap {
public:
  struct Corner {
    std::array<Real, 4> in_original, in_simplified;
  };
  struct Piece {
    std::array<std::uint32_t, 4> corner;
    Real share; ///< of the original tet's volume
  };

  /// False when the tets do not overlap. `in_simplified`: the weights of the original tet's corners.
  bool clip(const std::array<std::array<Real, 4>, 4>& in_simplified) {
    corners_.clear();
    for (std::size_t i = 0; i < 4; ++i) {
      corners_.push_back({{}, in_simplified[i]});
      corners_[i].in_original[i] = 1;
    }
    pieces_.assign(1, {{0, 1, 2, 3}, 1});
    for (std::size_t face = 0; face < 4 && !pieces_.empty(); ++face) {
      if (std::all_of(corners_.begin(), corners_.end(), [&](const Corner& c) { return c.in_simplified[face] >= 0; }))
        continue;
      kept_.clear();
      for (const Piece& piece : pieces_)
        cut(piece, face);
      pieces_.swap(kept_);
    }
    return !is_rounding();
  }

  [[nodiscard]] const std::vector<Corner>& corners() const { return corners_; }
  [[nodiscard]] const std::vector<Piece>& pieces() const { return pieces_; }

private:
  /// Whether what is left is a film on one face of either tet.
  [[nodiscard]] bool is_rounding() const {
    std::array<Real, 8> widest{};
    for (const Piece& piece : pieces_)
      for (const std::uint32_t c : piece.corner)
        for (std::size_t k = 0; k < 4; ++k) {
          widest[k] = std::max(widest[k], corners_[c].in_original[k]);
          widest[4 + k] = std::max(widest[4 + k], corners_[c].in_simplified[k]);
        }
    return *std::min_element(widest.begin(), widest.end()) <= Real(kTouching);
  }

  /// Where the edge from a to b passes through the face: the share of the way from a.
  Real passage(std::uint32_t a, std::uint32_t b, std::size_t face) const {
    const Real at_a = corners_[a].in_simplified[face], at_b = corners_[b].in_simplified[face];
    return at_a / (at_a - at_b);
  }

  std::uint32_t between(std::uint32_t a, std::uint32_t b, Real share, std::size_t face) {
    Corner corner;
    const Corner &from = corners_[a], &to = corners_[b];
    for (std::size_t k = 0; k < 4; ++k) {
      corner.in_original[k] = from.in_original[k] + share * (to.in_original[k] - from.in_original[k]);
      corner.in_simplified[k] = from.in_simplified[k] + share * (to.in_simplified[k] - from.in_simplified[k]);
    }
    corner.in_simplified[face] = 0;
    corners_.push_back(corner);
    return static_cast<std::uint32_t>(corners_.size() - 1);
  }

  void keep(const std::array<std::uint32_t, 4>& corner, Real share) {
    if (share > 0) kept_.push_back({corner, share});
  }

  /// Keeps the part of a piece before the plane of one face, as one tet or three.
  void cut(const Piece& piece, std::size_t face) {
    std::array<std::uint32_t, 4> v{};
    std::size_t inside = 0, outside = 4;
    for (const std::uint32_t c : piece.corner)
      (corners_[c].in_simplified[face] > 0 ? v[inside++] : v[--outside]) = c;
    if (inside == 4) {
      kept_.push_back(piece);
    } else if (inside == 1) {
      const Real s = passage(v[0], v[1], face), t = passage(v[0], v[2], face), u = passage(v[0], v[3], face);
      const std::uint32_t p = between(v[0], v[1], s, face), q = between(v[0], v[2], t, face),
                          r = between(v[0], v[3], u, face);
      keep({v[0], p, q, r}, piece.share * s * t * u);
    } else if (inside == 2) {
      // A wedge with the triangles a, ac, ad and b, bc, bd.
      const auto [a, b, c, d] = v;
      const Real ac = passage(a, c, face), ad = passage(a, d, face), bc = passage(b, c, face), bd = passage(b, d, face);
      const std::uint32_t p = between(a, c, ac, face), q = between(a, d, ad, face), r = between(b, c, bc, face),
                          s = between(b, d, bd, face);
      keep({a, p, q, b}, piece.share * ac * ad);
      keep({p, q, b, r}, piece.share * (1 - ac) * ad * bc);
      keep({q, b, r, s}, piece.share * (1 - ad) * bc * bd);
    } else if (inside == 3) {
      // A wedge with the triangles b, c, d and those points on the edges to a; x, y, z: shares of the way from a.
      const auto [b, c, d, a] = v;
      const Real x = passage(a, b, face), y = passage(a, c, face), z = passage(a, d, face);
      const std::uint32_t p = between(a, b, x, face), q = between(a, c, y, face), r = between(a, d, z, face);
      keep({p, b, c, d}, piece.share * (1 - x));
      keep({p, q, c, d}, piece.share * x * (1 - y));
      keep({p, q, r, d}, piece.share * x * y * (1 - z));
    }
  }

  std::vector<Corner> corners_;
  std::vector<Piece> pieces_, kept_;
};

} // namespace ptet
