// In what order vertices, tets and their corners stood in the mesh that a file was made from. A file has them in an
// order of its own; where this is kept, the whole mesh can be put back as it was. PTET.md, "Input order".
#pragma once

#include "formats/ptet/bytes.hpp"
#include "ptet/mesh.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace ptet::file {

/// The ids of a mesh as it was given.
struct GivenIds {
  std::vector<VertexId> vertex; ///< by vertex of the mesh at hand: its id there
  std::vector<Tet> tets;        ///< as they stood there
};

/// What a file keeps of that. Tets are named by their vertices: the first one is that with the least ids in the input,
/// compared one after the other in ascending order.
struct InputOrder {
  std::vector<std::uint32_t> vertex; ///< by vertex of the file: its id in the input
  std::vector<std::uint32_t> tet;    ///< by place among the tets so sorted: its id in the input
  std::vector<std::uint8_t> corners; ///< likewise: see corners_in_order()
};

/// `file_vertex`: by vertex of the mesh, its id in the file. The ids of `given` are those of a valid mesh.
[[nodiscard]] InputOrder input_order(const GivenIds& given, std::span<const VertexId> file_vertex);

/// Tets with their corners in ascending order, by their corners, one after the other: which tet comes at each place.
/// Corners are below `vertex_count`. Cost: O(tets), for as many around a vertex as meshes have.
[[nodiscard]] std::vector<std::uint32_t> places_by_corners(std::span<const Tet> ascending, std::size_t vertex_count);

/// The corners in the order of number `corners`, below 24: that of the permutations of (0, 1, 2, 3) which comes at this
/// place when all are sorted says which corner comes first, second, third and last.
[[nodiscard]] Tet corners_in_order(const Tet& ascending, std::uint8_t corners);

/// Throws Error(kCorruptFile): no permutation of the ids below `vertex_count`, or `tet_count`; no order of corners.
[[nodiscard]] InputOrder parse_input_order(ByteReader& in, std::uint32_t vertex_count, std::uint32_t tet_count);
void put_input_order(ByteWriter& out, const InputOrder& order);
/// Bytes that these take.
[[nodiscard]] std::uint64_t input_order_bytes(std::uint64_t vertex_count, std::uint64_t tet_count);

} // namespace ptet::file
