// The order in which a file holds vertices and records: levels by when error bounds or budgets need them, in a level by
// cells in space that need few others (cells.hpp), cut in blocks, the records of a block by generation and by nearness.
// PTET.md, "Order".
#pragma once

#include "mesh/box_tree.hpp"
#include "ptet/mesh.hpp"
#include "record/parents.hpp"
#include "record/stream.hpp"

#include <cstdint>
#include <vector>

namespace ptet::file {

struct BlockRange {
  std::uint32_t first_record = 0;
  std::uint32_t record_count = 0;
};

struct FileOrder {
  BoundingBox box; ///< of the vertices that tets use
  std::uint32_t base_vertex_count = 0;
  std::vector<VertexId> mesh_vertex;        ///< by file vertex: base (used ones first), then one for each record
  std::vector<VertexId> file_vertex;        ///< by mesh vertex
  std::vector<std::uint32_t> stream_record; ///< by file record
  std::vector<std::uint32_t> generation;    ///< by file record
  std::vector<BlockRange> blocks;
};

/// Places of vertices along a Morton curve through the cube that begins where the box does, as PTET.md says it ("In a
/// block"). `positions`: n x 3; what is outside of it, or not finite, is in the first or last cell.
[[nodiscard]] std::vector<std::uint64_t> morton_codes(const PointArray& positions, const BoundingBox& box);

/// `parents`: of the stream. `rank`: by record, see budget_rank(). The order depends on the mesh and the stream alone.
[[nodiscard]] FileOrder order_file(const TetMesh& mesh, const RecordStream& records, const StreamParents& parents,
                                   const std::vector<std::uint32_t>& rank, std::uint32_t records_per_block);

} // namespace ptet::file
