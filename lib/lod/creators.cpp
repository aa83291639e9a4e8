#include "lod/creators.hpp"

#include <algorithm>

namespace ptet {

Creators::Creators(const Hierarchy& hierarchy)
    : hierarchy_(hierarchy), is_settled_(hierarchy.content().refinement.is_settled()),
      known_(hierarchy.blocks().size(), 0), order_(hierarchy.content().refinement),
      is_new_(hierarchy.header().record_count, 0) {}

bool Creators::can_learn(const BlockSet& known) const {
  if (is_settled_ != hierarchy_.content().refinement.is_settled()) return false;
  for (std::size_t b = 0; b < known.size(); ++b)
    if (known_[b] != 0 && known[b] == 0) return false;
  return true;
}

// For all records that are loaded, also those not learned of: the mesh may be split by them.
void Creators::make_room() {
  const Refinement& refinement = hierarchy_.content().refinement;
  first_.resize(refinement.place_count());
  next_.resize(refinement.modified_count());
  if (order_) end_.resize(refinement.place_count());
}

void Creators::mark_new(const BlockSet& known) {
  std::fill(is_new_.begin(), is_new_.end(), char{0});
  for (std::size_t b = 0; b < known.size(); ++b)
    if (known[b] != 0 && known_[b] == 0)
      std::fill_n(is_new_.begin() + hierarchy_.blocks()[b].first_record, hierarchy_.blocks()[b].record_count, char{1});
}

void Creators::forget_ends() {
  if (std::find(known_.begin(), known_.end(), char{0}) != known_.end()) return;
  std::vector<End>().swap(end_);
  std::vector<char>().swap(is_new_);
  order_.reset();
}

} // namespace ptet
