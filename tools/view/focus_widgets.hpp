// A box and a sphere to drag: which of them is there depends on the region in focus, and where it is dragged to is the
// region next.
#pragma once

#include "ptet/request.hpp"

#include <functional>
#include <optional>

#include <vtkSmartPointer.h>

class vtkBoxWidget2;
class vtkRenderer;
class vtkRenderWindowInteractor;
class vtkSphereWidget2;

namespace ptet::view {

class FocusWidgets {
public:
  /// `on_drag` is called with the region after every step of a drag. Both are hidden at first.
  FocusWidgets(vtkRenderWindowInteractor& interactor, vtkRenderer& renderer,
               std::function<void(const Region&)> on_drag);
  ~FocusWidgets();
  FocusWidgets(const FocusWidgets&) = delete;
  FocusWidgets& operator=(const FocusWidgets&) = delete;

  /// The widget that fits the region takes its place; none for other shapes, nor where there is no region.
  void show(const std::optional<Region>& focus);
  /// Whether one of them is there.
  [[nodiscard]] bool is_shown() const;

private:
  void on_box();
  void on_sphere();

  std::function<void(const Region&)> on_drag_;
  vtkSmartPointer<vtkBoxWidget2> box_;
  vtkSmartPointer<vtkSphereWidget2> sphere_;
};

} // namespace ptet::view
