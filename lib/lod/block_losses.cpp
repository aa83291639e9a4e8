#include "lod/block_losses.hpp"

#include <algorithm>
#include <utility>

namespace ptet {

void BlockLosses::note(const BlockFailure& failure) {
  const std::lock_guard guard(mutex_);
  failed_.insert_or_assign(failure.block, Failed{failure, Clock::now()});
}

void BlockLosses::note_no_room(std::uint32_t block) {
  const std::lock_guard guard(mutex_);
  no_room_[block] = 1;
}

void BlockLosses::forget(const std::vector<std::uint32_t>& blocks) {
  const std::lock_guard guard(mutex_);
  for (const std::uint32_t b : blocks) {
    failed_.erase(b);
    no_room_[b] = 0;
  }
}

std::vector<std::uint32_t> BlockLosses::hopeless() const {
  std::vector<std::uint32_t> blocks;
  const std::lock_guard guard(mutex_);
  for (const auto& [block, failed] : failed_)
    if (failed.failure.code != ErrorCode::kIo || (in_background_ && Clock::now() - failed.when < kRetryAfter))
      blocks.push_back(block);
  return blocks;
}

std::vector<std::uint32_t> BlockLosses::failed() const {
  std::vector<std::pair<Clock::time_point, std::uint32_t>> by_time;
  {
    const std::lock_guard guard(mutex_);
    for (const auto& [block, failed] : failed_)
      by_time.emplace_back(failed.when, block);
  }
  std::sort(by_time.begin(), by_time.end());
  std::vector<std::uint32_t> blocks;
  blocks.reserve(by_time.size());
  for (const auto& [when, block] : by_time)
    blocks.push_back(block);
  return blocks;
}

Shortfall BlockLosses::explain(const BlockSet& missing) const {
  Shortfall shortfall;
  BlockSet rest = missing;
  const std::lock_guard guard(mutex_);
  std::vector<std::uint32_t> out;
  for (const auto& [block, failed] : failed_) {
    if (missing[block] == 0) continue;
    shortfall.failures.push_back(failed.failure);
    out.push_back(block);
  }
  needs_.leave_out(rest, std::move(out), BlockSet(rest.size(), 0));
  bool is_loading = false, lacks_room = false;
  for (const std::uint32_t b : members(rest))
    (no_room_[b] != 0 ? lacks_room : is_loading) = true;
  if (is_loading && in_background_) {
    shortfall.limited_by = LimitedBy::kLoading;
  } else if (lacks_room) {
    shortfall.limited_by = LimitedBy::kMemory;
  }
  return shortfall;
}

} // namespace ptet
