#include "grid.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

namespace ptet::paraview {
namespace {

int vtk_type(ScalarType type) {
  static constexpr int kTypes[] = {VTK_TYPE_INT8,    VTK_TYPE_UINT8,  VTK_TYPE_INT16, VTK_TYPE_UINT16,
                                   VTK_TYPE_INT32,   VTK_TYPE_UINT32, VTK_TYPE_INT64, VTK_TYPE_UINT64,
                                   VTK_TYPE_FLOAT32, VTK_TYPE_FLOAT64};
  return kTypes[static_cast<std::size_t>(type)];
}

/// The slots in use by ascending id in the file, and where each slot went.
struct Rows {
  std::vector<std::uint32_t> slots;
  std::vector<std::uint32_t> of_slot;
};

Rows rows_of(const Session& session, std::uint64_t vertices_in_file) {
  const auto vertices = session.vertex_in_file();
  std::vector<std::uint32_t> slot_of(vertices_in_file, Session::kUnused);
  for (std::uint32_t slot = 0; slot < vertices.size(); ++slot)
    if (!vertices[slot].is_none()) slot_of[vertices[slot].index()] = slot;
  Rows rows;
  rows.of_slot.assign(vertices.size(), Session::kUnused);
  for (const std::uint32_t slot : slot_of) {
    if (slot == Session::kUnused) continue;
    rows.of_slot[slot] = static_cast<std::uint32_t>(rows.slots.size());
    rows.slots.push_back(slot);
  }
  return rows;
}

/// The rows of a tet's corners in ascending order, but for the last two where the orientation wants it.
std::array<std::uint32_t, 4> corners(const std::array<std::uint32_t, 4>& tet, const Rows& rows) {
  std::array<std::uint32_t, 4> row{};
  for (std::size_t i = 0; i < 4; ++i)
    row[i] = rows.of_slot[tet[i]];
  bool is_odd = false;
  static constexpr std::array<std::array<std::size_t, 2>, 5> kNetwork = {{{0, 1}, {2, 3}, {0, 2}, {1, 3}, {1, 2}}};
  for (const auto& [i, j] : kNetwork) {
    if (row[i] < row[j]) continue;
    std::swap(row[i], row[j]);
    is_odd = !is_odd;
  }
  if (is_odd) std::swap(row[2], row[3]);
  return row;
}

/// The tets in use, sorted by their corners.
std::vector<std::array<std::uint32_t, 4>> sorted_tets(const Session& session, const Rows& rows) {
  std::vector<std::array<std::uint32_t, 4>> unsorted;
  std::vector<std::size_t> begin(rows.slots.size() + 1, 0); // of those with this first corner
  for (const auto& tet : session.tets()) {
    if (tet[0] == Session::kUnused) continue;
    unsorted.push_back(corners(tet, rows));
    ++begin[unsorted.back()[0] + std::size_t{1}];
  }
  for (std::size_t i = 1; i < begin.size(); ++i)
    begin[i] += begin[i - 1];
  std::vector<std::array<std::uint32_t, 4>> tets(unsorted.size());
  std::vector<std::size_t> next = begin;
  for (const auto& tet : unsorted)
    tets[next[tet[0]]++] = tet;
  for (std::size_t i = 0; i + 1 < begin.size(); ++i)
    std::sort(tets.begin() + static_cast<std::ptrdiff_t>(begin[i]),
              tets.begin() + static_cast<std::ptrdiff_t>(begin[i + 1]));
  return tets;
}

vtkSmartPointer<vtkCellArray> cells_of(const std::vector<std::array<std::uint32_t, 4>>& tets) {
  vtkNew<vtkIdTypeArray> offsets;
  vtkNew<vtkIdTypeArray> ids;
  vtkIdType* next_offset = offsets->WritePointer(0, static_cast<vtkIdType>(tets.size() + 1));
  vtkIdType* next_id = ids->WritePointer(0, static_cast<vtkIdType>(4 * tets.size()));
  for (std::size_t i = 0; i <= tets.size(); ++i)
    *next_offset++ = static_cast<vtkIdType>(4 * i);
  for (const auto& tet : tets)
    next_id = std::copy(tet.begin(), tet.end(), next_id);
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  cells->SetData(offsets, ids);
  return cells;
}

/// The rows of the slots in use.
vtkSmartPointer<vtkDataArray> copy_of(const PointArray& array, const Rows& rows) {
  vtkSmartPointer<vtkDataArray> copy;
  copy.TakeReference(vtkDataArray::CreateDataArray(vtk_type(array.type)));
  copy->SetName(array.name.c_str());
  copy->SetNumberOfComponents(static_cast<int>(array.components));
  copy->SetNumberOfTuples(static_cast<vtkIdType>(rows.slots.size()));
  const std::size_t row_bytes = array.row_bytes();
  auto* to = static_cast<std::byte*>(copy->GetVoidPointer(0));
  for (const std::uint32_t slot : rows.slots) {
    std::memcpy(to, array.bytes.data() + slot * row_bytes, row_bytes);
    to += row_bytes;
  }
  return copy;
}

template <class Array, class Value>
void add(vtkFieldData& data, const std::string& name, Value value) {
  vtkNew<Array> array;
  array->SetName(name.c_str());
  array->InsertNextValue(value);
  data.AddArray(array);
}

} // namespace

void fill_mesh(vtkUnstructuredGrid& grid, const Session& session, const DatasetInfo& info,
               const std::function<bool(const std::string&)>& wanted, bool file_ids) {
  const Rows rows = rows_of(session, info.vertices);
  vtkNew<vtkPoints> points;
  points->SetData(copy_of(session.positions(), rows));
  grid.SetPoints(points);
  grid.SetCells(VTK_TETRA, cells_of(sorted_tets(session, rows)));
  for (const PointArray& array : session.point_arrays())
    if (wanted(array.name)) grid.GetPointData()->AddArray(copy_of(array, rows));
  if (!file_ids) return;
  vtkNew<vtkIdTypeArray> ids;
  ids->SetName("vertex in file");
  ids->SetNumberOfValues(static_cast<vtkIdType>(rows.slots.size()));
  for (std::size_t i = 0; i < rows.slots.size(); ++i)
    ids->SetValue(static_cast<vtkIdType>(i), session.vertex_in_file()[rows.slots[i]].index());
  grid.GetPointData()->SetGlobalIds(ids);
}

void fill_errors(vtkUnstructuredGrid& grid, const SessionUpdate& update, const DatasetInfo& info) {
  vtkFieldData& data = *grid.GetFieldData();
  std::size_t governing = 0;
  for (const FieldInfo& field : info.fields) {
    if (!field.governing) continue;
    add<vtkDoubleArray>(data, "error of " + field.name, update.field_error[governing]);
    if (!update.rms_error.empty()) add<vtkDoubleArray>(data, "RMS error of " + field.name, update.rms_error[governing]);
    ++governing;
  }
  add<vtkDoubleArray>(data, "domain error", update.domain_error);
  if (update.covered) add<vtkDoubleArray>(data, "covered", *update.covered);
  add<vtkStringArray>(data, "limited by", name_of(update.limited_by));
  add<vtkUnsignedCharArray>(data, "complete", static_cast<unsigned char>(update.complete ? 1 : 0));
  add<vtkIdTypeArray>(data, "tets of the original", static_cast<vtkIdType>(info.tets));
  add<vtkIdTypeArray>(data, "points of the original", static_cast<vtkIdType>(info.vertices));
}

} // namespace ptet::paraview
