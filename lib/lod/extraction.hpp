// From a cut to the mesh: what the splits of the cut leave in each place.
#pragma once

#include "lod/cut.hpp"

#include <vector>

namespace ptet {

/// Fills all of Extraction but bytes_read and seconds. The lock must be held.
///
/// Vertices come in ascending file id; tets and faces base first, then with the records that bring their places: an
/// order that does not depend on what was read when.
[[nodiscard]] Extraction extract_cut(const Hierarchy& hierarchy, const Cut& cut, const ResolvedRequest& request);

/// Of a record that is not in the cut `applied` (by record): whether some version in C(r), of the kind asked for, is in
/// the cut's mesh, so that the record's errors count. Such a version is one of the base, or came with the split of a
/// parent that is in the cut. The lock must be held.
[[nodiscard]] bool has_made(const Refinement& refinement, std::uint32_t r, VersionKinds kind,
                            const std::vector<char>& applied);

} // namespace ptet
