#include "formats/vtk/assemble.hpp"

#include "formats/vtk/scalar_types.hpp"
#include "formats/vtk/split_cell.hpp"
#include "mesh/number_text.hpp"
#include "mesh/utf8.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <type_traits>

#include <vtkCell.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellTypes.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkGenericCell.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

namespace ptet::vtkio {
namespace {

/// Vertex and tet ids stay below the dummy vertex.
constexpr std::uint64_t kMaxRows = kDummyVertex.index();
/// So many names are listed in a note.
constexpr int kMostNames = 9;
constexpr std::size_t kMostIds = 8;
/// Cells that stand for another piece's, for finer ones, or for nothing.
constexpr unsigned char kGhostCell =
    vtkDataSetAttributes::DUPLICATECELL | vtkDataSetAttributes::REFINEDCELL | vtkDataSetAttributes::HIDDENCELL;

std::string kind_name(int type, bool plural) {
  switch (type) {
  case VTK_EMPTY_CELL: return plural ? "empty cells" : "empty cell";
  case VTK_VERTEX: return plural ? "vertices" : "vertex";
  case VTK_LINE: return plural ? "lines" : "line";
  case VTK_TRIANGLE: return plural ? "triangles" : "triangle";
  case VTK_QUAD: return plural ? "quadrilaterals" : "quadrilateral";
  case VTK_TETRA: return plural ? "tetrahedra" : "tetrahedron";
  case VTK_PYRAMID: return plural ? "pyramids" : "pyramid";
  case VTK_WEDGE: return plural ? "wedges" : "wedge";
  case VTK_VOXEL: return plural ? "voxels" : "voxel";
  case VTK_HEXAHEDRON: return plural ? "hexahedra" : "hexahedron";
  case VTK_QUADRATIC_TETRA: return plural ? "quadratic tetrahedra" : "quadratic tetrahedron";
  case VTK_QUADRATIC_PYRAMID: return plural ? "quadratic pyramids" : "quadratic pyramid";
  case VTK_QUADRATIC_WEDGE: return plural ? "quadratic wedges" : "quadratic wedge";
  case VTK_BIQUADRATIC_QUADRATIC_WEDGE:
    return plural ? "quadratic wedges of 18 points" : "quadratic wedge of 18 points";
  case VTK_QUADRATIC_HEXAHEDRON: return plural ? "quadratic hexahedra" : "quadratic hexahedron";
  case VTK_TRIQUADRATIC_HEXAHEDRON: return plural ? "triquadratic hexahedra" : "triquadratic hexahedron";
  case VTK_PENTAGONAL_PRISM: return plural ? "pentagonal prisms" : "pentagonal prism";
  case VTK_HEXAGONAL_PRISM: return plural ? "hexagonal prisms" : "hexagonal prism";
  case VTK_LAGRANGE_TETRAHEDRON: return plural ? "Lagrange tetrahedra" : "Lagrange tetrahedron";
  case VTK_LAGRANGE_WEDGE: return plural ? "Lagrange wedges" : "Lagrange wedge";
  case VTK_LAGRANGE_HEXAHEDRON: return plural ? "Lagrange hexahedra" : "Lagrange hexahedron";
  case VTK_POLYHEDRON: return plural ? "polyhedra" : "polyhedron";
  default: break;
  }
  const std::string class_name = vtkCellTypes::GetClassNameFromTypeId(type);
  const std::string known = class_name == "UnknownClass" ? "unknown type " + std::to_string(type) : class_name;
  return (plural ? "cells of " : "cell of ") + known;
}

std::string counted(std::uint64_t count, int type) {
  return grouped(count) + " " + kind_name(type, count != 1);
}

/// For each type 0 to 3; 3 for types that this VTK does not know.
std::array<int, 256> dimensions_of_types() {
  std::array<int, 256> dimensions;
  for (int type = 0; type < 256; ++type) {
    vtkSmartPointer<vtkCell> cell;
    cell.TakeReference(vtkGenericCell::InstantiateCell(type));
    dimensions[static_cast<std::size_t>(type)] = cell ? cell->GetCellDimension() : 3;
  }
  dimensions[VTK_EMPTY_CELL] = 0;
  return dimensions;
}

/// Of prisms over polygons of more than four sides; 0 for other types.
std::size_t points_of_prism(int type) {
  return type == VTK_PENTAGONAL_PRISM ? 10 : type == VTK_HEXAGONAL_PRISM ? 12 : 0;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  }
  return text;
}

/// The degrees of Lagrange's cells, by cell, where the grid has them.
vtkDataArray* degrees_of(vtkUnstructuredGrid& grid, std::uint64_t cells, const Assembler& assembler) {
  vtkDataArray* const degrees = grid.GetCellData()->GetHigherOrderDegrees();
  if (degrees &&
      (static_cast<std::uint64_t>(degrees->GetNumberOfTuples()) != cells || degrees->GetNumberOfComponents() != 3))
    assembler.fail("the degrees of its cells are not three for each");
  return degrees;
}

} // namespace

std::string unique_name(const std::string& wanted, std::size_t index, std::set<std::string>& taken) {
  const std::string stem = wanted.empty() ? "array_" + std::to_string(index) : wanted;
  std::string name = stem;
  for (int i = 2; !taken.insert(name).second; ++i)
    name = stem + "_" + std::to_string(i);
  return name;
}

void Assembler::fail(const std::string& reason) const {
  throw Error(ErrorCode::kBadInput, path_ + ": " + reason);
}

void Assembler::note_once(const std::string& note) {
  std::vector<std::string>& notes = report_.notes;
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
}

void Assembler::note_cell_array(const std::string& name) {
  std::vector<std::string>& names = report_.cell_arrays;
  const bool is_of_vtk = name.starts_with("vtk"); // marks and ids of its filters, as vtkOriginalCellIds
  if (!is_of_vtk && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  note_once("cell array '" + name + "' is not carried");
}

void Assembler::add_array(PointArray& to, vtkDataArray& from, std::uint64_t points) {
  if (static_cast<std::uint64_t>(from.GetNumberOfTuples()) != points)
    fail("point array '" + to.name + "' has " + grouped(static_cast<std::uint64_t>(from.GetNumberOfTuples())) +
         " rows for " + grouped(points) + " points");
  vtkSmartPointer<vtkDataArray> plain = &from;
  if (!from.HasStandardMemoryLayout()) {
    plain.TakeReference(vtkDataArray::CreateDataArray(from.GetDataType()));
    plain->DeepCopy(&from);
  }
  if (points == 0) return;
  const auto* bytes = static_cast<const std::byte*>(plain->GetVoidPointer(0));
  to.bytes.insert(to.bytes.end(), bytes, bytes + points * to.row_bytes());
}

void Assembler::check_same_arrays(const std::vector<std::pair<std::string, vtkDataArray*>>& arrays) const {
  for (const PointArray& expected : mesh_.point_arrays) {
    const auto found =
        std::find_if(arrays.begin(), arrays.end(), [&](const auto& array) { return array.first == expected.name; });
    if (found == arrays.end()) fail("point array '" + expected.name + "' is not in every piece");
    if (scalar_type(found->second->GetDataType()) != expected.type ||
        static_cast<std::uint32_t>(found->second->GetNumberOfComponents()) != expected.components)
      fail("point array '" + expected.name + "' is not of the same type in every piece");
  }
  for (const auto& [name, array] : arrays) {
    if (!mesh_.find(name)) fail("point array '" + name + "' is not in every piece");
  }
}

void Assembler::note_component_names(const std::string& name, vtkDataArray& array) {
  std::string names;
  for (int c = 0; c < std::min(array.GetNumberOfComponents(), kMostNames); ++c) {
    const char* const its_name = array.GetComponentName(c);
    names += (c == 0 ? "" : ", ") + std::string(its_name ? its_name : "-");
  }
  if (array.GetNumberOfComponents() > kMostNames) names += ", ...";
  note_once("the names of the components of point array '" + name + "' (" + names +
            ") are not carried; their order is");
}

void Assembler::count_ghost_points(vtkAbstractArray& array) {
  auto* const flags = vtkDataArray::SafeDownCast(&array);
  if (flags == nullptr) return;
  for (vtkIdType i = 0; i < flags->GetNumberOfTuples(); ++i)
    ghost_points_ += flags->GetComponent(i, 0) != 0 ? 1 : 0;
}

void Assembler::add_points(vtkUnstructuredGrid& grid) {
  vtkDataArray* positions = grid.GetPoints() ? grid.GetPoints()->GetData() : nullptr;
  first_point_ = mesh_.vertex_count();
  point_count_ = positions ? static_cast<std::uint64_t>(positions->GetNumberOfTuples()) : 0;
  if (point_count_ == 0) return;
  if (first_point_ + point_count_ > kMaxRows)
    throw Error(ErrorCode::kLimit, path_ + ": more than " + grouped(kMaxRows) + " points");
  if (positions->GetNumberOfComponents() != 3) fail("points do not have three coordinates");

  // Names first, so that every piece names its arrays alike.
  std::vector<std::pair<std::string, vtkDataArray*>> arrays;
  std::set<std::string> taken;
  vtkPointData& data = *grid.GetPointData();
  for (int i = 0; i < data.GetNumberOfArrays(); ++i) {
    vtkAbstractArray& any = *data.GetAbstractArray(i);
    const std::string as_read = any.GetName() ? any.GetName() : "", given = as_utf8(as_read);
    if (given != as_read) note_once("the name of point array '" + given + "' is not UTF-8, and was read as Latin-1");
    if (given == vtkDataSetAttributes::GhostArrayName()) {
      count_ghost_points(any);
      continue;
    }
    vtkDataArray* array = vtkDataArray::SafeDownCast(&any);
    if (!array || !scalar_type(array->GetDataType()) || array->GetNumberOfComponents() < 1) {
      note_once("point array '" + given + "' is not numeric (" + any.GetDataTypeAsString() + ") and is not carried");
      continue;
    }
    const std::string name = unique_name(given, arrays.size(), taken);
    if (name != given) note_once("a point array without a name of its own is called '" + name + "'");
    if (array->HasAComponentName()) note_component_names(name, *array);
    arrays.emplace_back(name, array);
  }

  const std::optional<ScalarType> position_type = scalar_type(positions->GetDataType());
  if (!position_type) fail("point coordinates are not numeric");
  if (!has_points_) {
    has_points_ = true;
    mesh_.positions.type = *position_type;
    for (const auto& [name, array] : arrays) {
      mesh_.point_arrays.push_back(
          {name, *scalar_type(array->GetDataType()), static_cast<std::uint32_t>(array->GetNumberOfComponents()), {}});
    }
  }
  if (mesh_.positions.type != *position_type) fail("point coordinates are not of the same type in every piece");
  check_same_arrays(arrays);

  add_array(mesh_.positions, *positions, point_count_);
  for (const auto& [name, array] : arrays) {
    const auto to = std::find_if(mesh_.point_arrays.begin(), mesh_.point_arrays.end(),
                                 [&, &wanted = name](const PointArray& known) { return known.name == wanted; });
    add_array(*to, *array, point_count_);
  }
}

/// By cell; none where there are none. By name: the grid itself knows neither those that the reader has made of the
/// levels of old files nor those of another type than bytes.
std::vector<unsigned char> Assembler::ghost_flags(vtkUnstructuredGrid& grid, std::uint64_t cells) const {
  vtkDataArray* const array = grid.GetCellData()->GetArray(vtkDataSetAttributes::GhostArrayName());
  if (!array) return {};
  if (static_cast<std::uint64_t>(array->GetNumberOfValues()) != cells)
    fail("the numbers of cells and of their ghost flags differ");
  std::vector<unsigned char> flags(cells);
  for (std::uint64_t i = 0; i < cells; ++i) {
    const double flag = array->GetComponent(static_cast<vtkIdType>(i), 0);
    constexpr double kNoFlags = 0x1p53;
    if (!(std::abs(flag) < kNoFlags))
      fail("the ghost flags of cell " + std::to_string(cell_count_ + i) + " are not flags");
    flags[i] = static_cast<unsigned char>(static_cast<std::int64_t>(flag)); // the others mean nothing
  }
  return flags;
}

template <class Index>
VertexId Assembler::vertex(Index id, std::uint64_t cell) const {
  if (id < 0 || static_cast<std::uint64_t>(id) >= point_count_)
    fail("cell " + std::to_string(cell) + " uses point " + std::to_string(id) + ", and there are " +
         grouped(point_count_) + " points");
  return VertexId(static_cast<std::uint32_t>(first_point_ + static_cast<std::uint64_t>(id)));
}

void Assembler::check_room_for_splitting() const {
  if (cells_to_split_.size() == kMaxRows)
    throw Error(ErrorCode::kLimit, path_ + ": more than " + grouped(kMaxRows) + " cells to be split");
}

void Assembler::add_polyhedron(const PolyhedronFaces& faces, std::uint64_t cell_of_grid, std::uint64_t cell) {
  const std::uint64_t begin = faces.face_begin[cell_of_grid], end = faces.face_begin[cell_of_grid + 1];
  faces_.resize(end - begin);
  for (std::uint64_t f = begin; f < end; ++f) {
    const auto corners =
        std::span(faces.corners).subspan(faces.corner_begin[f], faces.corner_begin[f + 1] - faces.corner_begin[f]);
    if (corners.size() > kMostCornersOfFace)
      fail("cell " + std::to_string(cell) + ", a polyhedron, has a face of " + grouped(corners.size()) +
           " points, and ptet splits those of up to " + std::to_string(kMostCornersOfFace));
    Polygon& face = faces_[f - begin];
    face.clear();
    for (const std::uint32_t id : corners)
      face.push_back(vertex(std::int64_t{id}, cell));
  }
  add_cell_of_faces(VTK_POLYHEDRON, cell);
}

/// `points`: those below, then those above.
void Assembler::add_prism(int type, std::span<const VertexId> points, std::uint64_t cell) {
  const std::size_t sides = points.size() / 2;
  const auto below = points.first(sides), above = points.last(sides);
  faces_.assign({{below.begin(), below.end()}, {above.begin(), above.end()}});
  for (std::size_t i = 0, next = 1; i < sides; ++i, next = (i + 1) % sides)
    faces_.push_back({below[i], below[next], above[next], above[i]});
  add_cell_of_faces(type, cell);
}

/// Splits what is bounded by faces_ around a point in its middle.
void Assembler::add_cell_of_faces(int type, std::uint64_t cell) {
  const auto fail_at_cell = [&](const std::string& reason) {
    fail("cell " + std::to_string(cell) + ", a " + kind_name(type, false) + ", " + reason);
  };
  if (mesh_.positions.type != ScalarType::kFloat32 && mesh_.positions.type != ScalarType::kFloat64)
    fail_at_cell(std::string("needs a point in its middle, which the type of the coordinates (") +
                 name_of(mesh_.positions.type) + ") may not have: write them as float64");
  if (!split_polyhedron(
          faces_, mesh_, [&] { look(); }, polyhedron_))
    fail_at_cell("is not closed: its faces do not meet two by two at their edges (a point on an edge must be one of "
                 "either face there)");
  if (mesh_.vertex_count() == kMaxRows)
    throw Error(ErrorCode::kLimit,
                path_ + ": more than " + grouped(kMaxRows) + " points, with those in the middle of cells");

  const VertexId middle(static_cast<std::uint32_t>(mesh_.vertex_count()));
  append_mean(mesh_.positions, polyhedron_.middle);
  for (PointArray& array : mesh_.point_arrays)
    append_mean(array, polyhedron_.middle);
  constexpr std::uint64_t kBetweenLooks = 1024; // some 15 ms where faces have few corners
  if (++middles_ % kBetweenLooks == 0) look();
  const std::size_t first = mesh_.tets.size();
  for (const auto& [a, b, c] : polyhedron_.surface.triangles)
    mesh_.tets.push_back({middle, a, b, c});
  cells_to_split_.add_part_tets(first, mesh_.tets.size(), cell);
  for (const auto& [a, b, c, d] : polyhedron_.surface.quadrilaterals) {
    check_room_for_splitting();
    // Of VTK's pyramids the base looks in.
    cells_to_split_.add(VTK_PYRAMID, std::array{a, d, c, b, middle}, cell, mesh_.tets.size(), true);
  }
}

void Assembler::add_lattice(const LagrangeParts& parts, std::span<const VertexId> points, std::uint64_t cell) {
  const auto picked = [&](const auto& numbers) {
    std::array<VertexId, std::tuple_size_v<std::decay_t<decltype(numbers)>>> ids;
    std::transform(numbers.begin(), numbers.end(), ids.begin(), [&](std::uint32_t n) { return points[n]; });
    return ids;
  };
  for (const auto& tet : parts.tets)
    append_if_proper(picked(tet), mesh_.tets);
  for (const auto& octahedron : parts.octahedra)
    split_octahedron(picked(octahedron), mesh_, mesh_.tets);
  const auto add = [&](int type, const auto& part) {
    check_room_for_splitting();
    cells_to_split_.add(type, picked(part), cell, mesh_.tets.size());
  };
  for (const auto& hexahedron : parts.hexahedra)
    add(VTK_HEXAHEDRON, hexahedron);
  for (const auto& wedge : parts.wedges)
    add(VTK_WEDGE, wedge);
}

/// Cells of Lagrange's kinds may have another order along each axis, as an array of the grid then says.
void Assembler::check_degree(const std::array<double, 3>& degrees, int type, std::uint64_t points,
                             std::uint64_t cell) const {
  if (degrees[0] != degrees[1] || degrees[0] != degrees[2])
    fail("cell " + std::to_string(cell) +
         " has another degree along each axis, and ptet splits cells of one degree: write the mesh in such");
  const bool is_one =
      degrees[0] >= 1 && degrees[0] <= static_cast<double>(points) && std::trunc(degrees[0]) == degrees[0];
  if (!is_one || lagrange_points(type, static_cast<std::uint64_t>(degrees[0])) != points)
    fail("cell " + std::to_string(cell) + " has " + std::to_string(points) +
         " points, which are not those of its degree");
}

template <class Index>
void Assembler::add_cells(vtkUnstructuredGrid& grid, const PolyhedronFaces& faces, const Index* offsets,
                          std::uint64_t offset_count, const Index* ids, std::uint64_t id_count) {
  const std::uint64_t cells = offset_count - 1;
  vtkUnsignedCharArray* type_array = grid.GetCellTypesArray();
  if (!type_array || static_cast<std::uint64_t>(type_array->GetNumberOfValues()) != cells)
    fail("the numbers of cells and of cell types differ");
  const unsigned char* types = type_array->GetPointer(0);
  const std::vector<unsigned char> ghosts = ghost_flags(grid, cells);
  vtkDataArray* const degrees = degrees_of(grid, cells, *this);

  static const std::array<int, 256> kDimensions = dimensions_of_types();
  mesh_.tets.reserve(mesh_.tets.size() + static_cast<std::size_t>(std::count(types, types + cells, VTK_TETRA)));
  std::vector<VertexId> points;
  for (std::uint64_t i = 0; i < cells; ++i) {
    const std::uint64_t cell = cell_count_ + i;
    if (!ghosts.empty() && (ghosts[i] & kGhostCell) != 0) {
      ++ghost_cells_;
      continue;
    }
    if (types[i] == VTK_POLYHEDRON && !faces.face_begin.empty()) {
      ++volume_cells_[VTK_POLYHEDRON].count;
      add_polyhedron(faces, i, cell);
      continue;
    }
    if (offsets[i] < 0 || offsets[i + 1] < offsets[i] || static_cast<std::uint64_t>(offsets[i + 1]) > id_count)
      fail("cell " + std::to_string(cell) + " lies outside the table of cells");
    const auto given = static_cast<std::uint64_t>(offsets[i + 1] - offsets[i]);
    const int type = plain_type(types[i], given);
    if (degrees && lagrange_points(types[i], 1) != 0) {
      std::array<double, 3> of_cell{};
      degrees->GetTuple(static_cast<vtkIdType>(i), of_cell.data());
      check_degree(of_cell, types[i], given, cell);
    }
    const LagrangeParts* const lattice = lagrange_.parts_of(type, given);
    const std::size_t prism = points_of_prism(type);
    const std::uint64_t size = lattice != nullptr ? given : prism != 0 ? prism : cell_size(type).points;
    if (size == 0) {
      Kind& kind = (kDimensions[types[i]] < 3 ? flat_cells_ : refused_cells_)[type];
      if (kind.count++ == 0) kind.first_cell = cell;
      continue;
    }
    if (given != size)
      fail("cell " + std::to_string(cell) + ", a " + kind_name(type, false) + ", has " + std::to_string(given) +
           " points");
    points.clear();
    for (std::uint64_t k = 0; k < size; ++k)
      points.push_back(vertex(ids[static_cast<std::uint64_t>(offsets[i]) + k], cell));
    to_plain_order(types[i], points);
    ++volume_cells_[type].count;
    if (type == VTK_TETRA)
      mesh_.tets.push_back({points[0], points[1], points[2], points[3]});
    else if (lattice != nullptr)
      add_lattice(*lattice, points, cell);
    else if (prism != 0)
      add_prism(type, points, cell);
    else {
      check_room_for_splitting();
      cells_to_split_.add(type, points, cell, mesh_.tets.size());
    }
  }
  cell_count_ += cells;
}

void Assembler::add_cells(vtkUnstructuredGrid& grid, const PolyhedronFaces& faces) {
  vtkCellArray* cells = grid.GetCells();
  if (!cells) return;
  const auto add = [&](auto* offsets, auto* ids) {
    if (offsets->GetNumberOfValues() == 0) return;
    add_cells(grid, faces, offsets->GetPointer(0), static_cast<std::uint64_t>(offsets->GetNumberOfValues()),
              ids->GetPointer(0), static_cast<std::uint64_t>(ids->GetNumberOfValues()));
  };
  if (cells->IsStorage64Bit())
    add(cells->GetOffsetsArray64(), cells->GetConnectivityArray64());
  else
    add(cells->GetOffsetsArray32(), cells->GetConnectivityArray32());
}

void Assembler::look() const {
  if (progress_ && !progress_({"splitting cells", 0, 0})) throw Error(ErrorCode::kCancelled, "reading was cancelled");
}

void Assembler::note_cells(std::vector<std::uint64_t> cells, const std::string& what) {
  if (cells.empty()) return;
  std::sort(cells.begin(), cells.end()); // a cell of many parts may stand there more than once
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  std::string ids;
  for (std::size_t i = 0; i < std::min(cells.size(), kMostIds); ++i)
    ids += (i == 0 ? "" : ", ") + std::to_string(cells[i]);
  if (cells.size() > kMostIds) ids += ", ...";
  report_.notes.push_back(grouped(cells.size()) + (cells.size() == 1 ? " cell (" : " cells (") + ids + ") " + what);
}

std::string Assembler::what_to_do_with_refused() const {
  if (refused_cells_.contains(VTK_POLYHEDRON))
    return ": ptet reads polyhedra from .vtu files only; save the mesh as one, as ParaView does";
  const bool has_higher_order = std::any_of(refused_cells_.begin(), refused_cells_.end(), [](const auto& refused) {
    return refused.first >= VTK_LAGRANGE_CURVE && refused.first <= VTK_BEZIER_PYRAMID;
  }); // pyramids, those of Bezier, whose points are not on the cell, and what has the points of no order
  return std::string(", which ptet cannot split into tetrahedra: ") +
         (has_higher_order
              ? "write the mesh in tetrahedra, hexahedra or wedges of Lagrange's kind, of one order up to 64 along all "
                "edges"
              : "do so first, as ParaView's Tetrahedralize does");
}

TetMesh Assembler::finish() {
  std::vector<std::string> parts;
  for (const auto& [type, kind] : refused_cells_)
    parts.push_back(counted(kind.count, type) + " (first: cell " + std::to_string(kind.first_cell) + ")");
  if (!parts.empty()) fail("holds " + joined(parts) + what_to_do_with_refused());

  for (const auto& [type, kind] : flat_cells_)
    parts.push_back(counted(kind.count, type));
  if (volume_cells_.empty()) {
    if (ghost_cells_ != 0) parts.push_back(grouped(ghost_cells_) + " ghost cells");
    fail("holds " + (parts.empty() ? "no cells" : joined(parts) + " and no volume cells") + ": ptet needs tetrahedra");
  }
  if (!parts.empty()) report_.notes.push_back("skipped " + joined(parts));
  if (ghost_points_ != 0)
    report_.notes.push_back("the flags of points (vtkGhostType: duplicate or hidden) are not carried; they mark " +
                            grouped(ghost_points_) + (ghost_points_ == 1 ? " point" : " points"));
  if (ghost_cells_ != 0)
    report_.notes.push_back("skipped " + grouped(ghost_cells_) + (ghost_cells_ == 1 ? " ghost cell" : " ghost cells") +
                            " (vtkGhostType); points are kept");

  parts.clear();
  for (const auto& [type, kind] : volume_cells_) {
    if (type != VTK_TETRA) parts.push_back(counted(kind.count, type));
  }
  if (!parts.empty()) report_.notes.push_back("split " + joined(parts) + " into tetrahedra");
  if (middles_ != 0)
    report_.notes.push_back("added " + grouped(middles_) + (middles_ == 1 ? " point" : " points") +
                            " in the middle of cells, with the mean of the values around: they stand behind the "
                            "points of their piece");
  const CellSplitting::Unsplit unsplit = cells_to_split_.split(mesh_, [&] { look(); });
  note_cells(unsplit.turned, "cannot be split without turning tetrahedra over by any of the diagonals that were tried: "
                             "folded, or with faces that are warped too much");
  note_cells(unsplit.turned_parts,
             "cannot be split without turning tetrahedra over: no point was found in the middle of such a cell "
             "that sees all of its faces from within");
  note_cells(unsplit.gone, "left out: their points repeat, so that they have no volume");
  if (unsplit.paired != 0)
    report_.notes.push_back("left out " + grouped(unsplit.paired) +
                            " tetrahedra of cells that were split: pairs on the same points, one the other turned "
                            "over, at points that are in two faces of a cell alone");
  if (mesh_.tets.size() > kMaxRows)
    throw Error(ErrorCode::kLimit, path_ + ": more than " + grouped(kMaxRows) + " tetrahedra");
  return std::move(mesh_);
}

} // namespace ptet::vtkio
