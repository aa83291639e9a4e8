#include "lod/pace_of_loading.hpp"

#include <algorithm>

namespace ptet {
namespace {

/// What it takes to read and decode a block, in records: they may have one record or hundreds.
double work_of(const file::BlockInfo& block) {
  constexpr double kRecordsOfBlock = 32; // what it takes however few they are
  return kRecordsOfBlock + block.record_count;
}

constexpr double kMostMore = 4;
/// How much more is tried, and from when on it counts as more.
constexpr double kTried = 2, kMore = 1.5;
/// So many times the pace is much the quicker way.
constexpr double kMuchQuicker = 1.5;

} // namespace

void PaceOfLoading::note(double work, double seconds) {
  const std::lock_guard guard(mutex_);
  seconds = std::max(seconds, 1e-9);
  most_ = std::max(most_, work);
  if (last_work_ == 0 || work <= kMore * last_work_) {
    if (wait_ > 0) --wait_;
    if (wait_ == 0) first_work_ = std::max(first_work_, kTried * work);
  } else if (work / seconds >= kMuchQuicker * last_work_ / last_seconds_) {
    first_work_ = kTried * work;
    next_wait_ = kWaits;
  } else {
    first_work_ = last_work_;
    wait_ = next_wait_;
    next_wait_ *= 2;
  }
  last_work_ = work;
  last_seconds_ = seconds;
}

LoadingLimit PaceOfLoading::limit(double seconds_left, bool is_first) const {
  const std::lock_guard guard(mutex_);
  constexpr double kAny = std::numeric_limits<double>::infinity();
  if (most_ == 0) return {is_first || seconds_left > 0 ? kAny : 0, 0}; // none could be had so far
  const double affordable = std::max(seconds_left, 0.0) / last_seconds_ * last_work_;
  if (!is_first) return {affordable, std::min(affordable, kMostMore * most_)};
  return {kAny, std::min(std::max(affordable, first_work_), kMostMore * most_)};
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
