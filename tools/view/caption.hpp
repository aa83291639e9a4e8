// What the viewer says in words about what it shows.
#pragma once

#include "scene.hpp"

#include <string>

namespace ptet::view {

/// "y = 1.7" for a plane across an axis, else "".
[[nodiscard]] std::string name_of(const Plane& plane, const DatasetInfo& info);
[[nodiscard]] const char* name_of(Show show);
/// "Density", "error, % of the range", "level"
[[nodiscard]] std::string name_of(const ColourBy& colour, const DatasetInfo& info);
/// "1.25%", "none"
[[nodiscard]] std::string name_of_error(const std::optional<double>& error);
/// Some lines: what is shown, what was asked, what was achieved, at what cost. `file` is the file's name.
[[nodiscard]] std::string caption(const std::string& file, const DatasetInfo& info, const Settings& settings,
                                  const Frame& frame);

} // namespace ptet::view
