// What the user should know of an extraction beyond its numbers: wishes that met nothing, and what a format of surfaces
// could not hold.
#pragma once

#include "extract_report.hpp"
#include "formats/surface/write.hpp"

#include <string>
#include <vector>

namespace ptet::cli {

/// Focus regions that no tet of the mesh meets, and values that no point of it takes, a sentence each.
[[nodiscard]] std::vector<std::string> notes_on_wishes(const ExtractOutcome& outcome);

/// Whether a surface lost more than the last digits of its extent, in a sentence; else nothing.
[[nodiscard]] std::vector<std::string> notes_on_surface(const SurfaceLoss& loss);

} // namespace ptet::cli
