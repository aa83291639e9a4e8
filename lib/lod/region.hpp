// Does a tetrahedron or triangle meet a focus region? Answered by separating axes with conservative rounding: "no" is
// certain, "yes" may be said of one that misses the region by a few units in the last place.
#pragma once

#include "ptet/dataset.hpp"

#include <span>

namespace ptet {

/// `corners`: three or four points.
[[nodiscard]] bool meets(const FocusRegion& region, std::span<const Point> corners);
/// The same for the closed box [min, max].
[[nodiscard]] bool meets(const FocusRegion& region, const Point& min, const Point& max);
/// Whether the box lies in the region. Of a box that does so by a few units in the last place "no" may be said.
[[nodiscard]] bool contains(const FocusRegion& region, const Point& min, const Point& max);

} // namespace ptet
