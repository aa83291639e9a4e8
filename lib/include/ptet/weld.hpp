// Points that stand more than once in a mesh, made one. In ptet::build.
#pragma once

#include "ptet/bounds.hpp"
#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"

#include <cstdint>
#include <string>

namespace ptet {

/// Makes one point of all that have the same position and the same values in every point array, bit for bit: where the
/// parts of a mesh were written one by one, the points that they share stand once in each of them, and without that the
/// seams are boundaries. The first of such points stays; all that stay keep their order, and so do the tets and their
/// corners. Points of one place with different values stay apart, and so do those of which one tet has two.
///
/// `within`: above 0, what rounding has set apart at the boundary is welded, too, as the parts of a mesh that several
/// processes computed have it. Of the vertices of boundary faces, those that are hardly apart first, each becomes the
/// nearest of those that stay, come before it and are no farther away than that (mesh units, or a part of the diagonal
/// of the tets' bounding box), and whose floating-point values differ by no larger a part of their array's range, over
/// all its components and the vertices of tets, than the distance is of the diagonal, or by no more than two units in
/// the last place of the array's largest value. Whole numbers must be equal; two NaN are. Points of one tet stay apart,
/// however short its edges are. Where a tet would turn over or become flat corners of it stay, so that thin parts are
/// not closed. Where more than a thousand points stay within about the distance not all of them are looked at.
///
/// Returns how many points went. A mesh whose arrays have not one row for each vertex, or whose tets name vertices that
/// there are not, or with more vertices than ids, is left as it is. Throws Error: kBadArgument for a distance beyond a
/// thousandth of the diagonal, kCancelled when `progress` returns false, which is called now and then; the mesh may be
/// welded in part then. Cost: a sort of the points, and with `within` a table of the boundary's.
std::uint64_t weld_points(TetMesh& mesh, const Bound& within = {}, const ProgressCallback& progress = {});

/// A sentence for who should know: "3 points were welded with others of the same place and values".
[[nodiscard]] std::string welding_note(std::uint64_t points, const Bound& within = {});

} // namespace ptet
