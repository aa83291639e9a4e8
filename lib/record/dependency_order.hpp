// Records one after the other, each after those that it depends on.
#pragma once

#include "record/refinement.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace ptet {

/// Visits records after their parents, and near ones one after the other: ids do the same but for a few.
class DependencyOrder {
public:
  explicit DependencyOrder(const Refinement& refinement)
      : refinement_(refinement), is_done_(refinement.record_count(), 0) {}

  /// Each record that `is_wanted(r)` and was not visited yet; their parents are wanted, too, or visited already.
  template <class IsWanted, class Visit>
  void visit(IsWanted&& is_wanted, Visit&& visit) {
    for (std::uint32_t first = 0; first < is_done_.size(); ++first) {
      if (is_done_[first] != 0 || !is_wanted(first)) continue;
      open_.assign(1, first);
      while (!open_.empty()) {
        const std::uint32_t r = open_.back();
        const auto parents = refinement_.parents(RecordId{r});
        const auto waits_for = std::find_if(parents.begin(), parents.end(),
                                            [&](RecordId parent) { return is_done_[parent.index()] == 0; });
        if (waits_for != parents.end()) {
          open_.push_back(waits_for->index());
          continue;
        }
        open_.pop_back();
        is_done_[r] = 1;
        visit(r);
      }
    }
  }

private:
  const Refinement& refinement_;
  std::vector<char> is_done_;
  std::vector<std::uint32_t> open_;
};

} // namespace ptet
