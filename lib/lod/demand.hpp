// What a request asks of each record by itself, block by block first, so that most blocks need no look inside.
//
//   focus    the region must be fine there; what it takes besides, the parents, comes with it
//   asked    by the error bounds, or to spend a budget on; holds every record's parents as it is
#pragma once

#include "lod/hierarchy.hpp"
#include "lod/request.hpp"

namespace ptet {

/// Of which records of a block something holds; kSome: each is to be looked at.
enum class BlockDemand : std::uint8_t { kNone, kSome, kAll };

class Demand {
public:
  /// Both must outlive it.
  Demand(const Hierarchy& hierarchy, const ResolvedRequest& request) : hierarchy_(hierarchy), request_(request) {}

  // From the block table; no lock needed.
  [[nodiscard]] BlockDemand focus_of(const file::BlockInfo& block) const;
  [[nodiscard]] BlockDemand asked_of(const file::BlockInfo& block) const;

  // Of a loaded record in a block of which they hold for some. The lock must be held.
  [[nodiscard]] bool is_in_focus(RecordId r) const;
  [[nodiscard]] bool is_asked(RecordId r) const {
    return !request_.has_bounds() ||
           exceeds(hierarchy_.content().monotone.data() + r.index() * request_.limits.size(), request_.limits);
  }

private:
  [[nodiscard]] bool star_meets(const FocusRegion& region, RecordId r) const;
  [[nodiscard]] bool tet_meets(const FocusRegion& region, const Tet& tet) const;

  const Hierarchy& hierarchy_;
  const ResolvedRequest& request_;
};

} // namespace ptet
