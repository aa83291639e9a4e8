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
  /// Blocks that it depends on, too, and that could not be had: the cut is restricted to the records of `read`.
  BlockSet missing;
  LimitedBy limited_by = LimitedBy::kNothing;
  bool is_out_of_time = false; ///< some of `missing` were left for later, see find_cut_for
};

/// Reads the blocks it needs. Thread rule: see Hierarchy. `progress` is called now and then while it
/// does, under no lock but those of who loads.
[[nodiscard]] Cut find_cut(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress);

/// The same for one that asks again and again, of a request whose budgets have no time: in the background what it asked
/// for before is wanted no more. With `until` blocks that it seems cannot be read by then are left for later, see
/// Loader::load: at least one that was not there is read.
[[nodiscard]] Cut find_cut_for(const void* asker, std::optional<std::chrono::steady_clock::time_point> until,
                               Hierarchy& hierarchy, const ResolvedRequest& request);

} // namespace ptet
