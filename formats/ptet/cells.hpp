// Records divided among cells in space, such that what the records of a cell depend on lies in few other cells: a
// reader of one place then needs few blocks.
//
//   +---------+---+---------+   What lies left of a plane with all that depends on it, and what lies right of it, do
//   |  left   | s |  right  |   not need each other, only records of the separator s, on which something depends on
//   +---------+---+---------+   both sides. All three are divided in the same way, s by its own dependencies.
//
// Cutting space alone does not do: a block needs its neighbours in space, those theirs, and so all are needed.
//
// After nested dissection: George 1973, Nested dissection of a regular finite element mesh.
#pragma once

#include "ptet/mesh.hpp"
#include "record/parents.hpp"
#include "record/stream.hpp"

#include <cstdint>
#include <vector>

namespace ptet::file {

/// The cells and how they came about, depth first: a node is a set of records that was divided, or a cell.
struct CellTree {
  struct Node {
    std::uint32_t begin = 0, end = 0; ///< its cells
    std::uint32_t after = 0;          ///< the node that follows on all that came of it
  };
  /// Records by cell, ascending. A cell depends on none behind it.
  std::vector<std::vector<std::uint32_t>> cells;
  std::vector<Node> nodes; ///< the first is of all records; the parts of one follow on it

  /// All cells in runs, each of a node: a run has at most `most` records that count, or is a single cell. `count`: of
  /// each cell, how many of its records count.
  [[nodiscard]] std::vector<Node> parts(const std::vector<std::size_t>& count, std::size_t most) const;
};

/// At most `most_records` in each cell but where no plane divides them.
/// `parents`: of the stream; `generation`: by record, greater than that of each parent. The result depends on the
/// arguments alone.
[[nodiscard]] CellTree divide_into_cells(const TetMesh& mesh, const RecordStream& records, const StreamParents& parents,
                                         const std::vector<std::uint32_t>& generation, std::size_t most_records);

} // namespace ptet::file
