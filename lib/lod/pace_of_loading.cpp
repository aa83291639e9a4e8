#include "lod/pace_of_loading.hpp"

#include <algorithm>

namespace ptet {
namespace {

/// What it takes to read and decode a block, in records: they may have one record or hundreds.
double work_of(const file::BlockInfo& block) {
  constexpr double kRecordsOfBlock = 32; // what it takes however few they are
  return kRecordsOfBlock + block.record_count;
}

/// What is read at once is compared where one is so many times the other.
constexpr double kOther = 2;
/// Of what a loading took at least this part is for what was loaded: what was quick is not taken for nothing.
constexpr double kLeastForWork = 1.0 / 16;
constexpr double kMostMore = 4;
/// So much longer is hardly longer.
constexpr double kHardly = 0.25;

} // namespace

void PaceOfLoading::note(double work, double seconds) {
  const std::lock_guard guard(mutex_);
  seconds = std::max(seconds, 1e-9);
  most_ = std::max(most_, work);
  const double foreseen = seconds_ + seconds_per_work_ * work;
  if (last_work_ > 0 && (work >= kOther * last_work_ || last_work_ >= kOther * work)) {
    const double per_work = (seconds - last_seconds_) / (work - last_work_);
    seconds_per_work_ = std::clamp(per_work, kLeastForWork * seconds / work, seconds / work);
    seconds_ = seconds - seconds_per_work_ * work;
    knows_both_ = true;
  } else if (last_work_ > 0) {
    seconds_ *= seconds / foreseen;
    seconds_per_work_ *= seconds / foreseen;
  } else {
    seconds_per_work_ = seconds / work;
  }
  last_work_ = work;
  last_seconds_ = seconds;
}

LoadingLimit PaceOfLoading::limit(double seconds_left, bool is_first) const {
  const std::lock_guard guard(mutex_);
  if (most_ == 0) return {};
  const double affordable = std::max(seconds_left - seconds_, 0.0) / seconds_per_work_;
  if (!is_first) return {affordable, std::min(affordable, kMostMore * most_)};
  const double hardly_longer = knows_both_ ? kHardly * seconds_ / seconds_per_work_ : kOther * last_work_;
  return {std::numeric_limits<double>::infinity(), std::min(std::max(affordable, hardly_longer), kMostMore * most_)};
}

std::optional<std::vector<std::uint32_t>> PartToLoad::add(std::uint32_t block, const BlockSet& lost,
                                                          const LoadingLimit* limit) {
  std::vector<std::uint32_t> added = needs_.add(blocks_, block, lost);
  double more = 0;
  for (const std::uint32_t b : added)
    if (loaded_[b] == 0) more += work_of(needs_.block(b));
  if (limit != nullptr && more > 0 && !limit->allows(work_, more)) {
    for (const std::uint32_t b : added)
      blocks_[b] = 0;
    return std::nullopt;
  }
  work_ += more;
  return added;
}

void PartToLoad::keep_loaded() {
  intersect(blocks_, loaded_);
  unite(blocks_, start_);
  work_ = 0;
}

} // namespace ptet
