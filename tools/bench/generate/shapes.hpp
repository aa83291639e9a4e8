// Large meshes made to measure with: of any number of tets, the same on every machine and in every run.
//
//   graded cube   a lattice of cells, six tets each, the cells four times finer near one corner region than elsewhere
//   ball          a body-centred lattice cut to a ball with round holes; boundary vertices lie on the spheres
//   refinement    of a given mesh: every tet in eight, by the midpoints of its edges
//
// Sources: cells in six tets: Freudenthal 1942, Kuhn 1960. Cutting a lattice: Labelle and Shewchuk, Isosurface
// Stuffing, 2007, with diagonals of quadrilaterals chosen by vertex (Dompierre et al., How to Subdivide Pyramids,
// Prisms and Hexahedra into Tetrahedra, 1999). Refinement: Bey, Tetrahedral Grid Refinement, 1995.
#pragma once

#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"

#include <cstdint>
#include <vector>

namespace ptet::bench {

struct Shape {
  std::vector<Point> points;
  std::vector<Tet> tets; ///< positively oriented
};

/// The unit cube, of the number of tets nearest to `tets` that a lattice of cubes gives; at least 6.
/// Throws Error(kCancelled).
[[nodiscard]] Shape graded_cube(std::uint64_t tets, const ProgressCallback& progress = {});

inline constexpr std::uint32_t kMostHoles = 5;
/// The ball of radius 1 around the origin without `holes` <= kMostHoles balls, of about `tets` tets.
/// Throws Error: kBadArgument when so few tets cannot show the holes, kCancelled.
[[nodiscard]] Shape ball_with_holes(std::uint64_t tets, std::uint32_t holes, const ProgressCallback& progress = {});

/// Eight tets for each; vertices keep their ids and values, midpoints follow with the means of those of their edges.
/// Throws Error: kLimit, kCancelled.
[[nodiscard]] TetMesh refined(const TetMesh& mesh, const ProgressCallback& progress = {});

} // namespace ptet::bench
