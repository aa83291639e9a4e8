#include "blocks.hpp"

#include <algorithm>

namespace ptet::cli {

std::vector<std::uint32_t> with_needs(const std::vector<file::BlockInfo>& blocks, std::vector<std::uint32_t> wanted) {
  std::vector<char> in(blocks.size(), 0);
  std::vector<std::uint32_t> closed;
  while (!wanted.empty()) {
    const std::uint32_t block = wanted.back();
    wanted.pop_back();
    if (in[block]) continue;
    in[block] = 1;
    closed.push_back(block);
    wanted.insert(wanted.end(), blocks[block].needs.begin(), blocks[block].needs.end());
  }
  std::sort(closed.begin(), closed.end());
  return closed;
}

std::uint32_t block_of(const std::vector<file::BlockInfo>& blocks, RecordId record) {
  const auto after =
      std::upper_bound(blocks.begin(), blocks.end(), record.index(),
                       [](std::uint32_t index, const file::BlockInfo& block) { return index < block.first_record; });
  return static_cast<std::uint32_t>(after - blocks.begin() - 1);
}

} // namespace ptet::cli
