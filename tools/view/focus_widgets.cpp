#include "focus_widgets.hpp"

#include "ink.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <vtkBoxRepresentation.h>
#include <vtkBoxWidget2.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSphereRepresentation.h>
#include <vtkSphereWidget2.h>

namespace ptet::view {
namespace {

Point corner(vtkPolyData& data, vtkIdType row) {
  Point p{};
  data.GetPoints()->GetPoint(row, p.data());
  return p;
}

Point half_way(const Point& from, const Point& to) {
  return {(to[0] - from[0]) / 2, (to[1] - from[1]) / 2, (to[2] - from[2]) / 2};
}

/// As VTK's representation has it: eight corners, x before y before z, but those of a face in a cycle.
Region region_of(vtkBoxRepresentation& box) {
  vtkNew<vtkPolyData> data;
  box.GetPolyData(data);
  const Point first = corner(*data, 0);
  const OrientedBox turned{
      half_way(Point{},
               {first[0] + corner(*data, 6)[0], first[1] + corner(*data, 6)[1], first[2] + corner(*data, 6)[2]}),
      {half_way(first, corner(*data, 1)), half_way(first, corner(*data, 3)), half_way(first, corner(*data, 4))}};
  double largest = 0, askew = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      (i == j ? largest : askew) = std::max(i == j ? largest : askew, std::fabs(turned.half_axes[i][j]));
  if (askew > 1e-9 * largest) return turned;
  Box straight;
  for (std::size_t i = 0; i < 3; ++i) {
    const double half = std::fabs(turned.half_axes[i][i]);
    straight.min[i] = turned.centre[i] - half;
    straight.max[i] = turned.centre[i] + half;
  }
  return straight;
}

void attach(vtkAbstractWidget& widget, vtkRenderWindowInteractor& interactor, vtkRenderer& renderer) {
  widget.SetInteractor(&interactor);
  widget.SetDefaultRenderer(&renderer);
  widget.SetCurrentRenderer(&renderer);
  widget.KeyPressActivationOff();
}

} // namespace

FocusWidgets::FocusWidgets(vtkRenderWindowInteractor& interactor, vtkRenderer& renderer,
                           std::function<void(const Region&)> on_drag)
    : on_drag_(std::move(on_drag)), box_(vtkSmartPointer<vtkBoxWidget2>::New()),
      sphere_(vtkSmartPointer<vtkSphereWidget2>::New()) {
  vtkNew<vtkBoxRepresentation> box;
  box->SetPlaceFactor(1);
  box->GetOutlineProperty()->SetColor(kAccent[0], kAccent[1], kAccent[2]);
  box->GetOutlineProperty()->SetLineWidth(2.5F);
  box->HandlesOn();
  box_->SetRepresentation(box);
  attach(*box_, interactor, renderer);
  box_->AddObserver(vtkCommand::InteractionEvent, this, &FocusWidgets::on_box);

  vtkNew<vtkSphereRepresentation> sphere;
  sphere->SetPlaceFactor(1);
  sphere->SetRepresentationToWireframe();
  sphere->HandleVisibilityOff();
  sphere->HandleTextOff();
  sphere->RadialLineOff();
  sphere->GetSphereProperty()->SetColor(kAccent[0], kAccent[1], kAccent[2]);
  sphere->GetSphereProperty()->LightingOff();
  sphere->GetSelectedSphereProperty()->SetColor(kAccent[0], kAccent[1], kAccent[2]);
  sphere->GetSelectedSphereProperty()->LightingOff();
  sphere_->SetRepresentation(sphere);
  attach(*sphere_, interactor, renderer);
  sphere_->AddObserver(vtkCommand::InteractionEvent, this, &FocusWidgets::on_sphere);
}

FocusWidgets::~FocusWidgets() {
  box_->SetInteractor(nullptr);
  sphere_->SetInteractor(nullptr);
}

bool FocusWidgets::is_shown() const {
  return box_->GetEnabled() != 0 || sphere_->GetEnabled() != 0;
}

void FocusWidgets::show(const std::optional<Region>& focus) {
  const bool is_box = focus && std::holds_alternative<Box>(*focus);
  const bool is_sphere = focus && std::holds_alternative<Sphere>(*focus);
  if (is_box) {
    const Box& box = std::get<Box>(*focus);
    std::array<double, 6> bounds = {box.min[0], box.max[0], box.min[1], box.max[1], box.min[2], box.max[2]};
    box_->GetRepresentation()->PlaceWidget(bounds.data());
  }
  if (is_sphere) {
    const Sphere& region = std::get<Sphere>(*focus);
    auto* const sphere = vtkSphereRepresentation::SafeDownCast(sphere_->GetRepresentation());
    std::array<double, 6> bounds{};
    for (std::size_t i = 0; i < 3; ++i) {
      bounds[2 * i] = region.centre[i] - region.radius;
      bounds[2 * i + 1] = region.centre[i] + region.radius;
    }
    sphere->PlaceWidget(bounds.data());
    std::array<double, 3> centre = region.centre;
    sphere->SetCenter(centre.data());
    sphere->SetRadius(region.radius);
  }
  box_->SetEnabled(is_box ? 1 : 0);
  sphere_->SetEnabled(is_sphere ? 1 : 0);
}

void FocusWidgets::on_box() {
  on_drag_(region_of(*vtkBoxRepresentation::SafeDownCast(box_->GetRepresentation())));
}

void FocusWidgets::on_sphere() {
  auto* const sphere = vtkSphereRepresentation::SafeDownCast(sphere_->GetRepresentation());
  Sphere region;
  sphere->GetCenter(region.centre.data());
  region.radius = sphere->GetRadius();
  on_drag_(region);
}

} // namespace ptet::view
