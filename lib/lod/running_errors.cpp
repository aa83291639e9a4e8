#include "lod/running_errors.hpp"

#include "lod/extraction.hpp"

#include <algorithm>
#include <utility>

namespace ptet {

RunningErrors::RunningErrors(const Hierarchy& hierarchy)
    : hierarchy_(hierarchy), codes_(hierarchy.errors_per_record()),
      is_changed_(hierarchy.header().record_count / kRecordsNoted + std::size_t{1}, 0),
      known_(hierarchy.blocks().size(), kUnknown), most_(hierarchy.blocks().size() * codes_),
      squared_(hierarchy.header().has_squared_errors ? hierarchy.blocks().size() * codes_ : 0), sums_(codes_),
      field_error_(codes_ - 1) {}

// note() does not look up the block of a record, which would take longer than the split itself; so blocks are matched
// here with the runs of kRecordsNoted records.
void RunningErrors::forget_changed() {
  for (std::size_t b = 0; b < known_.size(); ++b) {
    const file::BlockInfo& block = hierarchy_.blocks()[b];
    const auto first = is_changed_.begin() + block.first_record / kRecordsNoted;
    const auto last = is_changed_.begin() + (block.end_record() - 1) / kRecordsNoted;
    if (std::find(first, last + 1, 1) != last + 1) known_[b] = kUnknown;
  }
  std::fill(is_changed_.begin(), is_changed_.end(), 0);
}

void RunningErrors::measure(std::size_t b, const std::vector<char>& applied) {
  const file::BlockInfo& block = hierarchy_.blocks()[b];
  const file::Content& content = hierarchy_.content();
  ErrorCode16* const most = most_.data() + b * codes_;
  std::fill_n(most, codes_, ErrorCode16{0});
  for (std::uint32_t r = block.first_record; r < block.end_record(); ++r) {
    // Without a branch: which records are applied cannot be foreseen.
    const auto counts = static_cast<ErrorCode16>(applied[r] != 0 ? 0 : 0xFFFF);
    const ErrorCode16* const own = content.own.data() + r * codes_;
    for (std::size_t i = 0; i < codes_; ++i)
      most[i] = std::max(most[i], static_cast<ErrorCode16>(own[i] & counts));
  }
}

void RunningErrors::update(const std::vector<char>& applied, const BlockSet& read) {
  const bool has_squares = !squared_.empty();
  forget_changed();
  for (std::size_t b = 0; b < known_.size(); ++b) {
    const bool is_loaded = hierarchy_.content().block_loaded[b] != 0;
    const char known = is_loaded ? kMeasured : kNotLoaded; // of the latter no record is applied
    if (std::exchange(known_[b], known) == known) continue;
    if (is_loaded) measure(b, applied);
    if (has_squares) sum_squared_errors(hierarchy_, applied, b, {squared_.data() + b * codes_, codes_});
  }
  std::size_t i = 0;
  for (const file::ArrayInfo& array : hierarchy_.header().arrays) {
    if (!array.governing) continue;
    field_error_[i] = decode_error(largest(i, applied, read), array.range);
    ++i;
  }
  domain_error_ = decode_error(largest(i, applied, read), hierarchy_.header().diagonal);
  if (!has_squares) return;
  std::fill(sums_.begin(), sums_.end(), SquaredErrorSum{});
  for (std::size_t b = 0; b < known_.size(); ++b)
    for (std::size_t j = 0; j < codes_; ++j)
      sums_[j] += squared_[b * codes_ + j];
  set_mean_errors(hierarchy_, sums_, field_error_, mean_);
}

// Of a block that was not read all records count, of the others those on the frontier. The block with the largest error
// of a record not in the cut is looked at first: most others then need no look.
ErrorCode16 RunningErrors::largest(std::size_t code, const std::vector<char>& applied, const BlockSet& read) const {
  const file::Content& content = hierarchy_.content();
  const VersionKinds kind = code + 1 == codes_ ? kHasGhosts : kHasTets;
  ErrorCode16 found = 0;
  std::size_t most_at = 0;
  ErrorCode16 most = 0;
  for (std::size_t b = 0; b < read.size(); ++b) {
    if (read[b] == 0)
      found = std::max(found, hierarchy_.blocks()[b].max_own[code]);
    else if (most_[b * codes_ + code] > most)
      most = most_[(most_at = b) * codes_ + code];
  }
  const auto look_at = [&](std::size_t b) {
    if (read[b] == 0 || most_[b * codes_ + code] <= found) return;
    const file::BlockInfo& block = hierarchy_.blocks()[b];
    for (std::uint32_t r = block.first_record; r < block.end_record(); ++r)
      if (const ErrorCode16 own = content.own[r * codes_ + code];
          own > found && applied[r] == 0 && has_made(content.refinement, r, kind, applied))
        found = own;
  };
  if (most > found) look_at(most_at);
  for (std::size_t b = 0; b < read.size(); ++b)
    look_at(b);
  return found;
}

} // namespace ptet
