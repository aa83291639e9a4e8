// A .ptet file changed where it hurts: taken apart, one part changed, put together again under right hashes. A hash
// guards against accident; this is how far one gets with intent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <vector>

namespace ptet::fuzz {

using Bytes = std::vector<std::byte>;
using Input = std::span<const std::byte>;

/// Where changes come from.
struct Mutator {
  /// Changes bytes in any way, to at most so many.
  std::function<void(Bytes& bytes, std::size_t most_bytes)> change;
  std::minstd_rand random;

  /// A number below `count`, which is not 0.
  std::size_t below(std::size_t count) { return random() % count; }
};

/// Bits flipped, bytes set, inserted and removed: for where libFuzzer is not there.
void change_bytes(Bytes& bytes, std::size_t most_bytes, std::minstd_rand& random);

/// Changes one part of the file: fields of the header, bytes of a section, fields of the block table, bytes of a block,
/// the order of blocks or sections. What is no .ptet file is changed byte by byte.
void mutate_file(Bytes& file, std::size_t most_bytes, Mutator& mutator);

/// Whether the file can be taken apart: its footer and directory are sound.
[[nodiscard]] bool has_parts(Input file);

} // namespace ptet::fuzz
