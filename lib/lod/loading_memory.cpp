#include "lod/loading_memory.hpp"

#include <algorithm>
#include <utility>

namespace ptet {

LoadingMemory::LoadingMemory(const file::Reader& reader, const BlockNeeds& needs, const OpenOptions& options)
    : reader_(reader), needs_(needs) {
  room_ = options.limits.max_bytes - std::min(options.limits.max_bytes, reader.fixed_bytes());
  if (options.memory_limit > 0) room_ = std::min(room_, options.memory_limit);
  const std::uint64_t bytes_of_blocks = bytes_with_decoding(BlockSet(needs.size(), 1));
  bytes_for_all_ = reader.fixed_bytes() + bytes_of_blocks;
  is_limited_ = bytes_of_blocks > room_;
  if (!is_limited_) return;
  bytes_for_stored_ = room_ / kShareOfStored;
  room_ -= bytes_for_stored_;
}

std::uint64_t LoadingMemory::bytes_of(const std::vector<std::uint32_t>& blocks) const {
  std::uint64_t bytes = 0;
  for (const std::uint32_t b : blocks)
    bytes += reader_.decoded_bytes(b);
  return bytes;
}

std::uint64_t LoadingMemory::decoding_bytes_of(const std::vector<std::uint32_t>& blocks) const {
  std::uint64_t bytes = 0;
  for (const std::uint32_t b : blocks)
    bytes += reader_.decoding_bytes(b);
  return bytes;
}

/// Of the largest of the smallest parts in which the set can be decoded.
std::uint64_t LoadingMemory::most_decoding_bytes(const BlockSet& closed) const {
  const BlockSet none(closed.size(), 0);
  BlockSet decoded = none;
  std::uint64_t most = 0;
  for (const std::uint32_t b : members(closed))
    most = std::max(most, decoding_bytes_of(needs_.add(decoded, b, none)));
  return most;
}

std::uint64_t LoadingMemory::bytes_with_decoding(const BlockSet& closed) const {
  return bytes_of(members(closed)) + most_decoding_bytes(closed);
}

BlockSet LoadingMemory::what_fits(BlockSet kept, const BlockSet& set) const {
  std::uint64_t bytes = bytes_of(members(kept)), decoding = most_decoding_bytes(kept);
  // A block that did not fit will not fit later on, when more is kept; nor do those that need it.
  BlockSet unfit(set.size(), 0);
  for (const std::uint32_t b : members(set)) {
    if (kept[b] != 0) continue;
    const std::vector<std::uint32_t> added = needs_.add(kept, b, unfit);
    const std::uint64_t bytes_with = bytes + bytes_of(added);
    const std::uint64_t decoding_with = std::max(decoding, decoding_bytes_of(added));
    if (!added.empty() && bytes_with + decoding_with <= room_) {
      bytes = bytes_with;
      decoding = decoding_with;
      continue;
    }
    unfit[b] = 1;
    for (const std::uint32_t a : added)
      kept[a] = 0;
  }
  return kept;
}

std::vector<std::vector<file::FetchedBlock>> LoadingMemory::parts_of(std::vector<file::FetchedBlock> fetched,
                                                                     BlockSet loaded, std::size_t most_blocks) const {
  const BlockSet none(needs_.size(), 0);
  BlockSet all = loaded;
  std::vector<std::size_t> place(needs_.size(), 0);
  for (std::size_t i = 0; i < fetched.size(); ++i) {
    all[fetched[i].block] = 1;
    place[fetched[i].block] = i;
  }
  const std::uint64_t room = room_ - std::min(room_, bytes_of(members(all)));
  std::vector<std::vector<file::FetchedBlock>> parts;
  std::uint64_t decoding = 0;
  for (std::size_t i = 0; i < fetched.size(); ++i) {
    const std::vector<std::uint32_t> together = needs_.add(loaded, fetched[i].block, none);
    if (together.empty()) continue; // in a part already
    const std::uint64_t more = decoding_bytes_of(together);
    if (parts.empty() || parts.back().size() >= most_blocks || decoding + more > room) {
      parts.emplace_back();
      decoding = 0;
    }
    decoding += more;
    for (const std::uint32_t b : together)
      parts.back().push_back(std::move(fetched[place[b]]));
  }
  return parts;
}

} // namespace ptet
