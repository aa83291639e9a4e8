#include "formats/ptet/seed_choice.hpp"

#include "ptet/error.hpp"

#include <algorithm>
#include <limits>
#include <string>

namespace ptet::file {

Seed SeedChoice::seed_at(const Refinement& refinement, std::uint32_t number, VersionId version, VertexId target) const {
  const BlockInfo& block = infos_[number];
  const Tet& tet = refinement.vertices(version);
  Seed seed;
  seed.corner = static_cast<std::uint32_t>(std::find(tet.begin(), tet.end(), target) - tet.begin());
  const RecordId parent = refinement.consumer(version);
  if (parent.is_none()) {
    seed.source = static_cast<std::uint32_t>(block.needs.size()) + 1;
    seed.index = version.index();
    return seed;
  }
  const std::uint32_t home = block_of_[parent.index()];
  if (home != number) {
    const auto place = std::lower_bound(block.needs.begin(), block.needs.end(), home);
    seed.source = static_cast<std::uint32_t>(place - block.needs.begin()) + 1;
  }
  seed.index = parent.index() - infos_[home].first_record;
  seed.fine = version.index() - refinement.first_fine(parent).index();
  return seed;
}

// Any version of the region will do as seed, so the cheapest is taken; where the region hangs together only through
// places that are no manifold, one more for each part.
std::span<const Seed> SeedChoice::choose(const BitCounter& coder, const BlockState& state, const Refinement& refinement,
                                         RecordId r) {
  const std::uint32_t record = order_.stream_record[r.index()];
  const std::uint32_t first = records_.coarse_begin[record].index();
  const std::uint32_t count = records_.modified_count[record];
  const VertexId target = order_.file_vertex[records_.target[record].index()];
  const BlockInfo& block = infos_[state.block];
  seeds_.clear();
  reached_.assign(count, 0);
  for (std::uint32_t left = count; left > 0;) {
    std::uint64_t best_cost = std::numeric_limits<std::uint64_t>::max();
    std::uint32_t best = 0;
    Seed best_seed;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (reached_[i] != 0) continue;
      const VersionId version = match_.version_of(first + i);
      if (version.is_none())
        throw Error(ErrorCode::kBadInput, "collapse " + std::to_string(record) + " comes too early");
      Seed seed = seed_at(refinement, state.block, version, target);
      BitMeter meter(coder.contexts());
      std::uint32_t rank = 0;
      const Seed tried = seed;
      code_seed(meter, schema_, state, block, refinement, infos_, seed, rank, r);
      if (meter.cost() < best_cost) {
        best_cost = meter.cost();
        best = i;
        best_seed = tried;
      }
    }
    seeds_.push_back(best_seed);
    front_.assign(1, best);
    reached_[best] = 1;
    while (!front_.empty()) {
      const VersionId version = match_.version_of(first + front_.back());
      front_.pop_back();
      --left;
      for (std::uint32_t corner = 0; corner < 4; ++corner) {
        const VersionId behind = refinement.neighbour(version, corner);
        if (refinement.vertices(version)[corner] == target || behind.is_none()) continue;
        const std::uint32_t next = match_.stream_of(behind) - first;
        if (next >= count || reached_[next] != 0) continue;
        reached_[next] = 1;
        front_.push_back(next);
      }
    }
  }
  return seeds_;
}

} // namespace ptet::file
