#include "lod/stored_blocks.hpp"

#include <algorithm>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

std::vector<std::byte> bytes_of(std::uint32_t block) {
  return std::vector<std::byte>(1 + block * 7 % 13, static_cast<std::byte>(block));
}

} // namespace

TEST_CASE("stored blocks: those used last, as many as there is room for") {
  constexpr std::size_t kBlocks = 20;
  for (const std::size_t room : {0U, 3U, 20U, 1000U}) {
    StoredBlocks stored(kBlocks, room);
    std::vector<std::uint32_t> last_used; // the latest first
    std::mt19937 random(static_cast<unsigned>(room));
    for (int step = 0; step < 2000; ++step) {
      const auto block = static_cast<std::uint32_t>(random() % kBlocks);
      const auto found = std::find(last_used.begin(), last_used.end(), block);
      const file::FetchedBlock used = stored.use(block);
      CHECK(used.block == block);
      CHECK(used.bytes == (found == last_used.end() ? std::vector<std::byte>() : bytes_of(block)));
      if (found != last_used.end()) {
        std::rotate(last_used.begin(), found, found + 1);
        continue;
      }
      stored.keep({block, bytes_of(block)});
      if (bytes_of(block).size() > room) continue;
      last_used.insert(last_used.begin(), block);
      for (std::size_t bytes = 0, i = 0; i < last_used.size(); ++i)
        if ((bytes += bytes_of(last_used[i]).size()) > room) last_used.resize(i);
    }
    CHECK((last_used.size() == kBlocks) == (room == 1000));
  }
}
