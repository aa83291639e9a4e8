// Plain 3-vectors on std::array, as far as geometry here needs them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace ptet {

using Vec3 = std::array<double, 3>;

inline double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline double norm(const Vec3& a) {
  return std::sqrt(dot(a, a));
}
inline bool is_finite(const Vec3& a) {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// std::array lives in std, so these are found by their namespace only: `using namespace ptet::vec`.
namespace vec {
inline Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vec3 operator*(double s, const Vec3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
} // namespace vec

/// The direction of a vector, however long or short; nothing where it has none.
inline std::optional<Vec3> direction_of(const Vec3& a) {
  using namespace vec;
  if (!is_finite(a)) return std::nullopt;
  const double most = std::max({std::abs(a[0]), std::abs(a[1]), std::abs(a[2])});
  if (!(most > 0)) return std::nullopt;
  const Vec3 scaled = {a[0] / most, a[1] / most, a[2] / most}; // squares would overflow or vanish, as 1 / most may
  return 1 / norm(scaled) * scaled;
}

inline double tet_volume(const std::array<Vec3, 4>& tet) {
  using namespace vec;
  return std::abs(dot(tet[1] - tet[0], cross(tet[2] - tet[0], tet[3] - tet[0]))) / 6;
}

} // namespace ptet
