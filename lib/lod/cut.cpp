#include "lod/cut.hpp"

#include "lod/block_reading.hpp"
#include "lod/budget.hpp"

#include <algorithm>

namespace ptet {
namespace {

/// What the cut adds to the base mesh, as it grows.
class Spending {
public:
  Spending(const Hierarchy& hierarchy, const Budget& budget) : hierarchy_(hierarchy), budget_(budget) {}

  void add(std::uint32_t record) { size_ += added_by(hierarchy_.content().refinement, RecordId{record}); }
  void remove(std::uint32_t record) { size_ -= added_by(hierarchy_.content().refinement, RecordId{record}); }
  [[nodiscard]] bool fits() const { return budget_.fits(size_); }
  [[nodiscard]] std::uint64_t tets() const { return hierarchy_.header().base_tet_count + size_.tets; }
  [[nodiscard]] std::uint64_t expected_records() const { return budget_.expected_records(size_); }

private:
  const Hierarchy& hierarchy_;
  const Budget& budget_;
  AddedSize size_;
};

class CutSearch {
public:
  CutSearch(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress)
      : hierarchy_(hierarchy), request_(request), budget_(hierarchy, request.budgets), blocks_(hierarchy.blocks()),
        reading_(hierarchy, request, progress) {}

  FoundCut run() {
    Lock lock = search();
    if (request_.origins) read_origins(lock);
    cut_.count = static_cast<std::uint32_t>(std::count(cut_.applied.begin(), cut_.applied.end(), 1));
    const bool is_whole = cut_.count == cut_.applied.size();
    cut_.limited_by = reading_.is_time_up() && !is_whole ? LimitedBy::kTime
                      : stopped_by_budget_               ? LimitedBy::kBudget
                      : is_whole                         ? LimitedBy::kNothing
                                                         : request_.when_met;
    return {std::move(cut_), std::move(lock)};
  }

private:
  using BlockDemands = std::vector<WantsOfBlock>;
  using Lock = std::shared_lock<std::shared_mutex>;

  /// Which records are in the cut is found under one lock, the one that it returns: what was read for it may be gone
  /// under another.
  Lock search() {
    stopped_by_budget_ = false;
    const Demand& demand = request_.demand;
    const BlockDemands promised = demands_of(demand.promised), wished = demands_of(demand.wished);
    cut_.missing.assign(blocks_.size(), 0);
    cut_.read = blocks_of(promised);
    if (request_.budgets.any()) {
      read_promised();
      return spend(promised, wished);
    }
    unite(cut_.read, blocks_of(wished));
    read();
    Lock lock = hierarchy_.lock();
    keep_loaded();
    apply_promised(promised, cut_.read);
    apply(wished, cut_.read);
    if (!demand.wished.are_closed()) close_over_parents();
    return lock;
  }

  /// Reads all of the file. Where what the cut was found from is gone then, as the loading thread may drop it where
  /// memory is limited, it is found again; and if need be left at that.
  void read_origins(Lock& lock) {
    constexpr int kMostTries = 4;
    for (int tries = 1; tries <= kMostTries; ++tries) {
      const BlockSet found_from = cut_.read;
      lock.unlock();
      cut_.read.assign(blocks_.size(), 1);
      read();
      lock = hierarchy_.lock();
      keep_loaded();
      if (is_subset(found_from, cut_.read)) return;
      lock.unlock();
      lock = search();
    }
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      if (cut_.read[b] == 0) cut_.missing[b] = 1;
  }

  void read() { reading_.read(cut_.read, cut_.missing); }
  void keep_loaded() { reading_.keep_loaded(cut_.read, cut_.missing); }

  /// Reads the blocks of what is promised, as far as there is time.
  void read_promised() {
    if (!request_.budgets.max_seconds) return read();
    const BlocksByOrder by_key = in_order(cut_.read);
    cut_.read.assign(blocks_.size(), 0);
    reading_.read_in_time(cut_.read, cut_.missing, by_key, 0, 0);
  }

  // ---- what is demanded ----

  BlockDemands demands_of(const Wants& wants) const {
    BlockDemands demands(blocks_.size());
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      wants.narrow_to(blocks_[b], demands[b]);
    return demands;
  }
  static BlockSet blocks_of(const BlockDemands& demands) {
    BlockSet set;
    set.reserve(demands.size());
    for (const WantsOfBlock& wants : demands)
      set.push_back(wants.demand() != BlockDemand::kNone ? 1 : 0);
    return set;
  }

  const file::Content& content() const { return hierarchy_.content(); }

  template <class F>
  void for_each_wanted(const WantsOfBlock& wants, const file::BlockInfo& block, F&& f) {
    if (wants.demand() == BlockDemand::kNone) return;
    wants.find(hierarchy_, block, found_);
    for (std::uint32_t r = block.first_record; r < block.end_record(); ++r)
      if (found_.contain(r)) f(r);
  }
  void apply(const BlockDemands& demands, const BlockSet& blocks) {
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      if (blocks[b] != 0) for_each_wanted(demands[b], blocks_[b], [&](std::uint32_t r) { cut_.applied[r] = 1; });
  }
  /// Nothing but what is promised, closed; where time is short, the coarser part of it.
  void apply_promised(const BlockDemands& promised, const BlockSet& blocks) {
    cut_.applied.assign(hierarchy_.header().record_count, 0);
    if (request_.demand.promised.empty()) return;
    if (request_.budgets.max_seconds) {
      take_down_to(0, promised, blocks, Until::kLate);
    } else {
      apply(promised, blocks);
      close_over_parents();
    }
  }

  void close_over_parents() {
    std::vector<std::uint32_t> open;
    for (std::uint32_t r = 0; r < cut_.applied.size(); ++r)
      if (cut_.applied[r] != 0) open.push_back(r);
    while (!open.empty()) {
      const RecordId r{open.back()};
      open.pop_back();
      for (const RecordId parent : content().refinement.parents(r))
        if (std::exchange(cut_.applied[parent.index()], 1) == 0) open.push_back(parent.index());
    }
  }

  // ---- budgets ----

  static constexpr std::uint32_t kNoKey = kMaxOrderCode + 1;

  BlocksByOrder in_order(const BlockSet& set) const {
    BlocksByOrder by_key;
    for (std::uint32_t b = 0; b < blocks_.size(); ++b)
      if (set[b] != 0) by_key.emplace_back(blocks_[b].max_order, b);
    std::sort(by_key.rbegin(), by_key.rend());
    return by_key;
  }

  // What is promised stands whatever it takes; the budget decides what else is refined.
  //
  // Reads blocks in the order of their largest key until no unread one can hold a record that comes before the first
  // that does not fit. The lock that it returns is that of the last look.
  Lock spend(const BlockDemands& promised, const BlockDemands& wished) {
    const BlocksByOrder by_key = in_order(blocks_of(wished));
    const BlockSet promised_blocks = cut_.read, promised_missing = cut_.missing;
    Lock lock = hierarchy_.lock();
    keep_loaded();
    apply_promised(promised, cut_.read);
    if (reading_.is_time_up() && reading_.may_load()) return lock;
    const BlockSet applied_from = cut_.read;
    const std::vector<char> applied_first = cut_.applied;
    std::uint64_t expected = spent_on(cut_.applied).expected_records();
    lock.unlock();
    // Every wanted record with a key of at least `reach` is in memory.
    std::uint32_t reach = budget_.key_of_rank(by_key, expected);
    while (true) {
      reach = read_down_to(reach, by_key, promised_blocks);
      const bool has_read_all =
          by_key.empty() || reach <= by_key.back().first || hierarchy_.loader().waits_for(cut_.missing);
      if (has_read_all) reach = 0;
      lock = hierarchy_.lock();
      keep_loaded();
      BlockSet promised_read = promised_blocks;
      intersect(promised_read, cut_.read);
      if (promised_read == applied_from)
        cut_.applied = applied_first;
      else
        apply_promised(promised, promised_read);
      const bool promised_fits = spent_on(cut_.applied).fits();
      const std::uint32_t stop = take_down_to(reach, wished, cut_.read, Until::kFull);
      if (stop != kNoKey || has_read_all || reading_.is_time_up()) {
        stopped_by_budget_ = stop != kNoKey || !promised_fits;
        // Blocks that were read, or could not be had, on the way here do not count, only those that the end of the
        // budget depends on: the answer must be the same when more was in memory before.
        if (!reading_.is_time_up()) {
          cut_.read = blocks_above(stop != kNoKey ? stop : reach, by_key, promised_blocks);
          cut_.missing = promised_missing;
          keep_loaded();
        }
        return lock;
      }
      lock.unlock();
      expected *= 2;
      reach = std::min<std::uint32_t>(budget_.key_of_rank(by_key, expected), reach - 1);
    }
  }

  Spending spent_on(const std::vector<char>& applied) const {
    Spending spending(hierarchy_, budget_);
    for (std::uint32_t r = 0; r < applied.size(); ++r)
      if (applied[r] != 0) spending.add(r);
    return spending;
  }

  BlockSet blocks_above(std::uint32_t key, const BlocksByOrder& by_key, const BlockSet& promised) const {
    BlockSet set = promised;
    for (const auto& [block_key, b] : by_key)
      if (block_key >= key) set[b] = 1;
    hierarchy_.close(set);
    return set;
  }

  /// Returns down to which key records may be taken: `reach`, or all of what was read when the time was up.
  std::uint32_t read_down_to(std::uint32_t reach, const BlocksByOrder& by_key, const BlockSet& promised) {
    if (!request_.budgets.max_seconds) {
      cut_.read = blocks_above(reach, by_key, promised);
      read();
      return reach;
    }
    constexpr std::uint64_t kTetsPerVertex = 6;
    cut_.read = promised;
    reading_.read_in_time(cut_.read, cut_.missing, by_key, reading_.may_load() ? reach : 0, kTetsPerVertex);
    // With no time left the answer need not be the builder's mesh: all that was read is taken.
    return reading_.is_time_up() ? 0 : reach;
  }

  enum class Until { kFull, kLate }; ///< how long to take records: as long as they fit and there is time; or the latter

  // Takes the wanted records of `blocks` whose key is at least `reach`, each with all that it needs, in their order.
  // Returns the key of the first that does not fit, or none. A block is looked at when its first record may be next, so
  // that what ends soon has not looked at much.
  std::uint32_t take_down_to(std::uint32_t reach, const BlockDemands& demands, const BlockSet& blocks, Until until) {
    constexpr std::size_t kBetweenLooks = 256; // at the clock
    Spending spending = spent_on(cut_.applied);
    bool is_too_late = false;
    const auto look_at_clock = [&] { return is_too_late = reading_.is_late(spending.tets()); };
    const BlocksByOrder by_key = in_order(blocks);
    auto block = by_key.begin();
    std::vector<std::vector<BudgetRank>> with_key(kNoKey);
    std::vector<std::uint32_t> taken;
    for (std::uint32_t key = kNoKey; key-- > reach && !look_at_clock();) {
      for (; block != by_key.end() && block->first >= key && !look_at_clock(); ++block)
        for_each_wanted(demands[block->second], blocks_[block->second], [&](std::uint32_t r) {
          if (cut_.applied[r] == 0 && content().order[r] >= reach)
            with_key[content().order[r]].push_back({content().order[r], content().generation[r], r});
        });
      // All records of a key are taken at once; only those of the key at which the budget ends must be sorted.
      taken.clear();
      for (std::size_t i = 0; i < with_key[key].size() && !is_too_late; ++i) {
        take(with_key[key][i].record, spending, taken);
        if (i % kBetweenLooks == kBetweenLooks - 1) look_at_clock();
      }
      if (taken.empty() || until == Until::kLate || spending.fits()) continue;
      give_back(spending, taken);
      if (is_too_late) break;
      std::sort(with_key[key].begin(), with_key[key].end());
      for (const BudgetRank& candidate : with_key[key]) {
        taken.clear();
        take(candidate.record, spending, taken);
        if (taken.empty() || spending.fits()) continue;
        give_back(spending, taken);
        return key;
      }
    }
    if (is_too_late) reading_.note_time_is_up();
    return kNoKey;
  }

  /// Applies the record and all that it needs; appends what was not applied before to `taken`.
  void take(std::uint32_t record, Spending& spending, std::vector<std::uint32_t>& taken) {
    const auto add = [&](std::uint32_t r) {
      if (std::exchange(cut_.applied[r], 1) != 0) return;
      spending.add(r);
      taken.push_back(r);
    };
    std::size_t next = taken.size();
    add(record);
    for (; next < taken.size(); ++next)
      for (const RecordId parent : content().refinement.parents(RecordId{taken[next]}))
        add(parent.index());
  }
  void give_back(Spending& spending, const std::vector<std::uint32_t>& taken) {
    for (const std::uint32_t r : taken) {
      cut_.applied[r] = 0;
      spending.remove(r);
    }
  }

  Hierarchy& hierarchy_;
  WantedRecords found_; // scratch
  const ResolvedRequest& request_;
  const Budget budget_;
  const std::vector<file::BlockInfo>& blocks_;
  BlockReading reading_;
  Cut cut_;
  bool stopped_by_budget_ = false;
};

} // namespace

FoundCut find_cut(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress) {
  return CutSearch(hierarchy, request, progress).run();
}

} // namespace ptet
