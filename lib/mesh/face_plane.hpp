// The plane of a face, to hold many other faces against: those that are seen to lie on one side of it do not meet the
// face but where they share its vertices. Needles round one edge, and thin faces round one vertex, have boxes that all
// meet one another; nearly all of their pairs are told apart here.
//
// Source of the bound: as in mesh/predicates.hpp, with the face's part of the products taken once.
#pragma once

#include "mesh/predicates.hpp"

#include <array>
#include <cmath>
#include <span>

namespace ptet {

class FacePlane {
public:
  FacePlane(const Face& face, std::span<const Point> points) : face_(face), from_(points[face[0].index()]) {
    const Point &b = points[face[1].index()], &c = points[face[2].index()];
    std::array<double, 3> u{}, v{};
    for (std::size_t i = 0; i < 3; ++i) {
      u[i] = b[i] - from_[i];
      v[i] = c[i] - from_[i];
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const double one = u[(i + 1) % 3] * v[(i + 2) % 3], other = u[(i + 2) % 3] * v[(i + 1) % 3];
      normal_[i] = one - other;
      size_[i] = std::abs(one) + std::abs(other);
    }
  }

  /// +1 where the normal of the face points, -1 behind it; 0 on the plane and where floating-point numbers are not
  /// sure.
  [[nodiscard]] int sure_side(const Point& x) const {
    double det = 0, size = 0, distance = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double d = x[i] - from_[i];
      det += normal_[i] * d;
      size += size_[i] * std::abs(d);
      distance += std::abs(d);
    }
    const double bound = 0x1p-49 * size + 1e-300 * (distance + 1.0);
    if (det > bound) return 1;
    return det < -bound ? -1 : 0;
  }

  /// Whether all vertices of `other` that are not vertices of the face, by id, surely lie on one side, and there are
  /// some: then faces_meet_improperly(face, other, points) is false. False decides nothing.
  [[nodiscard]] bool surely_misses(const Face& other, std::span<const Point> points) const {
    int side = 0;
    for (const VertexId v : other) {
      if (v == face_[0] || v == face_[1] || v == face_[2]) continue;
      const int here = sure_side(points[v.index()]);
      if (here == 0 || here == -side) return false;
      side = here;
    }
    return side != 0;
  }

private:
  Face face_;
  Point from_;
  std::array<double, 3> normal_{}, size_{};
};

} // namespace ptet
