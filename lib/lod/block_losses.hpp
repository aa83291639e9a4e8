// Which blocks could not be had, and why: what is told of an answer that lacks them, and what is not tried again.
#pragma once

#include "lod/block_needs.hpp"
#include "ptet/dataset.hpp"

#include <chrono>
#include <map>
#include <mutex>
#include <vector>

namespace ptet {

/// Why a request that depends on blocks cannot have those that are missing.
struct Shortfall {
  LimitedBy limited_by = LimitedBy::kUnreadable;
  std::vector<BlockFailure> failures; ///< by block
};

/// Thread rule: any number of threads.
class BlockLosses {
public:
  /// `needs` must outlive it. `in_background`: what is missing for no other reason is still to be loaded.
  BlockLosses(const BlockNeeds& needs, bool in_background)
      : needs_(needs), in_background_(in_background), no_room_(needs.size(), 0) {}

  void note(const BlockFailure& failure);
  void note_no_room(std::uint32_t block);
  /// They could be had after all.
  void forget(const std::vector<std::uint32_t>& blocks);

  /// Blocks that are not to be tried now. Those that are damaged never are again. Those that could not be
  /// read are tried at the next request; by the thread that loads in the background after a while, lest it does nothing
  /// else.
  [[nodiscard]] std::vector<std::uint32_t> hopeless() const;
  /// All blocks that could not be had when they were last tried, the one first that was tried the longest ago.
  [[nodiscard]] std::vector<std::uint32_t> failed() const;
  [[nodiscard]] Shortfall explain(const BlockSet& missing) const;

private:
  using Clock = std::chrono::steady_clock;
  struct Failed {
    BlockFailure failure;
    Clock::time_point when;
  };
  static constexpr std::chrono::seconds kRetryAfter{1};

  const BlockNeeds& needs_;
  const bool in_background_;
  mutable std::mutex mutex_;
  std::map<std::uint32_t, Failed> failed_;
  BlockSet no_room_;
};

} // namespace ptet
