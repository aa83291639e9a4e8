// Quadrics of field and domain, in the frame of the vertex that carries them, so that they lose nothing to
// cancellation and moving one to a neighbour costs a few multiplications.
//
//   field   sum over tets t of w (phi_t(x) - f)^2,  phi_t the linear field of t  (Cignoni et al. 2000, section 5.3)
//   domain  sum over boundary faces of w (n . x + d)^2  (Garland and Heckbert 1997)
//
// x and f are differences to the carrying vertex. Lengths are fractions of the diagonal, values of the field's range.
#pragma once

#include "mesh/vec3.hpp"

#include <array>

namespace ptet::build {

using namespace vec;

/// Symmetric 3x3: xx, xy, xz, yy, yz, zz.
struct Symmetric {
  std::array<double, 6> a{};

  void add_outer(double w, const Vec3& g) {
    a[0] += w * g[0] * g[0];
    a[1] += w * g[0] * g[1];
    a[2] += w * g[0] * g[2];
    a[3] += w * g[1] * g[1];
    a[4] += w * g[1] * g[2];
    a[5] += w * g[2] * g[2];
  }
  void add(const Symmetric& other) {
    for (std::size_t i = 0; i < 6; ++i)
      a[i] += other.a[i];
  }
  [[nodiscard]] Vec3 times(const Vec3& x) const {
    return {a[0] * x[0] + a[1] * x[1] + a[2] * x[2], a[1] * x[0] + a[3] * x[1] + a[4] * x[2],
            a[2] * x[0] + a[4] * x[1] + a[5] * x[2]};
  }
  [[nodiscard]] double form(const Vec3& x) const { return dot(x, times(x)); }
};

/// One field channel at one vertex. Residual of a tet: r = g.x + c0 - f.
struct FieldQuadric {
  Symmetric gg;  ///< sum w g g^T
  Vec3 gc{};     ///< sum w g c0
  Vec3 g{};      ///< sum w g
  double cc = 0; ///< sum w c0^2
  double c = 0;  ///< sum w c0

  /// A tet at the carrying vertex itself: c0 = 0.
  void add_tet(double w, const Vec3& gradient) {
    gg.add_outer(w, gradient);
    g = g + w * gradient;
  }
  /// sum w r^2 at (x, f); `weight` = sum w.
  [[nodiscard]] double at(const Vec3& x, double f, double weight) const {
    return gg.form(x) + 2 * dot(gc, x) + cc + weight * f * f - 2 * f * (dot(g, x) + c);
  }
  /// Adds `other`, carried by a vertex from which this one lies at (t, s).
  void add_moved(const FieldQuadric& other, const Vec3& t, double s, double weight) {
    const double moved_cc = other.at(t, s, weight);
    const Vec3 gt = other.gg.times(t);
    gg.add(other.gg);
    for (std::size_t i = 0; i < 3; ++i) {
      gc[i] += other.gc[i] + gt[i] - s * other.g[i];
      g[i] += other.g[i];
    }
    cc += moved_cc;
    c += other.c + dot(other.g, t) - weight * s;
  }
};

/// The planes of the boundary faces at one vertex.
struct PlaneQuadric {
  Symmetric nn;
  Vec3 nd{};
  double dd = 0;

  void add_plane(double w, const Vec3& unit_normal) { nn.add_outer(w, unit_normal); }
  /// sum w (n . x + d)^2
  [[nodiscard]] double at(const Vec3& x) const { return nn.form(x) + 2 * dot(nd, x) + dd; }
  /// The sum of the magnitudes that at(x) is the sum of, or more.
  [[nodiscard]] double magnitude_at(const Vec3& x) const { return weight() * dot(x, x) + 2 * norm(nd) * norm(x) + dd; }
  /// sum w
  [[nodiscard]] double weight() const { return nn.a[0] + nn.a[3] + nn.a[5]; }
  void add_moved(const PlaneQuadric& other, const Vec3& t) {
    const double moved_dd = other.at(t);
    const Vec3 nt = other.nn.times(t);
    nn.add(other.nn);
    for (std::size_t i = 0; i < 3; ++i)
      nd[i] += other.nd[i] + nt[i];
    dd += moved_dd;
  }
};

} // namespace ptet::build
