// A cut that goes from request to request by what differs between them.
//
//   cut = closure over parents of { r : r is promised }   +   { r : r is wished, before the end of the budget's order }
//         counted: r is in it while it is wanted itself       as it is where that is closed, else counted like promises
//         or a child of it is in it
//
// A budget is a place in the order of all records. Of wishes that are closed (Wants::are_closed), histograms of sizes
// by order code find it; of others it moves from where it was, record by record, until what is counted just fits.
// Whatever the requests before, the cut is the one that find_cut finds.
#pragma once

#include "lod/budget.hpp"
#include "lod/cancellation.hpp"
#include "lod/demand.hpp"

#include <chrono>
#include <optional>
#include <span>

namespace ptet {

class RunningCut {
public:
  using Clock = std::chrono::steady_clock;

  /// Of the base mesh. `hierarchy` must outlive it.
  explicit RunningCut(Hierarchy& hierarchy);
  ~RunningCut();
  RunningCut(const RunningCut&) = delete;
  RunningCut& operator=(const RunningCut&) = delete;

  /// Makes it the cut of `request`, whose budget of time is not looked at, and reads the blocks that it takes. Returns
  /// the lock: while it is held, what the cut needs is in memory. Blocks that cannot be had are left out, see Cut.
  /// `until`: blocks that could not be read by then are left out, too, see is_out_of_time() and Loader::load.
  /// Throws what Loader::load throws; the cut is then between the last one and that of `request`. After
  /// Error(kCancelled) the next call goes on from there.
  [[nodiscard]] std::shared_lock<std::shared_mutex> set(const ResolvedRequest& request,
                                                        const std::optional<Clock::time_point>& until = std::nullopt,
                                                        Cancellation* cancellation = nullptr);

  [[nodiscard]] bool contains(std::uint32_t r) const {
    return uses_[r] != 0 || ((flags_[r] & kWished) != 0 && is_before_end(r));
  }
  /// Records that may have come in or gone out since they were last dropped from the list; each once.
  [[nodiscard]] const std::vector<std::uint32_t>& touched() const { return touched_; }
  /// Keeps of touched() those that `is_open(r)`.
  template <class IsOpen>
  void drop_touched(IsOpen&& is_open) {
    std::erase_if(touched_, [&](std::uint32_t r) {
      const bool keep = is_open(r);
      if (!keep) flags_[r] &= static_cast<std::uint8_t>(~kTouched);
      return !keep;
    });
  }
  /// See Cut.
  [[nodiscard]] const BlockSet& read() const { return read_; }
  [[nodiscard]] const BlockSet& missing() const { return missing_; }
  [[nodiscard]] bool is_stopped_by_budget() const { return stopped_by_budget_; }
  /// Whether blocks are missing that there was no time for.
  [[nodiscard]] bool is_out_of_time() const { return is_out_of_time_; }

private:
  static constexpr std::uint8_t kPromised = 1; ///< wanted itself, whatever the budget
  static constexpr std::uint8_t kWished = 2;   ///< of those that a budget is spent on
  static constexpr std::uint8_t kTouched = 4;  ///< in touched_

  void read_closed(BlockSet& set);
  bool meet_new_blocks();
  /// `which`: blocks that were met; all, where the request has changed.
  void update_promised(std::span<const std::uint32_t> which);
  /// In blocks that were met, but those whose records all have smaller order codes than `key`.
  void update_wished(OrderCode key);
  void withdraw_wishes();
  void use(std::uint32_t r);
  void release(std::uint32_t r);
  void touch(std::uint32_t r);

  void spend_budget(std::shared_lock<std::shared_mutex>& lock);
  void choose_blocks(OrderCode key);
  void order_records();
  [[nodiscard]] bool is_loaded_down_to(OrderCode key) const;
  [[nodiscard]] std::optional<BudgetRank> find_end(const Budget& budget);
  [[nodiscard]] std::optional<BudgetRank> find_counted_end(const Budget& budget, OrderCode reach);
  void move_end(const std::optional<BudgetRank>& end);
  [[nodiscard]] std::size_t place_of(const std::optional<BudgetRank>& rank) const;
  [[nodiscard]] AddedSize size_of(std::uint32_t r) const {
    return added_by(hierarchy_.content().refinement, RecordId{r});
  }
  [[nodiscard]] BudgetRank rank_of(std::uint32_t r) const {
    const file::Content& content = hierarchy_.content();
    return {content.order[r], content.generation[r], r};
  }
  [[nodiscard]] bool is_before_end(std::uint32_t r) const { return !end_ || rank_of(r) < *end_; }

  Hierarchy& hierarchy_;
  const std::vector<file::BlockInfo>& blocks_;
  ResolvedRequest request_; ///< the last one
  bool is_stale_ = true;    ///< what follows is not that of the last request
  BlockSet read_, missing_, promised_read_;
  bool stopped_by_budget_ = false;
  std::optional<Clock::time_point> until_;
  Cancellation* cancellation_ = nullptr;
  bool is_out_of_time_ = false;

  // By block.
  std::vector<char> is_met_; ///< its records are counted in what follows
  std::vector<std::uint32_t> met_, newly_met_;
  std::vector<BlockDemand> promised_demand_, wished_demand_;
  BlockSet is_current_; ///< its wishes are those of the last request; others have none that count beyond the end

  // By record.
  std::vector<std::uint8_t> flags_;
  std::vector<std::uint32_t> uses_; ///< promised itself, wished where that is counted, children that are counted
  std::vector<std::uint32_t> touched_;
  AddedSize counted_size_;            ///< of records with uses
  bool counts_wishes_ = false;        ///< those before the end
  std::vector<AddedSize> candidates_; ///< by order code: records that are wished and have no uses; not when they count
  std::optional<BudgetRank> end_; ///< the first record that the budget is not spent on; none: there is no such record
  std::vector<std::uint32_t> in_order_; ///< the records of the blocks met so far
  bool is_ordered_ = true;

  std::vector<std::uint32_t> open_, leaving_; // scratch
  WantsOfBlock here_;
  WantedRecords found_;
  BlockSet asked_for_;
  BlocksByOrder by_key_;
  std::vector<std::uint32_t> bucket_, by_generation_;
};

} // namespace ptet
