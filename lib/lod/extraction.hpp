// From a cut to the mesh: flat passes over the versions that its records make.
#pragma once

#include "lod/cut.hpp"

namespace ptet {

/// Fills all of Extraction but bytes_read and seconds. The lock must be held.
///
/// Vertices come in ascending file id; tets base first, then by the record that brings them: an order that does not
/// depend on what was read when.
[[nodiscard]] Extraction extract_cut(const Hierarchy& hierarchy, const Cut& cut, bool with_origins);

/// Extraction::rms_error of the cut in which the splits `applied` (by record) are. Blocks of which some are, and not
/// all, are looked at record by record; they must have been read. The lock must be held.
[[nodiscard]] std::vector<double> rms_error(const Hierarchy& hierarchy, const std::vector<char>& applied);

} // namespace ptet
