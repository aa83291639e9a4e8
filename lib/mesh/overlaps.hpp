// Where parts of a mesh overlap: bodies that lie in one another or reach into one another, or one that reaches into
// itself. Seen at the boundary, of which each overlap has some.
//
//     ________                    crossing    an edge of a boundary face pierces another face
//    |    ____|____               within      a ray from right behind a boundary face leaves the mesh more often than
//    | A |    | B  |                          it enters it, by two or more: so many tets hold the point that it starts
//    |___|____|    |                          from
//        |_________|              What only touches, as unwelded bodies with a common wall do, overlaps nowhere.
//
//     ____________
//    |     |______|   hanging     a boundary vertex on a boundary face or edge that it is no corner of, as where cells
//    |_____v______|               of one size meet cells of another
#pragma once

#include "mesh/topology.hpp"

#include <array>
#include <functional>
#include <span>
#include <vector>

namespace ptet {

struct Overlaps {
  /// Pairs of boundary faces that cross in their insides, the smaller half-face first; ascending. Faces with a common
  /// vertex are not looked at, nor what floating-point numbers are not sure of.
  std::vector<std::array<HalfFace, 2>> crossing;
  std::vector<std::uint32_t> within; ///< tets whose boundary face other tets reach over, in its middle; ascending
  std::vector<VertexId> hanging;     ///< ascending
};

/// Tets positively oriented or flat, no faces folded or of more than two tets. What is found is there; overlaps much
/// smaller than the faces around them, or thinner than a hundredth of the height of a tet, may be missed. `look` is
/// called now and then, and may throw. `rounding`: how far from its place a coordinate may be, as a fraction of
/// it. Cost: some microseconds a boundary face; more where the boxes of many meet one another.
[[nodiscard]] Overlaps find_overlaps(std::span<const Point> points, std::span<const Tet> tets,
                                     const BoundarySurface& boundary, double rounding,
                                     const std::function<void()>& look);

} // namespace ptet
