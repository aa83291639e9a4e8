// Which record made what stands in each place of the mesh: of those that change the place the first that is not split.
//
//   place p   brought by a --changed by--> b --changed by--> c --> by none: what c leaves there is an original tet
//             a mesh has been split by some of these, the first ones; what stands in p was made by the next
//
//   collapse(b)   what is in p then was made by b
//   split(b)      what is in p then was made by next(b) there: kept for each place that b changes
#pragma once

#include "lod/dependency_order.hpp"
#include "lod/hierarchy.hpp"

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace ptet {

class Creators {
public:
  /// Of no record yet. `hierarchy` must outlive it, and its lock be held here and in what follows.
  explicit Creators(const Hierarchy& hierarchy);

  /// Whether `known` has all blocks learned of so far, and places still have the same names.
  [[nodiscard]] bool can_learn(const BlockSet& known) const;
  /// Learns of the records of `known`, a closed set of loaded blocks that can_learn().
  /// `follows(place, before, r)` is called where record `r` comes last in a place: after `before`, the record that
  /// changed the place or brought it; none: the base did.
  template <class Follows>
  void learn(const BlockSet& known, Follows&& follows);

  /// Of the records learned of, the first that changes the place.
  [[nodiscard]] RecordId first(std::uint32_t place) const { return first_[place]; }
  /// For each of modified(r) the record that changes the place after `r`.
  [[nodiscard]] std::span<const RecordId> next(RecordId r) const {
    const Refinement& refinement = hierarchy_.content().refinement;
    return {next_.data() + refinement.modified_begin(r), refinement.modified(r).size()};
  }

private:
  static constexpr std::uint32_t kFirst = std::numeric_limits<std::uint32_t>::max();
  /// The end of what is known of a place: the record, and where the one after it goes, in next_ or (kFirst) first_.
  struct End {
    RecordId record;
    std::uint32_t entry = kFirst;
  };

  void make_room();
  void mark_new(const BlockSet& known);
  void forget_ends();

  const Hierarchy& hierarchy_;
  bool is_settled_;
  BlockSet known_;
  std::vector<RecordId> first_; ///< by place
  std::vector<RecordId> next_;  ///< as all records' modified places
  // Until all is known.
  std::vector<End> end_; ///< by place
  std::optional<DependencyOrder> order_;
  std::vector<char> is_new_; ///< by record
};

template <class Follows>
void Creators::learn(const BlockSet& known, Follows&& follows) {
  make_room();
  if (known == known_) return;
  mark_new(known);
  const Refinement& refinement = hierarchy_.content().refinement;
  order_->visit([&](std::uint32_t r) { return is_new_[r] != 0; },
                [&](std::uint32_t r) {
                  std::uint32_t entry = refinement.modified_begin(RecordId{r});
                  for (const Place place : refinement.modified(RecordId{r})) {
                    End& end = end_[place.index()];
                    (end.entry == kFirst ? first_[place.index()] : next_[end.entry]) = RecordId{r};
                    follows(place, end.record, RecordId{r});
                    end = {RecordId{r}, entry++};
                  }
                  const std::uint32_t rim = refinement.rim_place(RecordId{r});
                  for (std::uint32_t p = rim; p < rim + refinement.rim(RecordId{r}).size(); ++p)
                    end_[p].record = RecordId{r};
                });
  known_ = known;
  forget_ends();
}

} // namespace ptet
