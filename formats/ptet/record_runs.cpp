#include "formats/ptet/record_runs.hpp"

#include <algorithm>
#include <limits>

namespace ptet::file {

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
