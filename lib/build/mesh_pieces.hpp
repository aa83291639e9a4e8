// A mesh cut in pieces that can be collapsed one by one, knowing nothing of one another.
//
//     . . . . | . . .        The vertices are parted along the longest side of their box, again and again, by their
//     . . . . | . . .        lexicographic order (that axis first): the places of one piece lie in a convex set, and
//     --------|. . .         these sets do not meet. Vertices in one place stay together.
//     . . . . |-----
//     . . . . | . . .
//
// In a piece a vertex may go only when it and all its neighbours are of the piece. Then every tet that a collapse makes
// has all its corners in the piece (a collapse gives a vertex no neighbour but its target), so no two pieces change
// the same tet, and what they make does not meet in space either.
//
// What a piece is given: all tets and boundary faces whose boxes meet the box of its vertices. These are all that hold
// one of them, and all that a tet or face made in the piece can meet: link condition, boundary, self-intersection and
// exact errors come out as in the whole mesh. Where what it is given ends there is no boundary face, and nothing that
// may move.
#pragma once

#include "mesh/box_tree.hpp"
#include "mesh/prepare.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace ptet::build {

/// One of them, with what surrounds it.
struct MeshPiece {
  /// Frozen is what must not move. Everything in the order of the whole mesh.
  PreparedMesh prepared;
  std::vector<std::uint32_t> tet;  ///< by tet of the piece: that of the whole mesh
  std::uint32_t movable_count = 0; ///< vertices that are not frozen
};

class MeshPieces {
public:
  /// `prepared` must outlive the object. More pieces than places leave some without vertices. Same mesh and count, same
  /// pieces. Cost: O(vertices log count).
  MeshPieces(const PreparedMesh& prepared, std::uint32_t count);

  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(boxes_.size()); }
  /// By used vertex: its piece.
  [[nodiscard]] const std::vector<std::uint32_t>& piece_of() const { return piece_of_; }
  /// So many vertices are its own.
  [[nodiscard]] std::uint32_t vertex_count(std::uint32_t index) const { return vertex_count_[index]; }
  /// With the point arrays `arrays` alone. `original_vertex` names the vertices of the whole prepared mesh. Thread
  /// rule: const. Cost: O(all tets), little each, and memory for the piece.
  [[nodiscard]] MeshPiece piece(std::uint32_t index, std::span<const std::uint32_t> arrays) const;

private:
  void cut(std::span<std::uint32_t> vertices, std::uint32_t first_piece, std::uint32_t count);

  const PreparedMesh& prepared_;
  std::vector<std::uint32_t> piece_of_;
  std::vector<BoundingBox> boxes_; ///< by piece, of its vertices
  std::vector<std::uint32_t> vertex_count_;
};

} // namespace ptet::build
