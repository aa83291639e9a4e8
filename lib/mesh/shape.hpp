// The shape measure of tetrahedra that checks and reports go by.
#pragma once

#include "mesh/vec3.hpp"

#include <algorithm>

namespace ptet {

/// 6 sqrt(2) V / Lmax^3 of a tet: 1 for a regular one, 0 for a flat one, negative for an inverted one.
[[nodiscard]] inline double shape_quality(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  using namespace vec;
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ad = d - a;
  const Vec3 bc = c - b;
  const Vec3 bd = d - b;
  const Vec3 cd = d - c;
  const double longest_sq = std::max({dot(ab, ab), dot(ac, ac), dot(ad, ad), dot(bc, bc), dot(bd, bd), dot(cd, cd)});
  return longest_sq > 0 ? std::sqrt(2.0) * dot(ab, cross(ac, ad)) / (longest_sq * std::sqrt(longest_sq)) : 0;
}

/// Whether the gradient of a linear field in a tet means anything, from the edges out of one corner; the squares of
/// their cubes must fit a double. Not where the tet is flat: its height over the largest face there beside the height
/// of that face, which is not small in a needle. Nor where its volume, as part of a cube's on its longest edge, may be
/// rounding.
[[nodiscard]] inline bool has_gradient(const Vec3& e1, const Vec3& e2, const Vec3& e3) {
  constexpr double kFlat = 1e-9, kRoundingOfVolume = 1e-13;
  const Vec3 n1 = cross(e2, e3), n2 = cross(e3, e1), n3 = cross(e1, e2);
  const double six_volumes = std::abs(dot(e1, n1));
  const double longest = std::sqrt(std::max({dot(e1, e1), dot(e2, e2), dot(e3, e3)}));
  const double largest_sq = std::max({dot(n1, n1), dot(n2, n2), dot(n3, n3)});
  return six_volumes * longest > kFlat * largest_sq && six_volumes > kRoundingOfVolume * longest * longest * longest;
}

} // namespace ptet
