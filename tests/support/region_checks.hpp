// What lies in a region and in a tet, without any cleverness.
#pragma once

#include "ptet/mesh.hpp"
#include "ptet/request.hpp"

namespace ptet::test {

/// Whether the tet holds the point, its boundary included; exact.
[[nodiscard]] bool contains(const TetMesh& mesh, const Tet& tet, const Point& p);
/// Whether they overlap: a point of the region against the tet, points of the tet against the region. It may miss a
/// contact, it never invents one.
[[nodiscard]] bool surely_meets(const Region& region, const TetMesh& mesh, const Tet& tet);

} // namespace ptet::test
