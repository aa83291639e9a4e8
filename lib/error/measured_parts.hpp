// What is measured on the parts of original tets in one version: the greatest error of each field, the integral of its
// square, and what is left of the version.
//
// On the part of the version in one original tet the difference is linear, so its norm is greatest at a vertex of that
// part. The original tet is clipped to the version, plane by plane, into tets whose volumes are products of ratios in
// [0, 1], so nothing cancels and slivers do no harm; the vertices of the part are among the corners of these. On each
// the difference d is linear, and
//
//            integral of d^2 = volume / 20 ((d0 + d1 + d2 + d3)^2 + d0^2 + d1^2 + d2^2 + d3^2)
//
// Source: Cignoni et al. 2000, sections 4.1 and 4.2.
#pragma once

#include "error/original_cells.hpp"
#include "error/version_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace ptet {

class MeasuredParts {
public:
  using Rows = std::array<std::uint32_t, 4>; ///< of the corners of an original tet

  /// Raises `errors` (one a field) and adds to `squared` (one a field and one more; empty: not wanted). `limit` (one a
  /// field) empty: none. `original` and `view` must outlive the object.
  MeasuredParts(const OriginalCells& original, const VersionView& view, std::span<double> errors,
                std::span<double> squared, std::span<const double> limit)
      : original_(original), view_(view), errors_(errors), squared_(squared), limit_(limit) {}

  /// Takes in the part of an original tet in the version; false when it has none. Parts with no volume but what
  /// rounding gave them are seen and not taken in.
  bool take_in(const Rows& rows, double volume);
  /// Of a version that cannot be measured: instead of parts, pairs of vertices are taken in, as if how far their values
  /// are apart were an error; then the greatest of these, everywhere in as much as the version may be.
  void begin_values();
  void take_in_values(std::uint32_t v, std::uint32_t w);
  void take_values_everywhere();
  /// When all parts have been taken in: the volume of the version that is in none of them goes to the last of
  /// `squared`.
  void take_rest();
  /// What cannot be computed is as bad as can be.
  void fail() {
    std::fill(errors_.begin(), errors_.end(), INFINITY);
    beyond_limit_ |= !limit_.empty();
  }
  [[nodiscard]] bool beyond_limit() const { return beyond_limit_; }

private:
  template <std::size_t N, bool Scalars>
  bool carry(const Rows& rows, double volume);
  template <std::size_t N>
  bool carry_some(const Rows& rows, double volume);
  bool weigh(const Rows& rows, double volume);
  [[nodiscard]] bool only_touches(double covered, double volume) const;
  void raise(std::size_t field, double error_sq, double integral, double corner_sq);
  void raise_error(std::size_t field, double error_sq);

  const OriginalCells& original_;
  const VersionView& view_;
  std::span<double> errors_;
  std::span<double> squared_;
  std::span<const double> limit_;
  bool beyond_limit_ = false;
  double covered_ = 0;                     ///< volume of the parts
  std::vector<double> seen_sq_, integral_; ///< by field: of one tet, or of all values
};

} // namespace ptet
