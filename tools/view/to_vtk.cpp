#include "to_vtk.hpp"

#include <span>

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTypeInt64Array.h>

namespace ptet::view {
namespace {

/// VTK asks for memory that it may change, and changes none here.
template <class Array, class T>
vtkSmartPointer<Array> refer(const T* data, std::size_t count, int components = 1) {
  auto array = vtkSmartPointer<Array>::New();
  array->SetNumberOfComponents(components);
  constexpr int kKeep = 1;
  array->SetVoidArray(const_cast<T*>(data), static_cast<vtkIdType>(count), kKeep); // NOLINT(*-const-cast)
  return array;
}

vtkSmartPointer<vtkPoints> points_of(std::span<const Point> points) {
  auto result = vtkSmartPointer<vtkPoints>::New();
  result->SetData(refer<vtkDoubleArray>(points.empty() ? nullptr : points.front().data(), 3 * points.size(), 3));
  return result;
}

void set_values(vtkDataSet& data, std::span<const double> at_points, std::span<const double> at_cells) {
  const auto scalars = [](std::span<const double> values) {
    auto array = refer<vtkDoubleArray>(values.data(), values.size());
    array->SetName("value");
    return array;
  };
  if (!at_points.empty()) data.GetPointData()->SetScalars(scalars(at_points));
  if (!at_cells.empty()) data.GetCellData()->SetScalars(scalars(at_cells));
}

} // namespace

vtkSmartPointer<vtkPolyData> to_vtk(const Polygons& polygons) {
  auto result = vtkSmartPointer<vtkPolyData>::New();
  result->SetPoints(points_of(polygons.points));
  vtkNew<vtkCellArray> cells;
  cells->SetData(refer<vtkTypeInt64Array>(polygons.offsets.data(), polygons.offsets.size()),
                 refer<vtkTypeInt64Array>(polygons.corners.data(), polygons.corners.size()));
  result->SetPolys(cells);
  set_values(*result, polygons.point_values, polygons.cell_values);
  return result;
}

vtkSmartPointer<vtkUnstructuredGrid> to_vtk(const Cells& cells) {
  auto result = vtkSmartPointer<vtkUnstructuredGrid>::New();
  result->SetPoints(points_of(cells.points));
  vtkNew<vtkCellArray> tets;
  const std::int64_t* const corners = cells.tets.empty() ? nullptr : cells.tets.front().data();
  tets->SetData(4, refer<vtkTypeInt64Array>(corners, 4 * cells.tets.size()));
  result->SetCells(VTK_TETRA, tets);
  set_values(*result, cells.point_values, cells.cell_values);
  return result;
}

} // namespace ptet::view
