// Which record made the tet that stands in each place of the mesh.
//
// As a mesh is refined, a place is brought by the split of one record (or is there in the base), and what stands in it
// is then replaced by the splits of others, always in the same order:
//
//   place p   split a brings it --> split b replaces what is in it --> split c does --> none: it holds an original tet
//
// A tet that split b replaces is one that collapse b made. So the tet in p was made by the first record of this row
// that is not split yet: after split a by b, after split b by c, after split c by none.
//
//   after collapse(b)   what is in p was made by b
//   after split(b)      what is in p was made by next(b) there, which is kept for each place that b changes
#pragma once

#include "lod/hierarchy.hpp"
#include "record/dependency_order.hpp"

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
  /// Learns of the records of `known`, a closed set of loaded blocks for which can_learn() holds. Calls
  /// `follows(place, before, r)` whenever a record `r` is added to the row of a place, behind `before`; that is none
  /// where the place is the base's and `r` the first to change it.
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
