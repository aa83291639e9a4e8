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
#include "record/stream.hpp"

#include <cstdint>
#include <vector>

namespace ptet::file {

/// Records by cell, at most `most_records` in each but where no plane divides them; ascending in a cell. A cell depends
/// on none behind it.
/// `consumers`: find_consumers(); `generation`: by record, greater than that of each parent. The result depends on the
/// arguments alone.
[[nodiscard]] std::vector<std::vector<std::uint32_t>>
divide_into_cells(const TetMesh& mesh, const RecordStream& records, const std::vector<std::uint32_t>& consumers,
                  const std::vector<std::uint32_t>& generation, std::size_t most_records);

} // namespace ptet::file
