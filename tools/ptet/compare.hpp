// What the commands share that compare two meshes: whether these are the same but for the order of their vertices and
// tets, every bit of every vertex and every tet; and what a user should know of the files that they came from.
#pragma once

#include "formats/vtk/read.hpp"
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

/// Adds to `notes` what was found while the mesh file `path` was read and bears on a comparison: which cells were split
/// or skipped, which time step it is. Not which arrays were left out.
void add_reading_notes(const std::string& path, const ReadReport& read, std::vector<std::string>& notes);

} // namespace ptet::cli
