// The tets around one vertex by the directions that they take from it: which of very many may meet another tet that
// has the same vertex for a corner.
//
//         ________
//        |  \   / |      A tet with the apex for a corner is near it a cone; what is seen of it on the surface of the
//        |   \ /  |      cube [-1, 1]^3 around the apex lies in a box, and tets whose boxes do not meet have nothing in
//        |    x   |      common but the apex.
//        |________|
#pragma once

#include "mesh/box_tree.hpp"

#include <span>
#include <vector>

namespace ptet {

class StarCones {
public:
  using Triangle = std::array<Point, 3>;

  /// `opposite`: of each tet the face opposite the apex. Cost: n log n.
  StarCones(const Point& apex, std::span<const Triangle> opposite);

  /// Puts into `found` (emptied before) the tets, by their place, ascending, that may have more than the apex in common
  /// with the tet from the apex to `opposite`; none that has is left out. Cost: that of those found, and log n.
  void find_near(const Triangle& opposite, std::vector<std::uint32_t>& found) const;

private:
  Point apex_;
  BoxTree tree_;
};

} // namespace ptet
