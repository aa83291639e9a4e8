// The cut that answers a request: which splits are applied. Always closed: with a record come its parents, the
// records that made what its split replaces.
#pragma once

#include "lod/hierarchy.hpp"
#include "lod/request.hpp"

#include <cstdint>
#include <shared_mutex>
#include <vector>

namespace ptet {

struct Cut {
  std::vector<char> applied; ///< by record
  std::uint32_t count = 0;
  /// Blocks that the request depends on, closed. A function of the request alone; more may be in memory.
  BlockSet read;
  /// The other blocks that it depends on, which could not be had: of their records none is in the cut.
  BlockSet missing;
  LimitedBy limited_by = LimitedBy::kNothing;
};

/// A cut, and the lock under which it was found: while that is held, all that the cut depends on is in memory. Under
/// another one blocks may be gone, where memory is limited or damage was met.
struct FoundCut {
  Cut cut;
  std::shared_lock<std::shared_mutex> lock;
};

/// Reads the blocks it needs. Thread rule: see Hierarchy. `progress` is called now and then while it does; the only
/// locks held then are those of loading.
[[nodiscard]] FoundCut find_cut(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress);

} // namespace ptet
