// What a mesh is, found the slow and plain way, with nothing of the library's own topology: for comparing meshes
// before and after.
#pragma once

#include "ptet/mesh.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace ptet::test {

using Face = std::array<VertexId, 3>;

struct MeshFacts {
  std::size_t inverted_tets = 0; ///< exact sign of the determinant is not positive
  std::size_t repeated_tets = 0; ///< same four vertices as another
  std::size_t crowded_faces = 0; ///< faces of more than two tets
  std::size_t folded_faces = 0;  ///< faces whose two tets lie on the same side in their vertex order
  std::size_t components = 0;    ///< of tets joined by faces
  std::int64_t boundary_euler_characteristic = 0;
  double volume = 0; ///< sum of signed volumes
  /// Faces of one tet, outward oriented, the least vertex first; ascending.
  std::vector<Face> boundary;
};

[[nodiscard]] MeshFacts examine(const TetMesh& mesh);

/// Sign of det(b - a, c - a, d - a), exact for finite doubles.
[[nodiscard]] int orientation(const Point& a, const Point& b, const Point& c, const Point& d);
/// The face turned so that its least vertex comes first; the orientation stays.
[[nodiscard]] Face turned(const Face& face);
/// The tet's vertices in ascending order but for the last two, which keep the orientation.
[[nodiscard]] Tet sorted_keeping_orientation(const Tet& tet);
/// Volume enclosed by outward oriented faces, by the divergence theorem.
[[nodiscard]] double enclosed_volume(const TetMesh& mesh, const std::vector<Face>& faces);

} // namespace ptet::test
