// From VTK's grids, one after the other, to one TetMesh. Nothing in a grid is trusted: counts, offsets, point ids and
// array lengths are checked here, because VTK's readers do not.
#pragma once

#include "formats/vtk/cell_splitting.hpp"
#include "formats/vtk/lagrange.hpp"
#include "formats/vtk/polyhedron.hpp"
#include "formats/vtk/read.hpp"

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <vector>

class vtkAbstractArray;
class vtkDataArray;
class vtkUnstructuredGrid;

namespace ptet::vtkio {

/// `wanted`, or if it is empty or in `taken` a name made from it that is not. Adds the result to `taken`.
std::string unique_name(const std::string& wanted, std::size_t index, std::set<std::string>& taken);

class Assembler {
public:
  /// `path` begins every error message. `report` gets the notes. add_cells() and finish() throw Error(kCancelled) when
  /// `progress` returns false.
  Assembler(std::string path, ReadReport& report, const ProgressCallback& progress)
      : path_(std::move(path)), report_(report), progress_(progress) {}

  /// To the notes, however often it is said.
  void note_once(const std::string& note);
  /// One that is not carried.
  void note_cell_array(const std::string& name);
  /// Appends the points and point arrays of a grid. Every grid must have the arrays of the first.
  void add_points(vtkUnstructuredGrid& grid);
  /// Appends the cells of a grid, whose ids are rows of the points that were added last. `faces`: of its polyhedra, by
  /// all of its cells; where there are none, polyhedra are refused.
  void add_cells(vtkUnstructuredGrid& grid, const PolyhedronFaces& faces = {});
  /// The mesh. Throws Error(kBadInput) when there were cells that cannot be split, or no volume cells.
  [[nodiscard]] TetMesh finish();

  [[noreturn]] void fail(const std::string& reason) const;

private:
  struct Kind {
    std::uint64_t count = 0;
    std::uint64_t first_cell = 0;
  };

  void add_array(PointArray& to, vtkDataArray& from, std::uint64_t points);
  void check_same_arrays(const std::vector<std::pair<std::string, vtkDataArray*>>& arrays) const;
  void check_degree(const std::array<double, 3>& degrees, int type, std::uint64_t points, std::uint64_t cell) const;
  [[nodiscard]] std::vector<unsigned char> ghost_flags(vtkUnstructuredGrid& grid, std::uint64_t cells) const;
  template <class Index>
  void add_cells(vtkUnstructuredGrid& grid, const PolyhedronFaces& faces, const Index* offsets,
                 std::uint64_t offset_count, const Index* ids, std::uint64_t id_count);
  /// The point `id` of the grid, which the cell says it has.
  template <class Index>
  [[nodiscard]] VertexId vertex(Index id, std::uint64_t cell) const;
  void check_room_for_splitting() const;
  void add_polyhedron(const PolyhedronFaces& faces, std::uint64_t cell_of_grid, std::uint64_t cell);
  void add_prism(int type, std::span<const VertexId> points, std::uint64_t cell);
  void add_cell_of_faces(int type, std::uint64_t cell);
  /// `points`: of the cell.
  void add_lattice(const LagrangeParts& parts, std::span<const VertexId> points, std::uint64_t cell);
  void note_component_names(const std::string& name, vtkDataArray& array);
  void count_ghost_points(vtkAbstractArray& array);
  /// Whether to go on.
  void look() const;
  [[nodiscard]] std::string what_to_do_with_refused() const;
  void note_cells(std::vector<std::uint64_t> cells, const std::string& what);

  std::string path_;
  ReadReport& report_;
  const ProgressCallback& progress_;
  TetMesh mesh_;
  CellSplitting cells_to_split_;
  LagrangeCells lagrange_;
  std::vector<Polygon> faces_; ///< of a polyhedron or prism
  SplitPolyhedron polyhedron_; ///< what it is split to
  std::uint64_t middles_ = 0;  ///< points that were added in polyhedra
  bool has_points_ = false;
  std::uint64_t first_point_ = 0; ///< row of the first point of the grid added last
  std::uint64_t point_count_ = 0; ///< its number of points
  std::uint64_t cell_count_ = 0;  ///< of all grids so far
  std::uint64_t ghost_cells_ = 0;
  std::uint64_t ghost_points_ = 0;
  std::map<int, Kind> volume_cells_; ///< by VTK cell type
  std::map<int, Kind> flat_cells_;   ///< of dimension 0 to 2, and empty ones
  std::map<int, Kind> refused_cells_;
};

} // namespace ptet::vtkio
