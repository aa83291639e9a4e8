// The errors of the parts of a mesh that a request names: its focus regions, its values of interest, its view.
#pragma once

#include "lod/cut.hpp"

#include <span>

namespace ptet {

/// A tet of the mesh, or a ghost for a boundary face, by vertices in the file, and the record that made it.
struct MadeVersion {
  Tet tet;
  RecordId maker;
};

/// Whether the request names parts whose errors are to be stated by themselves.
[[nodiscard]] bool names_parts(const ResolvedRequest& request);

/// Fills in_focus, at_values, in_view and pixels_in_view of `result`. `tets` and `ghosts`: those of the mesh that were
/// made by records of blocks that the cut depends on. For the other blocks, which need not be in memory, the largest
/// error of the block counts, as for Extraction::field_error. The lock must be held.
void state_part_errors(const Hierarchy& hierarchy, const Cut& cut, const ResolvedRequest& request,
                       std::span<const MadeVersion> tets, std::span<const MadeVersion> ghosts, Extraction& result);

} // namespace ptet
