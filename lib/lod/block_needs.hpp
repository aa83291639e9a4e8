// Sets of blocks, and which are closed: with a block they have those that it needs.
#pragma once

#include "formats/ptet/reader.hpp"

#include <cstdint>
#include <vector>

namespace ptet {

/// One flag a block.
using BlockSet = std::vector<char>;

[[nodiscard]] std::vector<std::uint32_t> members(const BlockSet& set);
[[nodiscard]] bool is_subset(const BlockSet& part, const BlockSet& whole);
void unite(BlockSet& set, const BlockSet& more);
void intersect(BlockSet& set, const BlockSet& other);

/// BlockInfo::needs in both directions. Thread rule: const.
class BlockNeeds {
public:
  /// `blocks` must outlive it.
  explicit BlockNeeds(const std::vector<file::BlockInfo>& blocks);

  /// Blocks in all.
  [[nodiscard]] std::size_t size() const { return blocks_.size(); }
  [[nodiscard]] const file::BlockInfo& block(std::uint32_t block) const { return blocks_[block]; }
  /// Adds every block that one of the set needs, directly or not; `open` is memory to work in.
  void close(BlockSet& set, std::vector<std::uint32_t>& open) const;
  /// Adds a block to a closed set, and what it needs that is not in it; returns all that it added. Where one of these
  /// is in `without` it adds nothing. Cost: that of what it adds.
  std::vector<std::uint32_t> add(BlockSet& set, std::uint32_t block, const BlockSet& without) const;
  /// Takes blocks out of a set, and with each what needs it, but none of `kept`.
  void leave_out(BlockSet& set, std::vector<std::uint32_t> out, const BlockSet& kept) const;

private:
  const std::vector<file::BlockInfo>& blocks_;
  std::vector<std::uint32_t> needed_by_;     ///< for one block after the other those that need it
  std::vector<std::size_t> needed_by_begin_; ///< by block, and the end
};

} // namespace ptet
