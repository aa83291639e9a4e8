#include "lod/stored_blocks.hpp"

namespace ptet {

file::FetchedBlock StoredBlocks::use(std::uint32_t block) {
  const Kept& kept = kept_[block];
  if (!kept.bytes.empty()) last_used_.splice(last_used_.begin(), last_used_, kept.place);
  return {block, kept.bytes};
}

void StoredBlocks::keep(const file::FetchedBlock& block) {
  Kept& kept = kept_[block.block];
  if (block.bytes.size() > max_bytes_ || block.bytes.empty() || !kept.bytes.empty()) return;
  while (bytes_ + block.bytes.size() > max_bytes_) {
    std::vector<std::byte>& oldest = kept_[last_used_.back()].bytes;
    bytes_ -= oldest.size();
    std::vector<std::byte>().swap(oldest);
    last_used_.pop_back();
  }
  last_used_.push_front(block.block);
  kept.place = last_used_.begin();
  try {
    kept.bytes = block.bytes;
  } catch (...) {
    last_used_.pop_front();
    throw;
  }
  bytes_ += block.bytes.size();
}

} // namespace ptet
