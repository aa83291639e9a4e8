#include "lod/block_needs.hpp"

#include <numeric>
#include <utility>

namespace ptet {

std::vector<std::uint32_t> members(const BlockSet& set) {
  std::vector<std::uint32_t> blocks;
  for (std::uint32_t b = 0; b < set.size(); ++b)
    if (set[b] != 0) blocks.push_back(b);
  return blocks;
}

bool is_subset(const BlockSet& part, const BlockSet& whole) {
  for (std::size_t b = 0; b < part.size(); ++b)
    if (part[b] != 0 && whole[b] == 0) return false;
  return true;
}

void unite(BlockSet& set, const BlockSet& more) {
  for (std::size_t b = 0; b < set.size(); ++b)
    set[b] = static_cast<char>(set[b] | more[b]);
}

void intersect(BlockSet& set, const BlockSet& other) {
  for (std::size_t b = 0; b < set.size(); ++b)
    set[b] = static_cast<char>(set[b] & other[b]);
}

BlockNeeds::BlockNeeds(const std::vector<file::BlockInfo>& blocks)
    : blocks_(blocks), needed_by_begin_(blocks.size() + 1, 0) {
  for (const file::BlockInfo& block : blocks)
    for (const std::uint32_t needed : block.needs)
      ++needed_by_begin_[needed + 1];
  std::partial_sum(needed_by_begin_.begin(), needed_by_begin_.end(), needed_by_begin_.begin());
  needed_by_.resize(needed_by_begin_.back());
  std::vector<std::size_t> next(needed_by_begin_.begin(), needed_by_begin_.end() - 1);
  for (std::uint32_t b = 0; b < blocks.size(); ++b)
    for (const std::uint32_t needed : blocks[b].needs)
      needed_by_[next[needed]++] = b;
}

void BlockNeeds::close(BlockSet& set, std::vector<std::uint32_t>& open) const {
  open.clear();
  for (std::uint32_t b = 0; b < set.size(); ++b)
    if (set[b] != 0) open.push_back(b);
  while (!open.empty()) {
    const std::uint32_t b = open.back();
    open.pop_back();
    for (const std::uint32_t needed : blocks_[b].needs)
      if (std::exchange(set[needed], 1) == 0) open.push_back(needed);
  }
}

std::vector<std::uint32_t> BlockNeeds::add(BlockSet& set, std::uint32_t block, const BlockSet& without) const {
  std::vector<std::uint32_t> added;
  bool is_possible = true;
  const auto enter = [&](std::uint32_t b) {
    if (without[b] != 0) is_possible = false;
    if (std::exchange(set[b], 1) == 0) added.push_back(b);
  };
  enter(block);
  for (std::size_t next = 0; is_possible && next < added.size(); ++next) {
    const std::uint32_t b = added[next];
    for (const std::uint32_t needed : blocks_[b].needs)
      enter(needed);
  }
  if (is_possible) return added;
  for (const std::uint32_t b : added)
    set[b] = 0;
  return {};
}

void BlockNeeds::leave_out(BlockSet& set, std::vector<std::uint32_t> out, const BlockSet& kept) const {
  while (!out.empty()) {
    const std::uint32_t b = out.back();
    out.pop_back();
    if (kept[b] != 0 || std::exchange(set[b], 0) == 0) continue;
    for (std::size_t i = needed_by_begin_[b]; i < needed_by_begin_[b + 1]; ++i)
      out.push_back(needed_by_[i]);
  }
}

} // namespace ptet
