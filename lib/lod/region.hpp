// Where a tetrahedron or triangle lies with respect to a region. Answered along axes with conservative rounding: what
// is said to be apart is apart, and no closer than the distance given; what misses the region by a few units in the
// last place may be said to meet it.
#pragma once

#include "ptet/request.hpp"

#include <array>
#include <span>

namespace ptet {

/// `corners`: three or four points; or anything no further than `around` from their hull.
[[nodiscard]] bool meets(const Region& region, std::span<const Point> corners, double around = 0);
/// The same for the closed box [min, max]. An oriented box that misses it at edges only is said to meet it.
[[nodiscard]] bool meets(const Region& region, const Point& min, const Point& max, double around = 0);

/// Sets found[i], as far as it is not, where boxes[i] meets the region.
void find_meeting(const Region& region, std::span<const Box> boxes, std::span<char> found);

/// The distance between the region and the hull of three or four points, mesh units; by rounding it may be less, never
/// more. 0 where they meet.
[[nodiscard]] double distance(const Region& region, std::span<const Point> corners);
/// For the closed box [min, max]: no more than the distance, and for oriented boxes also less.
[[nodiscard]] double distance(const Region& region, const Point& min, const Point& max);
/// No point of the closed box is farther from the region, but for rounding.
[[nodiscard]] double farthest(const Region& region, const Point& min, const Point& max);

/// Whether all of the box [min, max] is in the region; a "yes" is certain.
[[nodiscard]] bool contains(const Region& region, const Point& min, const Point& max);

/// The corners of the box [min, max].
[[nodiscard]] std::array<Point, 8> box_corners(const Point& min, const Point& max);

} // namespace ptet
