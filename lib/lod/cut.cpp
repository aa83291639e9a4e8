#include "lod/cut.hpp"

#include "lod/budget.hpp"
#include "lod/pace_of_loading.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>

namespace ptet {
namespace {

using Clock = std::chrono::steady_clock;

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
      : hierarchy_(hierarchy), request_(request), budget_(hierarchy, request.budgets), progress_(progress),
        cancellation_(progress), blocks_(hierarchy.blocks()), begin_(Clock::now()) {}

  FoundCut run() {
    cancellation_.check();
    const Loader::Turn turn(hierarchy_.loader(), until(), progress_ ? &cancellation_ : nullptr);
    may_load_ = turn.has_come();
    Lock lock = search();
    if (request_.origins) read_origins(lock);
    cut_.count = static_cast<std::uint32_t>(std::count(cut_.applied.begin(), cut_.applied.end(), 1));
    const bool is_whole = cut_.count == cut_.applied.size();
    cut_.limited_by = is_time_up_ && !is_whole ? LimitedBy::kTime
                      : stopped_by_budget_     ? LimitedBy::kBudget
                      : is_whole               ? LimitedBy::kNothing
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
    const BlockSet more = blocks_of(wished);
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      cut_.read[b] |= more[b];
    read(cut_.read);
    Lock lock = hierarchy_.lock();
    keep_loaded(cut_.read);
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
      read(cut_.read);
      lock = hierarchy_.lock();
      keep_loaded(cut_.read);
      if (is_subset(found_from, cut_.read)) return;
      lock.unlock();
      lock = search();
    }
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      if (cut_.read[b] == 0) cut_.missing[b] = 1;
  }

  /// Of a set that was read, what is loaded now; the rest is missing. The lock must be held.
  void keep_loaded(BlockSet& set) {
    for (std::size_t b = 0; b < set.size(); ++b)
      if (set[b] != 0 && content().block_loaded[b] == 0) {
        set[b] = 0;
        cut_.missing[b] = 1;
      }
  }

  void read(BlockSet& set) {
    cancellation_.check();
    if (!may_load_) {
      hierarchy_.loader().keep_loaded(set);
      is_time_up_ = true;
      return;
    }
    hierarchy_.close(set);
    const BlockSet wanted = set;
    if (!request_.budgets.max_seconds) hierarchy_.loader().leave_out_failed(set, cut_.missing); // else see read_in_time
    if (!hierarchy_.loader().load_when_free(set, until(), progress_ ? &cancellation_ : nullptr)) {
      is_time_up_ = true; // what was left unread for want of time does not count as missing
      return;
    }
    for (std::size_t b = 0; b < set.size(); ++b) // both ways: what was missing before may be there now
      if (wanted[b] != 0) cut_.missing[b] = set[b] == 0 ? 1 : 0;
  }
  /// Until when to wait for another thread that loads. None: as long as it takes, as with origins, for which all of the
  /// file is read whatever the time.
  [[nodiscard]] std::optional<Clock::time_point> until() const {
    constexpr double kMost = 1e6;
    if (!request_.budgets.max_seconds || request_.origins) return std::nullopt;
    return begin_ + std::chrono::duration_cast<Clock::duration>(
                        std::chrono::duration<double>(std::min(*request_.budgets.max_seconds, kMost)));
  }

  // ---- time ----

  /// Whether it is time to stop: a mesh of so many tets can only just be put out in what time is left.
  [[nodiscard]] bool is_late(std::uint64_t tets, double grace = 0) const {
    if (!request_.budgets.max_seconds) return false;
    return seconds_left(tets) + grace <= 0;
  }
  /// Seconds more than there are for making something of what was read, where reading took all of them; without limit
  /// where others read all the time: what is there is there.
  [[nodiscard]] double grace_for_taking() const {
    constexpr double kPart = 0.25;
    if (!may_load_) return std::numeric_limits<double>::infinity();
    return is_time_up_ && request_.budgets.max_seconds ? kPart * *request_.budgets.max_seconds : 0;
  }
  /// The seconds left for reading, when a mesh of so many tets is to be put out afterwards.
  [[nodiscard]] double seconds_left(std::uint64_t tets) const {
    constexpr double kSecondsPerTet = 40e-9; // from the cut to the mesh, as a rule
    const double passed = std::chrono::duration<double>(Clock::now() - begin_).count();
    return *request_.budgets.max_seconds - passed - kSecondsPerTet * static_cast<double>(tets);
  }

  /// Reads the blocks of what is promised, as far as there is time.
  void read_promised() {
    if (!request_.budgets.max_seconds) return read(cut_.read);
    const BlocksByOrder by_key = in_order(cut_.read);
    cut_.read.assign(blocks_.size(), 0);
    read_in_time(by_key, 0, 0);
  }

  /// The blocks with a key of at least `reach`, but for those in `set`: those that others need before these.
  std::vector<std::uint32_t> needs_first(const BlocksByOrder& by_key, std::uint32_t reach, BlockSet set) const {
    const BlockSet none(blocks_.size(), 0);
    std::vector<std::uint32_t> order;
    for (const auto& [key, b] : by_key) {
      if (key < reach) break;
      if (set[b] != 0) continue;
      std::vector<std::uint32_t> added = hierarchy_.loader().needs().add(set, b, none);
      std::sort(added.begin(), added.end());
      order.insert(order.end(), added.begin(), added.end());
    }
    return order;
  }

  /// Adds to cut_.read, which stays closed, the blocks with a key of at least `reach`, largest first, until the time is
  /// up. As many are read at once as it seems there is time for. `tets_per_record`: how much a record adds to the mesh
  /// that is to be put out afterwards. What could not be had is tried once more.
  void read_in_time(const BlocksByOrder& by_key, std::uint32_t reach, std::uint64_t tets_per_record) {
    const bool has_lost = try_to_read_in_time(by_key, reach, tets_per_record);
    if (has_lost && !is_time_up_ && !hierarchy_.loader().is_in_background())
      try_to_read_in_time(by_key, reach, tets_per_record);
  }
  /// Returns whether there are blocks that could not be had.
  bool try_to_read_in_time(const BlocksByOrder& by_key, std::uint32_t reach, std::uint64_t tets_per_record) {
    const bool waits = !hierarchy_.loader().is_in_background();
    const std::vector<std::uint32_t> order = needs_first(by_key, reach, cut_.read);
    BlockSet loaded(blocks_.size(), 1), lost(blocks_.size(), 0);
    hierarchy_.loader().keep_loaded(loaded);
    if (!may_load_) { // no time is left, but what is there is there
      for (const std::uint32_t b : order)
        if (loaded[b] != 0) cut_.read[b] = 1;
      is_time_up_ = true;
      return false;
    }
    std::uint64_t tets = hierarchy_.header().base_tet_count;
    PaceOfLoading pace;
    for (std::size_t next = 0; next < order.size() && !is_time_up_;) {
      const auto begin = Clock::now();
      PartToLoad part(hierarchy_.loader().needs(), loaded, cut_.read);
      for (; next < order.size(); ++next) {
        if (is_late(tets)) {
          is_time_up_ = true;
          if (waits) part.keep_loaded();
          break;
        }
        if (part.blocks()[order[next]] != 0) continue;
        const auto added = part.add(order[next], lost, waits ? &pace : nullptr);
        if (!added) {
          is_time_up_ = part.work() == 0;
          break;
        }
        if (added->empty()) cut_.missing[order[next]] = 1;
        for (const std::uint32_t b : *added)
          if (waits || loaded[b] != 0) tets += tets_per_record * blocks_[b].record_count;
      }
      cut_.read = part.blocks();
      read(cut_.read);
      for (std::size_t b = 0; b < lost.size(); ++b)
        if (part.blocks()[b] != cut_.read[b]) lost[b] = 1;
      if (part.work() > 0)
        pace.note(part.work(), std::chrono::duration<double>(Clock::now() - begin).count(), seconds_left(tets));
    }
    return std::find(lost.begin(), lost.end(), 1) != lost.end();
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
  void for_each_wanted(const WantsOfBlock& wants, const file::BlockInfo& block, F&& f) const {
    if (wants.demand() == BlockDemand::kNone) return;
    for (std::uint32_t r = block.first_record; r < block.end_record(); ++r)
      if (wants.wants(hierarchy_, RecordId{r})) f(r);
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
    keep_loaded(cut_.read);
    apply_promised(promised, cut_.read);
    if (is_time_up_ && may_load_) return lock;
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
      keep_loaded(cut_.read);
      BlockSet promised_read = promised_blocks;
      intersect(promised_read, cut_.read);
      if (promised_read == applied_from)
        cut_.applied = applied_first;
      else
        apply_promised(promised, promised_read);
      const bool promised_fits = spent_on(cut_.applied).fits();
      const std::uint32_t stop = take_down_to(reach, wished, cut_.read, Until::kFull);
      if (stop != kNoKey || has_read_all || is_time_up_) {
        stopped_by_budget_ = stop != kNoKey || !promised_fits;
        // Blocks that were read, or could not be had, on the way here do not count, only those that the end of the
        // budget depends on: the answer must be the same when more was in memory before.
        if (!is_time_up_) {
          cut_.read = blocks_above(stop != kNoKey ? stop : reach, by_key, promised_blocks);
          cut_.missing = promised_missing;
          keep_loaded(cut_.read);
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
      read(cut_.read);
      return reach;
    }
    constexpr std::uint64_t kTetsPerVertex = 6;
    cut_.read = promised;
    read_in_time(by_key, may_load_ ? reach : 0, kTetsPerVertex);
    // With no time left the answer need not be the builder's mesh: all that was read is taken.
    return is_time_up_ ? 0 : reach;
  }

  enum class Until { kFull, kLate }; ///< how long to take records: as long as they fit and there is time; or the latter

  // Takes the wanted records of `blocks` whose key is at least `reach`, each with all that it needs, in their order.
  // Returns the key of the first that does not fit, or none. A block is looked at when its first record may be next, so
  // that what ends soon has not looked at much.
  std::uint32_t take_down_to(std::uint32_t reach, const BlockDemands& demands, const BlockSet& blocks, Until until) {
    constexpr std::size_t kBetweenLooks = 256; // at the clock
    const double grace = grace_for_taking();
    Spending spending = spent_on(cut_.applied);
    bool is_too_late = false;
    const auto look_at_clock = [&] { return is_too_late = is_late(spending.tets(), grace); };
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
    if (is_too_late) is_time_up_ = true;
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
  const ResolvedRequest& request_;
  const Budget budget_;
  const ProgressCallback& progress_;
  Cancellation cancellation_;
  const std::vector<file::BlockInfo>& blocks_;
  const Clock::time_point begin_;
  bool may_load_ = true; ///< but for what is in memory already
  Cut cut_;
  bool stopped_by_budget_ = false;
  bool is_time_up_ = false;
};

} // namespace

FoundCut find_cut(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress) {
  return CutSearch(hierarchy, request, progress).run();
}

} // namespace ptet
