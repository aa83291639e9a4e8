#include "lod/running_cut.hpp"

#include <algorithm>

namespace ptet {

RunningCut::RunningCut(Hierarchy& hierarchy)
    : hierarchy_(hierarchy), blocks_(hierarchy.blocks()), read_(blocks_.size(), 0), missing_(blocks_.size(), 0),
      promised_read_(blocks_.size(), 0), is_met_(blocks_.size(), 0),
      promised_demand_(blocks_.size(), BlockDemand::kNone), wished_demand_(blocks_.size(), BlockDemand::kNone),
      is_current_(blocks_.size(), 0), flags_(hierarchy.header().record_count, 0),
      uses_(hierarchy.header().record_count, 0), candidates_(kMaxOrderCode + std::size_t{1}) {}

RunningCut::~RunningCut() {
  hierarchy_.loader().forget_asker(this);
}

std::shared_lock<std::shared_mutex> RunningCut::set(const ResolvedRequest& request,
                                                    const std::optional<Clock::time_point>& until,
                                                    Cancellation* cancellation) {
  until_ = until;
  cancellation_ = cancellation;
  is_out_of_time_ = false;
  const bool promised_changed = is_stale_ || request.demand.promised != request_.demand.promised;
  if (is_stale_ || request.demand.wished != request_.demand.wished)
    std::fill(is_current_.begin(), is_current_.end(), char{0});
  is_stale_ = true;
  if (counts_wishes_ == request.demand.wished.are_closed()) withdraw_wishes();
  counts_wishes_ = !request.demand.wished.are_closed();
  request_ = request;
  request_.budgets.max_seconds.reset();
  stopped_by_budget_ = false;
  std::fill(missing_.begin(), missing_.end(), char{0});

  const Demand& demand = request_.demand;
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    promised_read_[b] = demand.promised.demand_in(blocks_[b]) == BlockDemand::kNone ? 0 : 1;
  hierarchy_.close(promised_read_, open_);
  read_ = promised_read_;
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    if (request_.origins ||
        (!request_.budgets.limits_size() && demand.wished.demand_in(blocks_[b]) != BlockDemand::kNone))
      read_[b] = 1;
  read_closed(read_);
  std::shared_lock lock = hierarchy_.lock();
  meet_new_blocks();
  update_promised(promised_changed ? met_ : newly_met_);
  if (request_.budgets.limits_size()) {
    spend_budget(lock);
  } else {
    update_wished(0);
    move_end(std::nullopt);
  }
  is_stale_ = false;
  return lock;
}

void RunningCut::read_closed(BlockSet& set) {
  hierarchy_.close(set, open_);
  asked_for_ = set;
  hierarchy_.loader().leave_out_failed(set, missing_);
  if (is_out_of_time_)
    hierarchy_.loader().keep_loaded(set);
  else if (until_)
    is_out_of_time_ = !hierarchy_.loader().load(set, *until_, cancellation_, this);
  else
    hierarchy_.loader().load(set, cancellation_, this);
  for (std::size_t b = 0; b < set.size(); ++b)
    if (set[b] != asked_for_[b]) missing_[b] = 1;
}

// By what is loaded, not by what was asked for: other sessions read blocks, too.
bool RunningCut::meet_new_blocks() {
  newly_met_.clear();
  for (std::uint32_t b = 0; b < blocks_.size(); ++b)
    if (is_met_[b] == 0 && hierarchy_.content().block_loaded[b] != 0) {
      is_met_[b] = 1;
      newly_met_.push_back(b);
    }
  if (newly_met_.empty()) return false;
  met_.insert(met_.end(), newly_met_.begin(), newly_met_.end());
  std::sort(met_.begin(), met_.end());
  is_ordered_ = false;
  return true;
}

// ---- promises ----

// Comes first, then goes: what the old and the new request have in common is not taken out and put in again.
void RunningCut::update_promised(std::span<const std::uint32_t> which) {
  leaving_.clear();
  for (const std::uint32_t b : which) {
    request_.demand.promised.narrow_to(blocks_[b], here_);
    const BlockDemand now = here_.demand();
    const BlockDemand before = std::exchange(promised_demand_[b], now);
    if (now == before && now != BlockDemand::kSome) continue;
    here_.find(hierarchy_, blocks_[b], found_);
    for (std::uint32_t r = blocks_[b].first_record; r < blocks_[b].end_record(); ++r) {
      const bool is_wanted = found_.contain(r);
      if (is_wanted == ((flags_[r] & kPromised) != 0)) continue;
      flags_[r] ^= kPromised;
      if (is_wanted)
        use(r);
      else
        leaving_.push_back(r);
    }
  }
  for (const std::uint32_t r : leaving_)
    release(r);
}

void RunningCut::use(std::uint32_t r) {
  if (uses_[r]++ != 0) return;
  open_.assign(1, r);
  while (!open_.empty()) {
    const std::uint32_t entered = open_.back();
    open_.pop_back();
    touch(entered);
    counted_size_ += size_of(entered);
    if ((flags_[entered] & kWished) != 0 && !counts_wishes_) candidates_[rank_of(entered).key] -= size_of(entered);
    for (const RecordId parent : hierarchy_.content().refinement.parents(RecordId{entered}))
      if (uses_[parent.index()]++ == 0) open_.push_back(parent.index());
  }
}

void RunningCut::release(std::uint32_t r) {
  if (--uses_[r] != 0) return;
  open_.assign(1, r);
  while (!open_.empty()) {
    const std::uint32_t left = open_.back();
    open_.pop_back();
    touch(left);
    counted_size_ -= size_of(left);
    if ((flags_[left] & kWished) != 0 && !counts_wishes_) candidates_[rank_of(left).key] += size_of(left);
    for (const RecordId parent : hierarchy_.content().refinement.parents(RecordId{left}))
      if (--uses_[parent.index()] == 0) open_.push_back(parent.index());
  }
}

void RunningCut::touch(std::uint32_t r) {
  if ((flags_[r] & kTouched) != 0) return;
  flags_[r] |= kTouched;
  touched_.push_back(r);
}

// ---- wishes ----

void RunningCut::update_wished(OrderCode key) {
  leaving_.clear();
  for (const std::uint32_t b : met_) {
    if (is_current_[b] != 0 || blocks_[b].max_order < key) continue;
    is_current_[b] = 1;
    request_.demand.wished.narrow_to(blocks_[b], here_);
    const BlockDemand now = here_.demand();
    const BlockDemand before = std::exchange(wished_demand_[b], now);
    if (now == before && now != BlockDemand::kSome) continue;
    here_.find(hierarchy_, blocks_[b], found_);
    for (std::uint32_t r = blocks_[b].first_record; r < blocks_[b].end_record(); ++r) {
      const bool is_wished = found_.contain(r);
      if (is_wished == ((flags_[r] & kWished) != 0)) continue;
      flags_[r] ^= kWished;
      if (counts_wishes_) {
        if (!is_before_end(r)) continue;
        if (is_wished)
          use(r);
        else
          leaving_.push_back(r);
        continue;
      }
      touch(r);
      if (uses_[r] != 0) continue;
      if (is_wished)
        candidates_[rank_of(r).key] += size_of(r);
      else
        candidates_[rank_of(r).key] -= size_of(r);
    }
  }
  for (const std::uint32_t r : leaving_)
    release(r);
}

// Those of the next request are not counted, or not found, in the same way.
void RunningCut::withdraw_wishes() {
  const std::shared_lock lock = hierarchy_.lock();
  for (const std::uint32_t b : met_)
    for (std::uint32_t r = blocks_[b].first_record; r < blocks_[b].end_record(); ++r) {
      if ((flags_[r] & kWished) == 0) continue;
      flags_[r] ^= kWished;
      if (!counts_wishes_)
        touch(r);
      else if (is_before_end(r))
        release(r);
    }
  std::fill(wished_demand_.begin(), wished_demand_.end(), BlockDemand::kNone);
  std::fill(is_current_.begin(), is_current_.end(), char{0});
  std::fill(candidates_.begin(), candidates_.end(), AddedSize{});
  end_.reset();
}

// ---- budgets ----

// As find_cut does: blocks in the order of their largest key, until no unread one can hold a record that comes before
// the first that does not fit.
void RunningCut::spend_budget(std::shared_lock<std::shared_mutex>& lock) {
  const Budget budget(hierarchy_, request_.budgets);
  by_key_.clear();
  for (std::uint32_t b = 0; b < blocks_.size(); ++b)
    if (request_.demand.wished.demand_in(blocks_[b]) != BlockDemand::kNone)
      by_key_.emplace_back(blocks_[b].max_order, b);
  std::sort(by_key_.rbegin(), by_key_.rend());
  std::uint64_t expected = budget.expected_records(counted_size_);
  OrderCode reach = budget.key_of_rank(by_key_, expected);
  // Where the last budget ended, this one is likely to end.
  if (end_ && end_->key < reach && is_loaded_down_to(end_->key)) reach = end_->key;
  while (true) {
    lock.unlock();
    choose_blocks(reach);
    read_closed(read_);
    lock = hierarchy_.lock();
    if (meet_new_blocks()) update_promised(newly_met_);
    const bool has_read_all =
        by_key_.empty() || reach <= by_key_.back().first || is_out_of_time_ || hierarchy_.loader().waits_for(missing_);
    if (has_read_all) reach = 0;
    const std::optional<BudgetRank> end = counts_wishes_ ? find_counted_end(budget, reach) : find_end(budget);
    if (has_read_all || (end && end->key >= reach)) {
      move_end(end);
      stopped_by_budget_ = end.has_value() || !budget.fits(counted_size_); // what is promised may not fit either
      choose_blocks(end ? end->key : OrderCode{0});
      // Blocks that could not be had on the way here, but are not needed in the end, are not missing.
      if (!request_.origins) std::fill(missing_.begin(), missing_.end(), char{0});
      for (std::size_t b = 0; b < read_.size(); ++b)
        if (read_[b] != 0 && hierarchy_.content().block_loaded[b] == 0) {
          missing_[b] = 1;
          read_[b] = 0;
        }
      return;
    }
    expected *= 2;
    reach =
        end ? end->key : std::min<OrderCode>(budget.key_of_rank(by_key_, expected), static_cast<OrderCode>(reach - 1));
  }
}

// Into read_: those of what is promised, and those that may hold a record of order code `key` or larger; closed.
void RunningCut::choose_blocks(OrderCode key) {
  if (request_.origins) return;
  read_ = promised_read_;
  for (const auto& [block_key, b] : by_key_)
    if (block_key >= key) read_[b] = 1;
  hierarchy_.close(read_, open_);
}

// By BudgetRank: counting sorts by generation and then by order code, both stable, of records that ascend to begin
// with.
void RunningCut::order_records() {
  if (is_ordered_) return;
  const file::Content& content = hierarchy_.content();
  by_generation_.clear();
  std::uint32_t generations = 0;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    if (is_met_[b] == 0) continue;
    const std::uint32_t first = blocks_[b].first_record;
    for (std::uint32_t r = first; r < first + blocks_[b].record_count; ++r) {
      by_generation_.push_back(r);
      generations = std::max(generations, content.generation[r] + 1);
    }
  }
  in_order_.resize(by_generation_.size());
  const auto sort_by = [&](const std::vector<std::uint32_t>& from, std::vector<std::uint32_t>& to, std::size_t keys,
                           const auto& key_of) {
    bucket_.assign(keys + 1, 0);
    for (const std::uint32_t r : from)
      ++bucket_[key_of(r) + 1];
    for (std::size_t key = 1; key < bucket_.size(); ++key)
      bucket_[key] += bucket_[key - 1];
    for (const std::uint32_t r : from)
      to[bucket_[key_of(r)]++] = r;
  };
  sort_by(by_generation_, in_order_, generations, [&](std::uint32_t r) { return content.generation[r]; });
  by_generation_.swap(in_order_);
  sort_by(by_generation_, in_order_, kMaxOrderCode + std::size_t{1},
          [&](std::uint32_t r) { return static_cast<std::uint32_t>(kMaxOrderCode - content.order[r]); });
  is_ordered_ = true;
}

std::size_t RunningCut::place_of(const std::optional<BudgetRank>& rank) const {
  if (!rank) return in_order_.size();
  const auto found =
      std::partition_point(in_order_.begin(), in_order_.end(), [&](std::uint32_t r) { return rank_of(r) < *rank; });
  return static_cast<std::size_t>(found - in_order_.begin());
}

bool RunningCut::is_loaded_down_to(OrderCode key) const {
  return std::none_of(by_key_.begin(), by_key_.end(), [&](const auto& block) {
    return block.first >= key && hierarchy_.content().block_loaded[block.second] == 0;
  });
}

// The first candidate that does not fit on top of what is counted and of those before it.
std::optional<BudgetRank> RunningCut::find_end(const Budget& budget) {
  update_wished(0);
  order_records();
  AddedSize size = counted_size_;
  std::size_t key = candidates_.size();
  while (key > 0) {
    AddedSize larger = size;
    larger += candidates_[key - 1];
    if (candidates_[key - 1].records > 0 && !budget.fits(larger)) break;
    size = larger;
    --key;
  }
  if (key == 0) return std::nullopt;
  BudgetRank last{static_cast<OrderCode>(key - 1), 0, 0};
  for (std::size_t i = place_of(last); i < in_order_.size(); ++i) {
    const std::uint32_t r = in_order_[i];
    if ((flags_[r] & kWished) == 0 || uses_[r] != 0) continue;
    last = rank_of(r);
    if (!budget.fits(size += size_of(r))) break;
  }
  return last;
}

// The first candidate that does not fit on top of what is counted, none when all with an order code of `reach` or more
// do; the end is then there, or before the others.
std::optional<BudgetRank> RunningCut::find_counted_end(const Budget& budget, OrderCode reach) {
  std::optional<BudgetRank> last;
  if (reach > 0) last = BudgetRank{static_cast<OrderCode>(reach - 1), 0, 0};
  if (last && (!end_ || *last < *end_)) move_end(last);
  update_wished(reach);
  order_records();
  std::size_t i = place_of(end_);
  while (i > 0 && !budget.fits(counted_size_))
    if (const std::uint32_t r = in_order_[--i]; (flags_[r] & kWished) != 0) release(r);
  for (const std::size_t past = place_of(last); i < past; ++i) {
    const std::uint32_t r = in_order_[i];
    if ((flags_[r] & kWished) == 0) continue;
    const bool is_larger = uses_[r] == 0;
    use(r);
    if (!is_larger || budget.fits(counted_size_)) continue;
    release(r);
    end_ = rank_of(r);
    return end_;
  }
  end_ = last;
  return std::nullopt;
}

void RunningCut::move_end(const std::optional<BudgetRank>& end) {
  if (end || end_) {
    order_records();
    const std::size_t from = place_of(end_), to = place_of(end);
    for (std::size_t i = std::min(from, to); i < std::max(from, to); ++i) {
      const std::uint32_t r = in_order_[i];
      if ((flags_[r] & kWished) == 0) continue;
      if (!counts_wishes_)
        touch(r);
      else if (from < to)
        use(r);
      else
        release(r);
    }
  }
  end_ = end;
}

} // namespace ptet
