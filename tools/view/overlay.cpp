#include "overlay.hpp"

#include "ink.hpp"
#include "number.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <vtkColorTransferFunction.h>
#include <vtkNew.h>
#include <vtkProperty2D.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkSliderRepresentation2D.h>
#include <vtkSliderWidget.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

namespace ptet::view {
namespace {

constexpr double kBarWidth = 0.28, kBottom = 0.025; // parts of the window

void set_look(vtkTextProperty* text, int size) {
  text->SetFontSize(size);
  text->SetColor(kInk[0], kInk[1], kInk[2]);
  text->BoldOff();
  text->ItalicOff();
  text->ShadowOff();
}

} // namespace

Overlay::Overlay(vtkColorTransferFunction& colours, int width, int height, const std::string& help)
    : width_(width), height_(height), renderer_(vtkSmartPointer<vtkRenderer>::New()),
      bar_(vtkSmartPointer<vtkScalarBarActor>::New()), title_(vtkSmartPointer<vtkTextActor>::New()),
      help_(vtkSmartPointer<vtkTextActor>::New()) {
  renderer_->SetLayer(1);
  renderer_->InteractiveOff();

  bar_->SetLookupTable(&colours);
  bar_->SetMaximumNumberOfColors(256);
  bar_->SetOrientationToHorizontal();
  bar_->SetWidth(kBarWidth);
  bar_->SetHeight(std::min(0.5, 48.0 / height));
  bar_->UnconstrainedFontSizeOn();
  set_look(bar_->GetLabelTextProperty(), 14);
  set_look(bar_->GetAnnotationTextProperty(), 14);
  bar_->DrawBackgroundOn();
  bar_->GetBackgroundProperty()->SetColor(1, 1, 1);
  bar_->GetBackgroundProperty()->SetOpacity(0.75);
  renderer_->AddActor2D(bar_);
  title_->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  set_look(title_->GetTextProperty(), 16);
  title_->GetTextProperty()->SetBackgroundColor(1, 1, 1);
  title_->GetTextProperty()->SetBackgroundOpacity(0.75);
  title_->GetTextProperty()->SetJustificationToCentered();
  renderer_->AddActor2D(title_);

  help_->SetInput(help.c_str());
  help_->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  help_->SetPosition(std::max(0.0, 1 - 450.0 / width), 0.97);
  set_look(help_->GetTextProperty(), 14);
  help_->GetTextProperty()->SetFontFamilyToCourier();
  help_->GetTextProperty()->SetVerticalJustificationToTop();
  help_->GetTextProperty()->SetBackgroundColor(1, 1, 1);
  help_->GetTextProperty()->SetBackgroundOpacity(0.85);
  help_->VisibilityOff();
  renderer_->AddActor2D(help_);
}

vtkRenderer& Overlay::renderer() const {
  return *renderer_;
}

void Overlay::describe_colours(const std::string& title, const Range& range, std::optional<int> labels) {
  constexpr double kDigit = 8.5; // pixels
  const int digits = digits_within(range.most - range.least, std::max(std::fabs(range.least), std::fabs(range.most)));
  const double label = kDigit * (digits + 3); // a sign, a point, a gap
  bar_->SetLabelFormat(("%." + std::to_string(digits) + "g").c_str());
  bar_->SetNumberOfLabels(labels ? *labels : std::clamp(static_cast<int>(kBarWidth * width_ / label), 2, 5));
  // What stands for values that are none has its name below it.
  const double bottom = kBottom + (range.has_gaps ? 18.0 / height_ : 0);
  bar_->SetDrawNanAnnotation(range.has_gaps ? 1 : 0);
  bar_->GetPositionCoordinate()->SetValue(0.5 - kBarWidth / 2, bottom);
  title_->SetPosition(0.5, bottom + bar_->GetHeight() - 10.0 / height_);
  title_->SetInput(title.c_str());
}

void Overlay::toggle_help() {
  help_->SetVisibility(help_->GetVisibility() == 0 ? 1 : 0);
}

vtkSmartPointer<vtkSliderWidget> Overlay::make_slider(vtkRenderWindowInteractor& interactor, double left,
                                                      double right) const {
  vtkNew<vtkSliderRepresentation2D> slider;
  slider->GetPoint1Coordinate()->SetCoordinateSystemToNormalizedViewport();
  slider->GetPoint1Coordinate()->SetValue(left, 0.05);
  slider->GetPoint2Coordinate()->SetCoordinateSystemToNormalizedViewport();
  slider->GetPoint2Coordinate()->SetValue(right, 0.05);
  slider->ShowSliderLabelOff();
  slider->SetTubeWidth(0.004);
  slider->SetSliderLength(0.012);
  slider->SetSliderWidth(0.022);
  slider->SetEndCapLength(0.003);
  slider->SetEndCapWidth(0.012);
  slider->SetTitleHeight(0.02);
  set_look(slider->GetTitleProperty(), 14);
  slider->GetTubeProperty()->SetColor(kGrey[0], kGrey[1], kGrey[2]);
  slider->GetCapProperty()->SetColor(kGrey[0], kGrey[1], kGrey[2]);
  slider->GetSliderProperty()->SetColor(kAccent[0], kAccent[1], kAccent[2]);
  slider->GetSelectedProperty()->SetColor(kInk[0], kInk[1], kInk[2]);
  auto widget = vtkSmartPointer<vtkSliderWidget>::New();
  widget->SetInteractor(&interactor);
  widget->SetDefaultRenderer(renderer_);
  widget->SetCurrentRenderer(renderer_);
  widget->SetRepresentation(slider);
  widget->SetAnimationModeToJump();
  widget->KeyPressActivationOff();
  return widget;
}

void set_slider(vtkSliderWidget& slider, const Range& reach, double value, const std::string& title) {
  auto* const shown = vtkSliderRepresentation2D::SafeDownCast(slider.GetRepresentation());
  shown->SetMinimumValue(reach.least);
  shown->SetMaximumValue(reach.most);
  shown->SetValue(value);
  shown->SetTitleText(title.c_str());
}

double value_of(vtkSliderWidget& slider) {
  return vtkSliderRepresentation::SafeDownCast(slider.GetRepresentation())->GetValue();
}

} // namespace ptet::view
