// All cells of a mesh into tetrahedra, so that none comes out turned over where diagonals can be found for that.
//
// What a cell puts on a face follows from one order of the points (split_cell.hpp): by their positions, x first. So
// numbers do not matter, and two pieces that repeat the points of a face agree on it. Where that turns tets over,
// points across thin cells come one after the other, so that both sides of these, which may be warped, have the same
// diagonal; and where a cell still gives turned tets, one of its points is made the first or the last of its
// surroundings, whichever leaves the fewest there, as long as that helps.
#pragma once

#include "ptet/mesh.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace ptet::vtkio {

class CellSplitting {
public:
  /// Cells that could not be split well.
  struct Unsplit {
    std::vector<std::uint64_t> turned; ///< ids of those with diagonals of which some tets are turned over all the same
    std::vector<std::uint64_t> turned_parts; ///< of cells whose parts are: each once
    std::vector<std::uint64_t> gone;         ///< of those that give no tet, since their points repeat
    /// How many tets are left out: pairs on the same points, one the other turned over, flat or of parts of one cell.
    /// Two faces of one cell give them where they have a point that no other face has; what they lie between meets
    /// without them.
    std::size_t paired = 0;
  };

  /// A cell that is to be split, and its tets to come after the first `tets_before` of the mesh. `id`: to tell the
  /// user. `is_part`: of the cell `id`, which is split already, so that it is known which way round it should be, and
  /// that a diagonal along its edge is to be avoided: of such parts faces may be triangles with a point on a side.
  void add(int vtk_cell_type, std::span<const VertexId> points, std::uint64_t id, std::size_t tets_before,
           bool is_part = false);
  /// That the tets of the mesh from `begin` to `end` are parts of the cell `id`. Cells ascend; what is added of the
  /// same cell comes right behind these tets.
  void add_part_tets(std::size_t begin, std::size_t end, std::uint64_t id) { part_tets_.push_back({begin, end, id}); }
  [[nodiscard]] std::size_t size() const { return cells_.size(); }
  /// That a cell takes, beside its points, until it is split.
  [[nodiscard]] static constexpr std::size_t bytes_of_cell() { return sizeof(Cell); }
  /// Puts the tets of all cells, fewer than 2^32, into the mesh. `look` is called now and then, and may throw.
  /// Cost: a microsecond a cell; ten where many have to be improved.
  [[nodiscard]] Unsplit split(TetMesh& mesh, const std::function<void()>& look) const;

private:
  friend class OrderOfPoints;
  struct Cell {
    std::uint64_t id;
    std::size_t tets_before;
    std::size_t points_begin;
    int type;
    bool is_part;
  };
  struct PartTets {
    std::size_t begin, end;
    std::uint64_t id;
  };
  [[nodiscard]] std::span<const VertexId> points_of(const Cell& cell) const;

  std::vector<Cell> cells_;
  std::vector<PartTets> part_tets_;
  std::vector<VertexId> points_;
};

} // namespace ptet::vtkio
