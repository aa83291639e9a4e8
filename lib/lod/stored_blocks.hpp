// The bytes of blocks as the file stores them, a twentieth or so of what they take decoded: those used last, within a
// limit. What was dropped is decoded again from them, and the source not asked.
#pragma once

#include "formats/ptet/reader.hpp"

#include <cstdint>
#include <list>
#include <vector>

namespace ptet {

/// Thread rule: one at a time.
class StoredBlocks {
public:
  /// `max_bytes`: of all together; 0: nothing is kept.
  StoredBlocks(std::size_t blocks, std::uint64_t max_bytes) : max_bytes_(max_bytes), kept_(blocks) {}

  /// A copy; without bytes where it is not kept.
  [[nodiscard]] file::FetchedBlock use(std::uint32_t block);
  void keep(const file::FetchedBlock& block);

private:
  struct Kept {
    std::vector<std::byte> bytes;
    std::list<std::uint32_t>::iterator place; ///< where it has bytes
  };
  std::uint64_t max_bytes_, bytes_ = 0;
  std::vector<Kept> kept_;             ///< by block
  std::list<std::uint32_t> last_used_; ///< the latest first
};

} // namespace ptet
