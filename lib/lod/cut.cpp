#include "lod/cut.hpp"

#include "lod/region.hpp"

#include <algorithm>
#include <tuple>

namespace ptet {
namespace {

/// A record in the order in which a budget is spent: the last collapse is undone first, as far as order codes tell.
///
/// Every prefix of the order is closed: the order code of a parent is no less than that of its child, and where they
/// are equal the parent's generation is less.
struct Candidate {
  OrderCode key = 0;
  std::uint32_t generation = 0;
  std::uint32_t record = 0;

  friend bool operator<(const Candidate& a, const Candidate& b) {
    return std::tie(b.key, a.generation, a.record) < std::tie(a.key, b.generation, b.record);
  }
};

class CutSearch {
public:
  CutSearch(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress)
      : hierarchy_(hierarchy), request_(request), progress_(progress), blocks_(hierarchy.blocks()),
        codes_(hierarchy.errors_per_record()) {}

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
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      // Own errors are no larger than the monotone ones that the table knows.
      if (!request_.focus_limits.empty() && !exceeds(blocks_[b].max_error.data(), request_.focus_limits)) continue;
      for (const FocusRegion& region : request_.focus)
        if (meets(region, blocks_[b].box_min, blocks_[b].box_max)) set[b] = 1;
    }
    return set;
  }
  /// Blocks with records that the error bounds ask for; where there is none but a budget to spend, or nothing at all
  /// is asked, every block.
  BlockSet blocks_by_error() const {
    BlockSet set(blocks_.size(), 0);
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      if (request_.has_bounds() ? exceeds(blocks_[b].max_error.data(), request_.limits)
                                : request_.has_budget() || request_.is_original())
        set[b] = 1;
    return set;
  }

  // ---- the sets of records ----

  template <class F>
  void for_each_record(const file::BlockInfo& block, F&& f) const {
    for (std::uint32_t r = block.first_record; r < block.first_record + block.record_count; ++r)
      f(r);
  }
  const ErrorCode16* monotone(std::uint32_t r) const { return content().monotone.data() + r * codes_; }
  const file::Content& content() const { return hierarchy_.content(); }

  bool is_wanted(std::uint32_t r) const { return !request_.has_bounds() || exceeds(monotone(r), request_.limits); }

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
          if (!request_.focus_limits.empty() && !exceeds(content().own.data() + r * codes_, request_.focus_limits))
            return;
          const auto [min, max] = hierarchy_.star_box(RecordId{r});
          for (const FocusRegion& region : request_.focus)
            if (cut_.applied[r] == 0 && meets(region, min, max) && star_meets(region, RecordId{r})) cut_.applied[r] = 1;
        });
  }

  // The tets that the collapse made, C(r), must not be in the region. Nor may those that it consumed, F(r), be missing
  // there: where the boundary has moved they cover more.
  bool star_meets(const FocusRegion& region, RecordId r) const {
    const Refinement& refinement = content().refinement;
    const VertexId target = refinement.target(r);
    const std::uint32_t first = refinement.first_fine(r).index();
    for (std::uint32_t t = first; t < first + refinement.fine_count(r); ++t) {
      Tet tet = refinement.vertices(VersionId{t});
      if (tet_meets(region, tet)) return true;
      if (std::find(tet.begin(), tet.end(), target) != tet.end()) continue;
      tet[0] = target;
      if (tet_meets(region, tet)) return true;
    }
    return false;
  }
  bool tet_meets(const FocusRegion& region, const Tet& tet) const {
    std::array<Point, 4> corners;
    std::size_t count = 0;
    for (const VertexId v : tet)
      if (v != kDummyVertex) corners[count++] = hierarchy_.position(v);
    return meets(region, std::span(corners.data(), count));
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
    std::vector<Candidate> records;
    bool is_whole = true;
    OrderCode next_key = 0; ///< of the first candidate that does not fit
  };
  /// What a mesh has, counted from the base.
  struct Size {
    std::uint64_t records = 0;
    std::uint64_t tets = 0;
  };

  // The focus is a promise and stands whatever it takes; the budget decides what else is refined.
  //
  // Reads blocks in the order of their largest key until no unread one can hold a record that comes before the first
  // that does not fit.
  void spend_budget(const BlockSet& eligible) {
    std::vector<std::pair<OrderCode, std::uint32_t>> by_key;
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

    std::uint64_t expected = expected_records();
    OrderCode reach = key_of_rank(by_key, expected);
    while (true) {
      read_down_to(reach);
      const auto lock = hierarchy_.lock();
      const Prefix prefix = longest_prefix(
          focus_records, candidates([&](std::uint32_t r) { return focus_records[r] == 0 && is_wanted(r); }));
      const bool has_read_all = by_key.empty() || reach <= by_key.back().first;
      if (prefix.is_whole ? has_read_all : prefix.next_key >= reach) {
        for (const Candidate& candidate : prefix.records)
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
      reach = prefix.is_whole ? std::min<OrderCode>(key_of_rank(by_key, expected), static_cast<OrderCode>(reach - 1))
                              : prefix.next_key;
    }
  }

  // A first guess, to read about the right number of blocks at once.
  std::uint64_t expected_records() const {
    constexpr std::uint64_t kTetsPerVertex = 5;
    std::uint64_t expected = ~std::uint64_t{0} / 4;
    const auto above = [](std::uint64_t value, std::uint64_t base) { return value > base ? value - base : 0; };
    if (request_.max_vertices)
      expected = std::min(expected, above(*request_.max_vertices, hierarchy_.used_base_vertex_count()));
    if (request_.max_tets)
      expected = std::min(expected, above(*request_.max_tets, hierarchy_.header().base_tet_count) / kTetsPerVertex);
    return expected + 1;
  }
  OrderCode key_of_rank(const std::vector<std::pair<OrderCode, std::uint32_t>>& by_key, std::uint64_t rank) const {
    std::uint64_t records = 0;
    for (const auto& [key, b] : by_key)
      if ((records += blocks_[b].record_count) >= rank) return key;
    return 0;
  }

  template <class Wanted>
  std::vector<Candidate> candidates(Wanted&& wanted) const {
    std::vector<Candidate> found;
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      if (content().block_loaded[b] != 0)
        for_each_record(blocks_[b], [&](std::uint32_t r) {
          if (wanted(r)) found.push_back({content().order[r], content().generation[r], r});
        });
    return found;
  }

  [[nodiscard]] bool fits(const Size& size) const {
    const file::Header& header = hierarchy_.header();
    // The last split makes it the original, which has the vertices without tets too.
    const std::uint64_t base_vertices =
        size.records == header.record_count ? header.base_vertex_count : hierarchy_.used_base_vertex_count();
    return !(request_.max_tets && header.base_tet_count + size.tets > *request_.max_tets) &&
           !(request_.max_vertices && base_vertices + size.records > *request_.max_vertices);
  }
  [[nodiscard]] Size with(Size size, std::uint32_t record) const {
    return {size.records + 1, size.tets + content().refinement.added_tet_count(RecordId{record})};
  }

  // The longest prefix of the candidates' order that fits. Only those with the key at which it ends need be sorted.
  Prefix longest_prefix(const std::vector<char>& in_focus, const std::vector<Candidate>& candidates) const {
    Size size;
    for (std::uint32_t r = 0; r < in_focus.size(); ++r)
      if (in_focus[r] != 0) size = with(size, r);
    std::vector<Size> with_key(kMaxOrderCode + std::size_t{1});
    for (const Candidate& candidate : candidates)
      with_key[candidate.key] = with(with_key[candidate.key], candidate.record);

    Prefix prefix;
    std::size_t key = with_key.size();
    while (key > 0) {
      const Size larger{size.records + with_key[key - 1].records, size.tets + with_key[key - 1].tets};
      if (with_key[key - 1].records > 0 && !fits(larger)) break;
      size = larger;
      --key;
    }
    std::vector<Candidate> last;
    for (const Candidate& candidate : candidates) {
      if (candidate.key >= key) prefix.records.push_back(candidate);
      if (candidate.key + std::size_t{1} == key) last.push_back(candidate);
    }
    if (last.empty()) return prefix;
    std::sort(last.begin(), last.end());
    for (const Candidate& candidate : last) {
      size = with(size, candidate.record);
      if (!fits(size)) break;
      prefix.records.push_back(candidate);
    }
    prefix.is_whole = false;
    prefix.next_key = last.front().key;
    return prefix;
  }

  Hierarchy& hierarchy_;
  const ResolvedRequest& request_;
  const ProgressCallback& progress_;
  const std::vector<file::BlockInfo>& blocks_;
  const std::size_t codes_;
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
