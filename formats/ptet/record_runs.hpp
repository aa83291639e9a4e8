// The order in which the records of several blocks are decoded, or coded, together.
#pragma once

#include "formats/ptet/layout.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace ptet::file {

/// The records of one block in one generation.
struct Run {
  std::uint32_t generation;
  std::uint32_t open_block; ///< index into the open blocks, ascending with the block
  std::uint32_t first_record, last_record;
};

/// Runs that stand by block and then by generation in the order in which they are decoded: a run comes after those of
/// smaller generations in the blocks that its block needs. Any such order decodes the same. This one finishes block
/// after block as far as it can, so that most of what a record touches was touched just before.
/// `open`: the numbers of the open blocks.
[[nodiscard]] std::vector<Run> near_ones_together(std::span<const Run> by_block, std::span<const std::uint32_t> open,
                                                  std::span<const BlockInfo> blocks);

/// All runs of a file, those that stand together in groups: none of a group waits for another of it, each is of another
/// block, ascending. As above blocks are finished one after the other as far as they can be, but several at a time, so
/// that a group is work for several threads. `generation`: by record.
[[nodiscard]] std::vector<std::vector<Run>> groups_of_runs(std::span<const std::uint32_t> generation,
                                                           std::span<const BlockInfo> blocks);

} // namespace ptet::file
