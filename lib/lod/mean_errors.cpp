#include "lod/mean_errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ptet {

SquaredErrorSum& SquaredErrorSum::operator+=(const SquaredErrorSum& other) {
  sum_ += other.sum_;
  magnitude_ += other.magnitude_;
  count_ += other.count_;
  return *this;
}

double SquaredErrorSum::upper() const {
  // However the sum was gathered, each number went through fewer additions than there are numbers: that bounds
  // rounding.
  const double slack = magnitude_ * (static_cast<double>(count_) * std::numeric_limits<double>::epsilon());
  return std::max(0.0, sum_ + slack);
}

// Each collapse that is not undone contributes what it raised the integral by. Of a block without a record in the cut
// the sum is in the block table, and taken from there even if the block is loaded: so the answer does not depend on
// what was read before.
void sum_squared_errors(const Hierarchy& hierarchy, const std::vector<char>& applied, std::size_t block,
                        std::span<SquaredErrorSum> sums) {
  const file::BlockInfo& info = hierarchy.blocks()[block];
  const std::vector<SquaredErrorCode>& codes = hierarchy.content().squared_error;
  std::fill(sums.begin(), sums.end(), SquaredErrorSum{});
  const char* const first = applied.data() + info.first_record;
  const auto undone = static_cast<std::uint32_t>(std::count(first, first + info.record_count, 1));
  if (undone == info.record_count) return;
  if (undone == 0) {
    for (std::size_t i = 0; i < sums.size(); ++i)
      sums[i].add(info.squared_error[i]);
    return;
  }
  for (std::size_t r = info.first_record; r < info.end_record(); ++r)
    for (std::size_t i = 0; i < sums.size() && applied[r] == 0; ++i)
      sums[i].add(file::decode_sum(hierarchy.header(), i, sums.size(), codes[r * sums.size() + i]));
}

// Both sums are upper bounds, so the part that is covered is a lower one, and their quotient an upper one again. Where
// little is covered that may be more than the largest error, which no mean is above.
void set_mean_errors(const Hierarchy& hierarchy, std::span<const SquaredErrorSum> sums,
                     const std::vector<double>& field_error, MeanErrors& mean) {
  const double covered = std::max(0.0, 1 - sums.back().upper());
  mean.covered = covered;
  mean.rms_error.clear();
  for (const file::ArrayInfo& array : hierarchy.header().arrays) {
    if (!array.governing) continue;
    const std::size_t i = mean.rms_error.size();
    const double rms = covered > 0 ? array.range * std::sqrt(sums[i].upper() / covered) : field_error[i];
    mean.rms_error.push_back(std::min(rms, field_error[i]));
  }
}

MeanErrors mean_errors(const Hierarchy& hierarchy, const std::vector<char>& applied,
                       const std::vector<double>& field_error) {
  if (!hierarchy.header().has_squared_errors) return {};
  std::vector<SquaredErrorSum> totals(hierarchy.errors_per_record()), sums(totals.size());
  for (std::size_t b = 0; b < hierarchy.blocks().size(); ++b) {
    sum_squared_errors(hierarchy, applied, b, sums);
    for (std::size_t i = 0; i < sums.size(); ++i)
      totals[i] += sums[i];
  }
  MeanErrors mean;
  set_mean_errors(hierarchy, totals, field_error, mean);
  return mean;
}

} // namespace ptet
