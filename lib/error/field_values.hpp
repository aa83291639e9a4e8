// The values of fields at the vertices of an original mesh, as the measurement of errors wants them: no digit lost.
//
//   value       (the value, less that at one vertex where it is a 64-bit integer) / unit
//   unit        of each field a power of two, at most the range: the division is exact
//   error       in fractions of the range: the norm of the differences times unit / range
#pragma once

#include "error/exact_field_error.hpp"
#include "ptet/mesh.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace ptet {

class FieldValues {
public:
  FieldValues() = default;
  /// The first `vertices` rows of some arrays of `mesh`; `ranges`, one an array: > 0 and finite.
  FieldValues(const TetMesh& mesh, std::span<const std::uint32_t> arrays, std::span<const double> ranges,
              std::uint32_t vertices);

  /// Errors measured with it are fractions of the ranges.
  [[nodiscard]] ChannelView view() const { return {values_, field_of_.size(), field_of_, scale_}; }
  [[nodiscard]] std::size_t channel_count() const { return field_of_.size(); }
  [[nodiscard]] const std::vector<std::size_t>& field_of() const { return field_of_; }
  /// The channels of vertex `v`.
  [[nodiscard]] const double* at(std::uint32_t v) const { return values_.data() + v * field_of_.size(); }
  /// unit / range of field `f`, in [1/2, 1] unless the range is subnormal.
  [[nodiscard]] double scale(std::size_t f) const { return scale_[f]; }
  /// The first field of which a value is so much smaller than the range that digits were lost, and errors there could
  /// not be told from none, or so much greater that it passes a double. The number of fields when there is no such
  /// field.
  [[nodiscard]] std::size_t first_losing_digits() const { return first_losing_digits_; }

private:
  std::vector<double> values_; ///< vertex x channel
  std::vector<std::size_t> field_of_;
  std::vector<double> scale_;
  std::size_t first_losing_digits_ = 0;
};

} // namespace ptet
