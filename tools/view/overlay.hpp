// What lies over the panels: the scalar bar with its title, the help on keys, and sliders; and the inks that it is
// drawn with.
#pragma once

#include "scene.hpp"

#include <optional>
#include <string>

#include <vtkSmartPointer.h>

class vtkColorTransferFunction;
class vtkRenderer;
class vtkRenderWindowInteractor;
class vtkScalarBarActor;
class vtkSliderWidget;
class vtkTextActor;

namespace ptet::view {

class Overlay {
public:
  /// `width`, `height`: of the window, pixels. `help`: hidden at first.
  Overlay(vtkColorTransferFunction& colours, int width, int height, const std::string& help);

  [[nodiscard]] vtkRenderer& renderer() const;
  /// What the colours stand for, from where to where, and how many numbers stand at the bar; none: as there is room.
  void describe_colours(const std::string& title, const Range& range, std::optional<int> labels);
  void toggle_help();
  /// `left`, `right`: its ends, parts of the width. The caller takes it from the interactor before that goes.
  [[nodiscard]] vtkSmartPointer<vtkSliderWidget> make_slider(vtkRenderWindowInteractor& interactor, double left,
                                                             double right) const;

private:
  const int width_, height_;
  vtkSmartPointer<vtkRenderer> renderer_;
  vtkSmartPointer<vtkScalarBarActor> bar_;
  vtkSmartPointer<vtkTextActor> title_, help_;
};

/// Least value, value, greatest value, and what stands above it.
void set_slider(vtkSliderWidget& slider, const Range& reach, double value, const std::string& title);
[[nodiscard]] double value_of(vtkSliderWidget& slider);

} // namespace ptet::view
