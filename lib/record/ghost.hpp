// Ghosts: boundary faces as tets, with kDummyVertex at the fourth corner, behind the face.
#pragma once

#include "ptet/ids.hpp"
#include "ptet/mesh.hpp"

#include <array>
#include <cstddef>

namespace ptet {

[[nodiscard]] inline bool is_ghost(const Tet& tet) {
  return tet[0] == kDummyVertex || tet[1] == kDummyVertex || tet[2] == kDummyVertex || tet[3] == kDummyVertex;
}

/// The face that a ghost stands for, seen from outside: `dummy` is the corner without a point, and (dummy, a, c, b) an
/// even permutation of the ghost.
template <class Id>
[[nodiscard]] std::array<Id, 3> face_of_ghost(const std::array<Id, 4>& ghost, std::size_t dummy) {
  return {ghost[dummy ^ 1U], ghost[dummy ^ 3U], ghost[dummy ^ 2U]};
}

} // namespace ptet
