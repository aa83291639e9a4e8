#include "formats/ptet/record_runs.hpp"

#include <algorithm>
#include <limits>

namespace ptet::file {
namespace {

/// So many blocks are coded at a time: enough for threads to share, and what they touch still fits in their caches.
constexpr std::size_t kBlocksAtOnce = 16;

/// What is left of each block's runs, and which of the next ones may follow now.
class Pending {
public:
  Pending(std::span<const std::uint32_t> generation, std::span<const BlockInfo> blocks)
      : generation_(generation), blocks_(blocks) {
    for (const BlockInfo& block : blocks)
      next_.push_back(block.first_record);
  }
  [[nodiscard]] bool is_over(std::uint32_t block) const {
    return next_[block] == blocks_[block].first_record + blocks_[block].record_count;
  }
  /// A block that must go on before this one can, which is not over; none: itself.
  [[nodiscard]] std::uint32_t waits_for(std::uint32_t block) const {
    const auto& needs = blocks_[block].needs;
    const auto found = std::find_if(needs.begin(), needs.end(), [&](std::uint32_t needed) {
      return !is_over(needed) && generation_[next_[needed]] < generation_[next_[block]];
    });
    return found == needs.end() ? block : *found;
  }
  /// The next run of a block that is not over.
  Run take(std::uint32_t block) {
    const std::uint32_t first = next_[block];
    while (!is_over(block) && generation_[next_[block]] == generation_[first])
      ++next_[block];
    return {generation_[first], block, first, next_[block] - 1};
  }

private:
  std::span<const std::uint32_t> generation_;
  std::span<const BlockInfo> blocks_;
  std::vector<std::uint32_t> next_; ///< record of each block
};

} // namespace

std::vector<std::vector<Run>> groups_of_runs(std::span<const std::uint32_t> generation,
                                             std::span<const BlockInfo> blocks) {
  Pending pending(generation, blocks);
  std::vector<std::vector<Run>> groups;
  std::vector<std::uint32_t> open, ready; // blocks, ascending
  std::uint32_t unopened = 0;
  for (;;) {
    std::erase_if(open, [&](std::uint32_t block) { return pending.is_over(block); });
    while (open.size() < kBlocksAtOnce && unopened < blocks.size())
      if (const std::uint32_t block = unopened++; !pending.is_over(block)) open.push_back(block);
    if (open.empty()) return groups;
    ready.clear();
    for (const std::uint32_t block : open)
      if (pending.waits_for(block) == block) ready.push_back(block);
    if (ready.empty()) { // those that are open wait for others; generations fall from one to the next
      std::uint32_t block = open.front();
      while (pending.waits_for(block) != block)
        block = pending.waits_for(block);
      ready.push_back(block);
    }
    std::vector<Run>& group = groups.emplace_back();
    for (const std::uint32_t block : ready)
      group.push_back(pending.take(block));
  }
}

std::vector<Run> near_ones_together(std::span<const Run> by_block, std::span<const std::uint32_t> open,
                                    std::span<const BlockInfo> blocks) {
  constexpr std::uint32_t kNotOpen = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> open_of(blocks.size(), kNotOpen);
  for (std::uint32_t i = 0; i < open.size(); ++i)
    open_of[open[i]] = i;
  std::vector<std::uint32_t> next(open.size()), end(open.size()); // runs of each block
  for (std::uint32_t i = 0; i < by_block.size(); ++i) {
    if (i == 0 || by_block[i].open_block != by_block[i - 1].open_block) next[by_block[i].open_block] = i;
    end[by_block[i].open_block] = i + 1;
  }
  std::vector<std::vector<std::uint32_t>> needs(open.size()); // those that may have runs left
  for (std::uint32_t i = 0; i < open.size(); ++i)
    for (const std::uint32_t needed : blocks[open[i]].needs)
      if (open_of[needed] != kNotOpen) needs[i].push_back(open_of[needed]);

  struct Wanted {
    std::uint32_t block, below; ///< its runs of generations below
  };
  std::vector<Run> result;
  result.reserve(by_block.size());
  std::vector<Wanted> wanted;
  for (std::uint32_t first = 0; first < open.size(); ++first) {
    wanted.push_back({first, std::numeric_limits<std::uint32_t>::max()});
    while (!wanted.empty()) {
      const auto [block, below] = wanted.back();
      if (next[block] == end[block] || by_block[next[block]].generation >= below) {
        wanted.pop_back();
        continue;
      }
      // Generations fall from one wanted block to the next, so this comes to an end.
      const Run& run = by_block[next[block]];
      std::erase_if(needs[block], [&](std::uint32_t needed) { return next[needed] == end[needed]; });
      const auto waits_for = std::find_if(needs[block].begin(), needs[block].end(), [&](std::uint32_t needed) {
        return by_block[next[needed]].generation < run.generation;
      });
      if (waits_for != needs[block].end()) {
        wanted.push_back({*waits_for, run.generation});
      } else {
        result.push_back(run);
        ++next[block];
      }
    }
  }
  return result;
}

} // namespace ptet::file
