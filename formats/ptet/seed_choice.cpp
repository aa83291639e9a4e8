#include "formats/ptet/seed_choice.hpp"

#include "ptet/error.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include <oneapi/tbb/parallel_for.h>

namespace ptet::file {

Seed SeedChoice::seed_at(const Refinement& refinement, std::uint32_t number, std::uint32_t place,
                         VertexId target) const {
  const BlockInfo& block = infos_[number];
  const Tet& tet = refinement.tet(place);
  Seed seed;
  seed.corner = static_cast<std::uint32_t>(std::find(tet.begin(), tet.end(), target) - tet.begin());
  if (seed.corner == tet.size())
    throw Error(ErrorCode::kBadInput, "a collapse has modified a tet that is not at its target");
  const RecordId parent = refinement.consumer(place);
  if (parent.is_none()) {
    seed.source = static_cast<std::uint32_t>(block.needs.size()) + 1;
    seed.index = place;
    return seed;
  }
  const std::uint32_t home = block_of_[parent.index()];
  if (home != number) {
    const auto needed = std::lower_bound(block.needs.begin(), block.needs.end(), home);
    seed.source = static_cast<std::uint32_t>(needed - block.needs.begin()) + 1;
  }
  seed.index = parent.index() - infos_[home].first_record;
  seed.fine = refinement.fine_in_place(parent, place);
  return seed;
}

void SeedChoice::choose(const std::vector<Probability>& model, std::span<const BlockState> states,
                        const Refinement& refinement, std::span<const std::uint32_t> group) {
  if (seeds_.size() < group.size()) seeds_.resize(group.size());
  block_begins_.clear();
  for (std::size_t i = 0; i < group.size(); ++i)
    if (i == 0 || block_of_[group[i]] != block_of_[group[i - 1]]) block_begins_.push_back(i);
  block_begins_.push_back(group.size());
  oneapi::tbb::parallel_for(std::size_t{0}, block_begins_.size() - 1, [&](std::size_t b) {
    const std::uint32_t number = block_of_[group[block_begins_[b]]];
    SeedHistory history = states[number].seeds;
    for (std::size_t i = block_begins_[b]; i < block_begins_[b + 1]; ++i)
      choose_for(model, number, history, refinement, RecordId{group[i]}, seeds_[i], scratch_.local());
  });
}

// Any version of the region will do as seed, so the cheapest is taken; where the region hangs together only through
// places that are no manifold, one more for each part.
void SeedChoice::choose_for(const std::vector<Probability>& model, std::uint32_t number, SeedHistory& history,
                            const Refinement& refinement, RecordId r, std::vector<Seed>& seeds,
                            Scratch& scratch) const {
  const auto count = static_cast<std::uint32_t>(stars_.modified(r).size());
  seeds.clear();
  scratch.reached.assign(count, 0);
  for (std::uint32_t left = count; left > 0;) {
    const Choice best = cheapest(model, number, history, refinement, r, scratch.reached);
    seeds.push_back(best.seed);
    history.note(best.seed, best.rank);
    left -= reach(refinement, r, best.index, scratch);
  }
}

/// Of those versions of the region that are not reached yet.
SeedChoice::Choice SeedChoice::cheapest(const std::vector<Probability>& model, std::uint32_t number,
                                        const SeedHistory& history, const Refinement& refinement, RecordId r,
                                        const std::vector<char>& reached) const {
  const auto modified = stars_.modified(r);
  const VertexId target = target_of(r);
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  Choice best{};
  for (std::uint32_t i = 0; i < reached.size(); ++i) {
    if (reached[i] != 0) continue;
    const std::uint32_t place = match_.place_of(modified[i]);
    if (place == SlotMatch::kNone)
      throw Error(ErrorCode::kBadInput, "record " + std::to_string(r.index()) + " comes too early");
    const Seed tried = seed_at(refinement, number, place, target);
    BitMeter meter(model);
    Seed seed = tried;
    std::uint32_t rank = 0;
    code_seed(meter, schema_, history, infos_[number], refinement, infos_, seed, rank, r);
    if (meter.cost() >= least) continue;
    least = meter.cost();
    best = {i, tried, rank};
  }
  return best;
}

/// Goes from a tet of the region to all that hang together with it; returns how many these are.
std::uint32_t SeedChoice::reach(const Refinement& refinement, RecordId r, std::uint32_t index, Scratch& scratch) const {
  const auto modified = stars_.modified(r);
  const VertexId target = target_of(r);
  std::uint32_t count = 0;
  scratch.front.assign(1, index);
  scratch.reached[index] = 1;
  while (!scratch.front.empty()) {
    const std::uint32_t at = match_.place_of(modified[scratch.front.back()]);
    scratch.front.pop_back();
    ++count;
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      const std::uint32_t behind = refinement.neighbour(at, corner);
      if (refinement.tet(at)[corner] == target || behind == Refinement::kNoPlace) continue;
      const auto found = std::find(modified.begin(), modified.end(), match_.slot_of(behind));
      const auto next = static_cast<std::uint32_t>(found - modified.begin());
      if (next == modified.size() || scratch.reached[next] != 0) continue;
      scratch.reached[next] = 1;
      scratch.front.push_back(next);
    }
  }
  return count;
}

} // namespace ptet::file
