// Root mean square errors of a cut, and how much of the original's volume its mesh covers: what the collapses that are
// not undone have added up to.
#pragma once

#include "lod/hierarchy.hpp"

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace ptet {

/// A sum of what records raise something by (file::BlockInfo::squared_error).
class SquaredErrorSum {
public:
  void add(double x) {
    sum_ += x;
    magnitude_ += std::fabs(x);
    ++count_;
  }
  SquaredErrorSum& operator+=(const SquaredErrorSum& other);
  /// Never below the true one by rounding, and not below 0.
  [[nodiscard]] double upper() const;

private:
  double sum_ = 0, magnitude_ = 0;
  std::size_t count_ = 0;
};

/// Sets `sums`, one per governing field and one of what is not covered, to what the records of a block that are not in
/// the cut contribute. A block of which some records are in the cut and some are not must be loaded. The lock must be
/// held.
void sum_squared_errors(const Hierarchy& hierarchy, const std::vector<char>& applied, std::size_t block,
                        std::span<SquaredErrorSum> sums);

/// See Extraction.
struct MeanErrors {
  std::vector<double> rms_error; ///< one per governing field, or none
  std::optional<double> covered;
};
/// Sets them for the cut that `sums`, over all blocks, are of; `field_error`: its largest errors, which bound the
/// others.
void set_mean_errors(const Hierarchy& hierarchy, std::span<const SquaredErrorSum> sums,
                     const std::vector<double>& field_error, MeanErrors& mean);
/// Of the cut in which the splits `applied` (by record) are. As for sum_squared_errors.
[[nodiscard]] MeanErrors mean_errors(const Hierarchy& hierarchy, const std::vector<char>& applied,
                                     const std::vector<double>& field_error);

} // namespace ptet
