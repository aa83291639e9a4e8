// The tet behind each boundary face, kept from mesh to mesh by what changes.
//
//   least corner of a face -> list of the faces that have it -> tet behind
#pragma once

#include "geometry.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ptet::view {

class BoundaryTets {
public:
  /// `changes`: as of Geometry. Cost: a look at each boundary face, and at the changed tets; at all tets where a face
  /// came up on one that did not change.
  void follow(const MeshRows& mesh, const Changes* changes);
  /// By row of MeshRows::faces; kUnusedRow for unused ones.
  [[nodiscard]] std::span<const std::uint32_t> behind() const { return behind_; }

private:
  using Face = std::array<std::uint32_t, 3>;

  void set_face(std::uint32_t row, const Face& face);
  void look_behind(std::uint32_t tet, const std::array<std::uint32_t, 4>& corners);
  void look_at_all(const MeshRows& mesh);

  std::vector<Face> key_;             ///< by face, ascending
  std::vector<std::uint32_t> behind_; ///< by face
  std::vector<std::uint32_t> next_;   ///< by face, in the list of its least corner
  std::vector<std::uint32_t> first_;  ///< by vertex
  std::vector<std::uint32_t> count_;  ///< by vertex: boundary faces
  std::vector<char> is_sought_;       ///< by vertex: of a face whose tet is not known
};

} // namespace ptet::view
