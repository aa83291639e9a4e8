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

} // namespace ptet
