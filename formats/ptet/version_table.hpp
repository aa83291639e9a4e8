// All tets and ghosts that a file's records make, with the records that make and replace them.
#pragma once

#include "record/refinement.hpp"

#include <cstdint>
#include <vector>

namespace ptet::file {

/// Versions have numbers here: those of the base by place, then F(r) of each applied record r, in the order of the
/// records.
class VersionTable {
public:
  /// Of a refinement that is not settled; it must outlive the table.
  explicit VersionTable(const Refinement& refinement);

  /// Of the k-th version of F(r).
  [[nodiscard]] std::uint32_t number(RecordId r, std::uint32_t k) const { return first_fine_[r.index()] + k; }
  /// The record whose split replaces the version, the collapse of which made it; none for one of the original.
  [[nodiscard]] RecordId creator(std::uint32_t number) const { return creator_[number]; }

  /// Calls `visit(number, record that makes it or none, its vertices)` for each version, ascending.
  template <class Visit>
  void each(Visit&& visit) const {
    for (std::uint32_t place = 0; place < refinement_.base_place_count(); ++place)
      visit(place, RecordId{}, refinement_.base_tet(place));
    for (RecordId r{0}; r.index() < refinement_.record_count(); r = RecordId{r.index() + 1})
      if (std::uint32_t version = first_fine_[r.index()]; refinement_.applied(r))
        for (const Tet& tet : refinement_.fine_tets(r))
          visit(version++, r, tet);
  }

private:
  const Refinement& refinement_;
  std::vector<std::uint32_t> first_fine_; ///< by record
  std::vector<RecordId> creator_;         ///< by version
};

} // namespace ptet::file
