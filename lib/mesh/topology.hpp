// How the tets of a mesh hang together: the face table, the boundary surface, components, and where the complex is
// no manifold.
//
//   half-face 4 t + k    the face of tet t opposite its corner k, outward oriented when t is positively oriented
//   mate[h]              the half-faces on one face form a cycle:   h -> h               boundary
//                                                                   h -> h' -> h         two tets
//                                                                   h -> h' -> h'' -> h  more: no mesh of a domain
//
// Vertex ids must be in range and the four of a tet different; everything else may be wrong. The face table and the
// links are found in parallel, on the threads of the caller's arena.
#pragma once

#include "mesh/predicates.hpp"
#include "ptet/mesh.hpp"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace ptet {

using HalfFace = std::uint32_t;
/// With more tets, edges of boundary faces might have no 32-bit number.
inline constexpr std::size_t kMaxTets = std::size_t{1} << 28;
/// OpenMesh, which boundary surfaces are made with, numbers half-edges, three a face, by int.
inline constexpr std::size_t kMostSurfaceFaces = std::numeric_limits<int>::max() / 3;

/// Corners of the outward face opposite each corner of a positively oriented tet.
inline constexpr std::array<std::array<std::uint8_t, 3>, 4> kOutwardFace = {
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

[[nodiscard]] inline Face face_of(std::span<const Tet> tets, HalfFace h) {
  const Tet& tet = tets[h / 4];
  const auto& corners = kOutwardFace[h % 4];
  return {tet[corners[0]], tet[corners[1]], tet[corners[2]]};
}
[[nodiscard]] inline VertexId apex_of(std::span<const Tet> tets, HalfFace h) {
  return tets[h / 4][h % 4];
}

struct FaceTable {
  std::vector<HalfFace> mate; ///< by half-face
  /// The half-faces on faces of more than two tets, one of each: the one of the smallest tet.
  std::vector<HalfFace> crowded;
  /// Tets on the same vertices as an earlier one, ascending. When there are any, the table is good for nothing else.
  std::vector<TetId> duplicates;
  std::uint64_t face_count = 0;

  [[nodiscard]] bool is_boundary(HalfFace h) const { return mate[h] == h; }
  [[nodiscard]] bool is_interior(HalfFace h) const { return mate[h] != h && mate[mate[h]] == h; }
};

/// Cost: O(tets), sorting in buckets by smallest vertex. At most kMaxTets tets.
[[nodiscard]] FaceTable build_face_table(std::span<const Tet> tets, std::size_t vertex_count);

/// Whether the two tets at an interior face see it from the same side, going by the order of their vertices.
[[nodiscard]] bool is_folded(std::span<const Tet> tets, const FaceTable& faces, HalfFace h);

/// The boundary surface. Edge 3 f + i of face f runs from its vertex i to the next.
struct BoundarySurface {
  std::vector<HalfFace> half_faces; ///< ascending
  std::vector<Face> faces;          ///< outward oriented if the tets are positively oriented
  /// By edge of a face: the same edge in the other face there, or kNoMate where it is not in exactly two faces.
  std::vector<std::uint32_t> edge_mate;
  /// Edges that are not in exactly two boundary faces, smaller vertex first, ascending.
  std::vector<std::array<VertexId, 2>> non_manifold_edges;
  std::uint64_t edge_count = 0;
  std::uint64_t vertex_count = 0;
  std::uint64_t components = 0; ///< of faces joined by edges

  static constexpr std::uint32_t kNoMate = 0xffffffff;
};
[[nodiscard]] BoundarySurface build_boundary(std::span<const Tet> tets, const FaceTable& faces,
                                             std::size_t vertex_count);

/// What the links of all vertices say.
struct VertexLinks {
  /// Vertices whose link, closed with the dummy vertex, is no sphere; ascending.
  std::vector<VertexId> non_manifold;
  std::vector<char> used; ///< by vertex: 1 if in a tet
  std::uint64_t used_count = 0;
  std::uint64_t edge_count = 0;
};
[[nodiscard]] VertexLinks examine_links(std::span<const Tet> tets, const FaceTable& faces,
                                        const BoundarySurface& boundary, std::size_t vertex_count);

/// Components of tets joined by faces.
[[nodiscard]] std::uint64_t count_components(std::span<const Tet> tets, const FaceTable& faces);

} // namespace ptet
