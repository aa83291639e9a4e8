// The cut that answers a request: which splits are applied. Always closed: with a record come its parents, the
// records that made what its split replaces.
#pragma once

#include "lod/hierarchy.hpp"
#include "lod/request.hpp"

#include <chrono>
#include <optional>

namespace ptet {

struct Cut {
  std::vector<char> applied; ///< by record
  std::uint32_t count = 0;
  /// Blocks that the request depends on, closed. A function of the request alone; more may be in memory.
  BlockSet read;
  /// The other blocks that it depends on, which could not be had: of their records none is in the cut.
  BlockSet missing;
  LimitedBy limited_by = LimitedBy::kNothing;
  bool is_out_of_time = false; ///< some of `missing` were left for later, see find_cut_for
};

/// Reads the blocks it needs. Thread rule: see Hierarchy. `progress` is called now and then while it does; the only
/// locks held then are those of loading.
[[nodiscard]] Cut find_cut(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress);

/// The same for an asker that goes from request to request, such as a session; `request` has no budget of time. In the
/// background, what the asker asked for before is wanted no more. With `until`, blocks that seem not to be readable by
/// then are left for later, but at least one that was not there is read, see Loader::load.
[[nodiscard]] Cut find_cut_for(const void* asker, std::optional<std::chrono::steady_clock::time_point> until,
                               Hierarchy& hierarchy, const ResolvedRequest& request);

} // namespace ptet
