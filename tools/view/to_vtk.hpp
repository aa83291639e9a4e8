// From a frame into VTK's structures. Nothing is copied: they refer to the frame's memory, and are of use until the
// scene's next step.
#pragma once

#include "scene.hpp"

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

namespace ptet::view {

/// Scalars are at the points or at the polygons, as the values are.
[[nodiscard]] vtkSmartPointer<vtkPolyData> to_vtk(const Polygons& polygons);
[[nodiscard]] vtkSmartPointer<vtkUnstructuredGrid> to_vtk(const Cells& cells);

} // namespace ptet::view
