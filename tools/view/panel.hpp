// One viewport: what a frame holds as VTK draws it, and the outline of the focus region.
#pragma once

#include "scene.hpp"

#include <optional>

#include <vtkSmartPointer.h>

class vtkActor;
class vtkColorTransferFunction;
class vtkPolyDataMapper;
class vtkProjectedTetrahedraMapper;
class vtkPiecewiseFunction;
class vtkRenderer;
class vtkTextActor;
class vtkVolume;

namespace ptet::view {

class Panel {
public:
  /// `colours` is shared by all panels.
  Panel(vtkRenderer& renderer, vtkColorTransferFunction& colours);

  /// What is drawn from now on. The frame must stay as it is until the next call.
  void show(const Frame& frame, Show show, bool edges);
  void show_focus(const std::optional<Region>& region);
  /// Least and largest value, where volumes are clear and where they are dense; `size` is the diagonal of the box.
  void set_range(const Range& range, double size);
  void set_title(const std::string& text);

private:
  vtkSmartPointer<vtkPolyDataMapper> mapper_;
  vtkSmartPointer<vtkActor> actor_;
  vtkSmartPointer<vtkProjectedTetrahedraMapper> volume_mapper_;
  vtkSmartPointer<vtkPiecewiseFunction> opacity_;
  vtkSmartPointer<vtkVolume> volume_;
  vtkSmartPointer<vtkPolyDataMapper> focus_mapper_;
  vtkSmartPointer<vtkActor> focus_;
  vtkSmartPointer<vtkTextActor> title_;
  std::uint64_t shown_number_ = 0;
};

} // namespace ptet::view
