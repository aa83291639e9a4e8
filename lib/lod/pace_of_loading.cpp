#include "lod/pace_of_loading.hpp"

namespace ptet {
namespace {

/// What it takes to read and decode a block, in records: they may have one record or hundreds.
double work_of(const file::BlockInfo& block) {
  constexpr double kRecordsOfBlock = 32; // what it takes however few they are
  return kRecordsOfBlock + block.record_count;
}

} // namespace

std::optional<std::vector<std::uint32_t>> PartToLoad::add(std::uint32_t block, const BlockSet& lost,
                                                          const PaceOfLoading* pace) {
  std::vector<std::uint32_t> added = needs_.add(blocks_, block, lost);
  double more = 0;
  for (const std::uint32_t b : added)
    if (loaded_[b] == 0) more += work_of(needs_.block(b));
  if (pace != nullptr && more > 0 && !pace->has_time_for(work_, more)) {
    for (const std::uint32_t b : added)
      blocks_[b] = 0;
    return std::nullopt;
  }
  work_ += more;
  return added;
}

void PartToLoad::keep_loaded() {
  intersect(blocks_, loaded_);
  unite(blocks_, start_);
  work_ = 0;
}

} // namespace ptet
