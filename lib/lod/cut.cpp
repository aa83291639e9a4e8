#include "lod/cut.hpp"

#include "lod/budget.hpp"
#include "lod/demand.hpp"

#include <algorithm>

namespace ptet {
namespace {

class CutSearch {
public:
  CutSearch(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress)
      : hierarchy_(hierarchy), request_(request), demand_(hierarchy, request), budget_(hierarchy, request),
        progress_(progress), blocks_(hierarchy.blocks()) {}

  Cut run() {
    const BlockSet focus_blocks = blocks_in_focus();
    BlockSet error_blocks = blocks_by_error();
    cut_.read = focus_blocks;
    if (!request_.has_budget())
      for (std::size_t b = 0; b < blocks_.size(); ++b)
        cut_.read[b] |= error_blocks[b];
    read(cut_.read);
    {
      const auto lock = hierarchy_.lock();
      cut_.applied.assign(hierarchy_.header().record_count, 0);
      add_focus(focus_blocks);
      close_over_parents();
      if (!request_.has_budget()) add_by_error(error_blocks);
    }
    if (request_.has_budget()) spend_budget(error_blocks);
    if (request_.origins) {
      cut_.read.assign(blocks_.size(), 1);
      read(cut_.read);
    }
    cut_.count = static_cast<std::uint32_t>(std::count(cut_.applied.begin(), cut_.applied.end(), 1));
    cut_.limited_by = cut_.count == cut_.applied.size() ? LimitedBy::kNothing
                      : stopped_by_budget_              ? LimitedBy::kBudget
                      : request_.has_bounds()           ? LimitedBy::kError
                                                        : LimitedBy::kFocus;
    return std::move(cut_);
  }

private:
  void read(BlockSet& set) {
    if (progress_ && !progress_({"reading", 0, 0})) throw Error(ErrorCode::kCancelled, "the extraction was cancelled");
    hierarchy_.close(set);
    hierarchy_.load(set);
  }

  // ---- which blocks can matter ----

  BlockSet blocks_in_focus() const {
    BlockSet set(blocks_.size(), 0);
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      set[b] = demand_.focus_of(blocks_[b]) == BlockDemand::kNone ? 0 : 1;
    return set;
  }
  BlockSet blocks_by_error() const {
    BlockSet set(blocks_.size(), 0);
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      set[b] = demand_.asked_of(blocks_[b]) == BlockDemand::kNone ? 0 : 1;
    return set;
  }

  // ---- the sets of records ----

  template <class F>
  void for_each_record(const file::BlockInfo& block, F&& f) const {
    for (std::uint32_t r = block.first_record; r < block.first_record + block.record_count; ++r)
      f(r);
  }
  const file::Content& content() const { return hierarchy_.content(); }

  bool is_wanted(std::uint32_t r) const { return demand_.is_asked(RecordId{r}); }

  // Closed as it is: each monotone error of a parent is at least that of its child.
  void add_by_error(const BlockSet& blocks) {
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      if (blocks[b] != 0)
        for_each_record(blocks_[b], [&](std::uint32_t r) {
          if (is_wanted(r)) cut_.applied[r] = 1;
        });
  }

  void add_focus(const BlockSet& blocks) {
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      if (blocks[b] != 0)
        for_each_record(blocks_[b], [&](std::uint32_t r) {
          if (demand_.is_in_focus(RecordId{r})) cut_.applied[r] = 1;
        });
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

  struct Prefix {
    std::vector<BudgetRank> records;
    bool is_whole = true;
    OrderCode next_key = 0; ///< of the first candidate that does not fit
  };
  // The focus is a promise and stands whatever it takes; the budget decides what else is refined.
  //
  // Reads blocks in the order of their largest key until no unread one can hold a record that comes before the first
  // that does not fit.
  void spend_budget(const BlockSet& eligible) {
    BlocksByOrder by_key;
    for (std::uint32_t b = 0; b < blocks_.size(); ++b)
      if (eligible[b] != 0) by_key.emplace_back(blocks_[b].max_order, b);
    std::sort(by_key.rbegin(), by_key.rend());
    const BlockSet focus_blocks = cut_.read;
    const std::vector<char> focus_records = cut_.applied;
    const auto read_down_to = [&](OrderCode key) {
      cut_.read = focus_blocks;
      for (const auto& [block_key, b] : by_key)
        if (block_key >= key) cut_.read[b] = 1;
      read(cut_.read);
    };

    std::uint64_t expected = budget_.expected_records();
    OrderCode reach = budget_.key_of_rank(by_key, expected);
    while (true) {
      read_down_to(reach);
      const auto lock = hierarchy_.lock();
      const Prefix prefix = longest_prefix(
          focus_records, candidates([&](std::uint32_t r) { return focus_records[r] == 0 && is_wanted(r); }));
      const bool has_read_all = by_key.empty() || reach <= by_key.back().first;
      if (prefix.is_whole ? has_read_all : prefix.next_key >= reach) {
        for (const BudgetRank& candidate : prefix.records)
          cut_.applied[candidate.record] = 1;
        stopped_by_budget_ = !prefix.is_whole;
        // What was read on the way is no matter: the answer is to be the same when more was in memory before.
        const OrderCode last_key = prefix.is_whole ? OrderCode{0} : prefix.next_key;
        cut_.read = focus_blocks;
        for (const auto& [block_key, b] : by_key)
          if (block_key >= last_key) cut_.read[b] = 1;
        hierarchy_.close(cut_.read);
        return;
      }
      expected *= 2;
      reach = prefix.is_whole
                  ? std::min<OrderCode>(budget_.key_of_rank(by_key, expected), static_cast<OrderCode>(reach - 1))
                  : prefix.next_key;
    }
  }

  template <class Wanted>
  std::vector<BudgetRank> candidates(Wanted&& wanted) const {
    std::vector<BudgetRank> found;
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      if (content().block_loaded[b] != 0)
        for_each_record(blocks_[b], [&](std::uint32_t r) {
          if (wanted(r)) found.push_back({content().order[r], content().generation[r], r});
        });
    return found;
  }

  [[nodiscard]] AddedSize with(AddedSize size, std::uint32_t record) const {
    return size += {1, content().refinement.added_tet_count(RecordId{record})};
  }

  // The longest prefix of the candidates' order that fits. Only those with the key at which it ends need be sorted.
  Prefix longest_prefix(const std::vector<char>& in_focus, const std::vector<BudgetRank>& candidates) const {
    AddedSize size;
    for (std::uint32_t r = 0; r < in_focus.size(); ++r)
      if (in_focus[r] != 0) size = with(size, r);
    std::vector<AddedSize> with_key(kMaxOrderCode + std::size_t{1});
    for (const BudgetRank& candidate : candidates)
      with_key[candidate.key] = with(with_key[candidate.key], candidate.record);

    Prefix prefix;
    std::size_t key = with_key.size();
    while (key > 0) {
      AddedSize larger = size;
      larger += with_key[key - 1];
      if (with_key[key - 1].records > 0 && !budget_.fits(larger)) break;
      size = larger;
      --key;
    }
    std::vector<BudgetRank> last;
    for (const BudgetRank& candidate : candidates) {
      if (candidate.key >= key) prefix.records.push_back(candidate);
      if (candidate.key + std::size_t{1} == key) last.push_back(candidate);
    }
    if (last.empty()) return prefix;
    std::sort(last.begin(), last.end());
    for (const BudgetRank& candidate : last) {
      size = with(size, candidate.record);
      if (!budget_.fits(size)) break;
      prefix.records.push_back(candidate);
    }
    prefix.is_whole = false;
    prefix.next_key = last.front().key;
    return prefix;
  }

  Hierarchy& hierarchy_;
  const ResolvedRequest& request_;
  const Demand demand_;
  const Budget budget_;
  const ProgressCallback& progress_;
  const std::vector<file::BlockInfo>& blocks_;
  Cut cut_;
  bool stopped_by_budget_ = false;
};

} // namespace

Cut find_cut(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress) {
  return CutSearch(hierarchy, request, progress).run();
}

std::string validate(const Cut& cut, const Refinement& refinement) {
  for (std::uint32_t r = 0; r < cut.applied.size(); ++r) {
    if (cut.applied[r] == 0) continue;
    if (!refinement.applied(RecordId{r})) return "record " + std::to_string(r) + " is in the cut but was not read";
    for (const RecordId parent : refinement.parents(RecordId{r}))
      if (cut.applied[parent.index()] == 0)
        return "record " + std::to_string(r) + " is in the cut, its parent " + std::to_string(parent.index()) +
               " is not";
  }
  return {};
}

} // namespace ptet
