// What a limit of memory lets in: which blocks fit, and how many may be decoded at once. Estimates, by what a block
// says of itself.
#pragma once

#include "formats/ptet/reader.hpp"
#include "lod/block_needs.hpp"
#include "ptet/dataset.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ptet {

/// Thread rule: const.
class LoadingMemory {
public:
  /// `reader` and `needs` must outlive it.
  LoadingMemory(const file::Reader& reader, const BlockNeeds& needs, const OpenOptions& options);

  /// Whether blocks may be dropped: not all fit.
  [[nodiscard]] bool is_limited() const { return is_limited_; }
  /// Limits::max_bytes with which all fit.
  [[nodiscard]] std::uint64_t bytes_for_all() const { return bytes_for_all_; }
  /// Part of the room that is for blocks as they are stored: 0 where all fit.
  [[nodiscard]] std::uint64_t bytes_for_stored() const { return bytes_for_stored_; }

  /// Whether there is room for a closed set, and for decoding it in parts that are as small as they can be.
  [[nodiscard]] bool fits(const BlockSet& closed) const { return bytes_with_decoding(closed) <= room_; }
  /// `kept`, which is closed, and those of a closed set that there is room for beside it, coarse ones first.
  [[nodiscard]] BlockSet what_fits(BlockSet kept, const BlockSet& set) const;
  /// Blocks that are decoded together, part after part: each is closed on top of what is loaded by then (`loaded` and
  /// the parts before), has no more than `most_blocks`, and there is room for decoding it, or it cannot be smaller.
  [[nodiscard]] std::vector<std::vector<file::FetchedBlock>> parts_of(std::vector<file::FetchedBlock> fetched,
                                                                      BlockSet loaded, std::size_t most_blocks) const;

private:
  static constexpr std::uint64_t kShareOfStored = 16; ///< of the room; decoded they take some twenty times as much

  [[nodiscard]] std::uint64_t bytes_of(const std::vector<std::uint32_t>& blocks) const;
  [[nodiscard]] std::uint64_t decoding_bytes_of(const std::vector<std::uint32_t>& blocks) const;
  [[nodiscard]] std::uint64_t most_decoding_bytes(const BlockSet& closed) const;
  [[nodiscard]] std::uint64_t bytes_with_decoding(const BlockSet& closed) const;

  const file::Reader& reader_;
  const BlockNeeds& needs_;
  std::uint64_t bytes_for_all_ = 0;
  std::uint64_t bytes_for_stored_ = 0;
  std::uint64_t room_ = 0; ///< bytes for decoded blocks
  bool is_limited_ = false;
};

} // namespace ptet
