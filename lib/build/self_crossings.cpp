#include "build/self_crossings.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace ptet::build {

SelfCrossings::SelfCrossings(std::span<const std::uint32_t> curves) {
  intern({});
  of_original_.reserve(curves.size());
  for (const std::uint32_t curve : curves)
    of_original_.push_back(curve == 0 ? kNone : intern({curve}));
}

SelfCrossings::Set SelfCrossings::intern(std::vector<std::uint32_t> curves) {
  const auto [place, is_new] = place_of_.try_emplace(std::move(curves), static_cast<Set>(sets_.size()));
  if (is_new) sets_.push_back(place->first);
  return place->second;
}

SelfCrossings::Set SelfCrossings::join(Set a, Set b) {
  if (a == b || b == kNone) return a;
  if (a == kNone) return b;
  std::vector<std::uint32_t> both;
  std::set_union(sets_[a].begin(), sets_[a].end(), sets_[b].begin(), sets_[b].end(), std::back_inserter(both));
  return intern(std::move(both));
}

bool SelfCrossings::share(Set a, Set b) const {
  const std::vector<std::uint32_t>&x = sets_[a], &y = sets_[b];
  for (std::size_t i = 0, j = 0; i < x.size() && j < y.size();) {
    if (x[i] == y[j]) return true;
    if (x[i] < y[j])
      ++i;
    else
      ++j;
  }
  return false;
}

} // namespace ptet::build
