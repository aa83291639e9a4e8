// The errors of a cut that changes: what can be told block by block is kept, and only what can matter is looked at.
//
// A cut's error is the largest among the records on its frontier: those that are not in the cut and that made something
// that is in its mesh. Record r, not in the cut, did so if some version of C(r) is there: one of the base, or one that
// came with the split of a parent that is in the cut.
#pragma once

#include "lod/mean_errors.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace ptet {

class RunningErrors {
public:
  /// Nothing is split. `hierarchy` must outlive it.
  explicit RunningErrors(const Hierarchy& hierarchy);

  /// To be called when record `r` came into the cut or went out.
  void note(std::uint32_t r) { is_changed_[r / kRecordsNoted] = 1; }
  /// `applied`: by record; `read`: by block. The lock must be held.
  void update(const std::vector<char>& applied, const BlockSet& read);

  // See Extraction.
  [[nodiscard]] const std::vector<double>& field_error() const { return field_error_; }
  [[nodiscard]] const std::vector<double>& rms_error() const { return mean_.rms_error; }
  [[nodiscard]] std::optional<double> covered() const { return mean_.covered; }
  [[nodiscard]] double domain_error() const { return domain_error_; }

private:
  static constexpr char kUnknown = 0, kNotLoaded = 1, kMeasured = 2;
  static constexpr std::uint32_t kRecordsNoted = 256;

  void forget_changed();
  void measure(std::size_t block, const std::vector<char>& applied);
  [[nodiscard]] ErrorCode16 largest(std::size_t code, const std::vector<char>& applied, const BlockSet& read) const;

  const Hierarchy& hierarchy_;
  std::size_t codes_;
  std::vector<char> is_changed_;         ///< by kRecordsNoted records
  std::vector<char> known_;              ///< by block: whether the two below are those of the cut
  std::vector<ErrorCode16> most_;        ///< by block and code: largest own error of the records not in the cut
  std::vector<SquaredErrorSum> squared_; ///< by block and what is summed up
  std::vector<SquaredErrorSum> sums_;    ///< over all blocks
  std::vector<double> field_error_;
  MeanErrors mean_;
  double domain_error_ = 0;
};

} // namespace ptet
