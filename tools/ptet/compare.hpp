// Whether two meshes are the same but for the order of their vertices and tets: every bit of every vertex, every tet.
#pragma once

#include "ptet/mesh.hpp"

#include <string>
#include <vector>

namespace ptet::cli {

struct Findings {
  std::vector<std::string> wrong;
  std::vector<std::string> notes; ///< what is right, but worth knowing
};

/// Adds to `findings` how `copy` differs from `original`. Vertices are matched by the bits of their position and of all
/// their values; vertices that agree in all of them cannot be told apart and count as one class. A tet of `copy` may
/// have its corners in any even permutation; in an odd one where the tet of `original` is inverted or flat.
void compare_meshes(const TetMesh& original, const TetMesh& copy, Findings& findings);

} // namespace ptet::cli
