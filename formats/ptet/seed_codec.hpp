// Where the split of a record happens: its seeds, as the coding of a block goes from one record to the next (PTET.md,
// "Seeds").
#pragma once

#include "formats/ptet/number_codec.hpp"
#include "formats/ptet/reader.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace ptet::file {

/// Where a seed is found: tet `fine` of the list of F(p), p the `index`-th record of a block; or tet or ghost `index`
/// of the base. `corner`: of the target in that version.
struct Seed {
  std::uint32_t source = 0; ///< 0: this block; 1 ..: BlockInfo::needs; behind them: the base
  std::uint32_t index = 0;
  std::uint32_t fine = 0;
  std::uint32_t corner = 0;
};

/// The seeds of a block so far.
struct SeedHistory {
  std::vector<std::uint32_t> recent;     ///< sources, the one used last in front
  std::vector<std::uint32_t> last_index; ///< by source
  std::uint32_t last_rank = 0;

  explicit SeedHistory(std::size_t needs) : recent(needs + 2), last_index(needs + 2) {
    std::iota(recent.begin(), recent.end(), 0U);
  }
  void note(const Seed& seed, std::uint32_t rank) {
    last_rank = rank;
    std::rotate(recent.begin(), recent.begin() + rank, recent.begin() + rank + 1);
    last_index[seed.source] = seed.index;
  }
};

/// What the coding of a block's next record depends on, the contexts aside.
struct BlockState {
  std::uint32_t block = 0;
  SeedHistory seeds;
  std::vector<std::int32_t> last_own; ///< by error code
  std::vector<char> last_own_zero, last_above_zero;
  /// By error code: the sign of the last squared error, or uncovered volume (1: positive, 2: negative). By governing
  /// array, for both signs how much above its estimate it has been of late, in 1/16 codes, and the last code where the
  /// own error was 0.
  std::vector<std::uint8_t> last_squared_sign;
  std::vector<std::array<std::int32_t, 2>> squared_drift, last_squared;

  BlockState(std::uint32_t block_number, std::size_t needs, std::size_t codes)
      : block(block_number), seeds(needs), last_own(codes, 1280), last_own_zero(codes), last_above_zero(codes),
        last_squared_sign(codes), squared_drift(codes - 1, {-960, -960}), last_squared(codes - 1, {800, 800}) {}
};

template <class Coder>
void code_seed(Coder& coder, const Schema& schema, const SeedHistory& history, const BlockInfo& block,
               const Refinement& refinement, std::span<const BlockInfo> blocks, Seed& seed, std::uint32_t& rank,
               RecordId r) {
  const auto found = std::find(history.recent.begin(), history.recent.end(), seed.source);
  rank = code_uint(coder, schema.source + (history.last_rank == 0 ? 0 : Schema::kUintContexts),
                   static_cast<std::uint32_t>(found - history.recent.begin()));
  if (rank >= history.recent.size()) fail_record(r, "its seed is in no block that this one needs");
  seed.source = history.recent[rank];
  const bool own_block = seed.source == 0;
  const std::int64_t last = history.last_index[seed.source];
  const std::int64_t index =
      last + code_int(coder, schema.index + (own_block ? 0 : Schema::kUintContexts + 32), seed.index - last);
  if (index < 0 || index > 0x7FFFFFFF) fail_record(r, "its seed is out of range");
  seed.index = static_cast<std::uint32_t>(index);

  if (seed.source == block.needs.size() + 1) {
    if (seed.index >= refinement.base_place_count()) fail_record(r, "its seed is no tet of the base");
    seed.corner = code_tree(coder, schema.corner, 2, seed.corner);
    return;
  }
  const BlockInfo& home = own_block ? block : blocks[block.needs[seed.source - 1]];
  if (seed.index >= home.record_count) fail_record(r, "its seed is of no record");
  const RecordId parent{home.first_record + seed.index};
  if (!refinement.applied(parent)) fail_record(r, "its seed is of a record not yet decoded");
  const std::uint32_t fine = seed.fine;
  seed.fine = code_tree(coder, schema.fine + (own_block ? 0 : 32), 5, std::min(fine, 31U));
  if (seed.fine == 31) seed.fine += code_uint(coder, schema.fine_rest, fine - 31);
  if (seed.fine >= refinement.fine_count(parent)) fail_record(r, "its seed is not among the tets of its record");
  seed.corner = code_tree(coder, schema.corner + 4, 2, seed.corner);
}

} // namespace ptet::file
