#include "panel.hpp"

#include "ink.hpp"
#include "to_vtk.hpp"

#include <cmath>

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProjectedTetrahedraMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

namespace ptet::view {
namespace {

constexpr std::array<double, 3> kEdge = {0.20, 0.20, 0.24};

/// Lines that show where a region is.
class Outline {
public:
  void operator()(const Box& box) {
    std::array<Point, 3> half{};
    Point centre{};
    for (std::size_t i = 0; i < 3; ++i) {
      centre[i] = (box.min[i] + box.max[i]) / 2;
      half[i][i] = (box.max[i] - box.min[i]) / 2;
    }
    (*this)(OrientedBox{centre, half});
  }
  void operator()(const OrientedBox& box) {
    const auto corner = [&](unsigned bits) {
      Point p = box.centre;
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t i = 0; i < 3; ++i)
          p[i] += (bits >> axis & 1U) != 0 ? box.half_axes[axis][i] : -box.half_axes[axis][i];
      return p;
    };
    for (unsigned a = 0; a < 8; ++a)
      for (unsigned axis = 0; axis < 3; ++axis)
        if ((a >> axis & 1U) == 0) line({corner(a), corner(a | 1U << axis)});
  }
  void operator()(const Sphere& sphere) {
    constexpr int kSteps = 64;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<Point> circle;
      for (int i = 0; i <= kSteps; ++i) {
        const double angle_rad = 2 * 3.14159265358979323846 * i / kSteps;
        Point p = sphere.centre;
        p[(axis + 1) % 3] += sphere.radius * std::cos(angle_rad);
        p[(axis + 2) % 3] += sphere.radius * std::sin(angle_rad);
        circle.push_back(p);
      }
      line(circle);
    }
  }
  void operator()(const HalfSpace& /*all of one side*/) {}

  [[nodiscard]] vtkSmartPointer<vtkPolyData> lines() const {
    auto result = vtkSmartPointer<vtkPolyData>::New();
    result->SetPoints(points_);
    result->SetLines(lines_);
    return result;
  }

private:
  void line(const std::vector<Point>& through) {
    lines_->InsertNextCell(static_cast<int>(through.size()));
    for (const Point& p : through)
      lines_->InsertCellPoint(points_->InsertNextPoint(p.data()));
  }

  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> lines_;
};

} // namespace

Panel::Panel(vtkRenderer& renderer, vtkColorTransferFunction& colours)
    : mapper_(vtkSmartPointer<vtkPolyDataMapper>::New()), actor_(vtkSmartPointer<vtkActor>::New()),
      volume_mapper_(vtkSmartPointer<vtkProjectedTetrahedraMapper>::New()),
      opacity_(vtkSmartPointer<vtkPiecewiseFunction>::New()), volume_(vtkSmartPointer<vtkVolume>::New()),
      focus_mapper_(vtkSmartPointer<vtkPolyDataMapper>::New()), focus_(vtkSmartPointer<vtkActor>::New()),
      title_(vtkSmartPointer<vtkTextActor>::New()) {
  mapper_->SetLookupTable(&colours);
  mapper_->UseLookupTableScalarRangeOn();
  mapper_->InterpolateScalarsBeforeMappingOn();
  actor_->SetMapper(mapper_);
  actor_->GetProperty()->SetInterpolationToFlat();
  actor_->GetProperty()->SetEdgeColor(kEdge[0], kEdge[1], kEdge[2]);
  actor_->VisibilityOff();
  renderer.AddActor(actor_);

  volume_->SetMapper(volume_mapper_);
  volume_->GetProperty()->SetColor(&colours);
  volume_->GetProperty()->SetScalarOpacity(opacity_);
  volume_->GetProperty()->SetInterpolationTypeToLinear();
  volume_->GetProperty()->ShadeOff();
  volume_->VisibilityOff();
  renderer.AddVolume(volume_);

  focus_->SetMapper(focus_mapper_);
  focus_->GetProperty()->SetColor(kAccent[0], kAccent[1], kAccent[2]);
  focus_->GetProperty()->SetLineWidth(2.5F);
  focus_->GetProperty()->LightingOff();
  focus_->PickableOff();
  focus_->VisibilityOff();
  renderer.AddActor(focus_);

  title_->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  title_->SetPosition(0.015, 0.985);
  vtkTextProperty* const text = title_->GetTextProperty();
  text->SetFontSize(15);
  text->SetLineSpacing(1.15);
  text->SetColor(kInk[0], kInk[1], kInk[2]);
  text->SetVerticalJustificationToTop();
  text->SetBackgroundColor(1, 1, 1);
  text->SetBackgroundOpacity(0.75);
  renderer.AddActor2D(title_);
}

void Panel::show(const Frame& frame, Show show, bool edges) {
  const bool is_volume = show == Show::kVolume;
  if (shown_number_ != frame.number) {
    shown_number_ = frame.number;
    mapper_->SetInputData(to_vtk(frame.polygons));
    if (is_volume) volume_mapper_->SetInputData(to_vtk(frame.cells));
  }
  // The mapper of volumes wants something to draw.
  volume_->SetVisibility(is_volume && !frame.cells.tets.empty() ? 1 : 0);
  actor_->SetVisibility(!is_volume && frame.polygons.count() != 0 ? 1 : 0);
  vtkProperty& look = *actor_->GetProperty();
  look.SetEdgeVisibility(edges ? 1 : 0);
  look.SetLineWidth(frame.polygons.count() > 20000 ? 0.6F : 1.0F);
  // Flat pictures want their colours as they are, bent ones some shade.
  const bool is_flat = show == Show::kSlice;
  look.SetAmbient(is_flat ? 1.0 : 0.55);
  look.SetDiffuse(is_flat ? 0.0 : 0.5);
}

void Panel::show_focus(const std::optional<Region>& region) {
  focus_->SetVisibility(region ? 1 : 0);
  if (!region) return;
  Outline outline;
  std::visit(outline, *region);
  focus_mapper_->SetInputData(outline.lines());
}

void Panel::set_range(const Range& range, double size) {
  opacity_->RemoveAllPoints();
  opacity_->AddPoint(range.least, 0);
  opacity_->AddPoint(range.least + 0.25 * (range.most - range.least), 0.15);
  opacity_->AddPoint(range.most, 0.9);
  volume_->GetProperty()->SetScalarOpacityUnitDistance(size / 50);
}

void Panel::set_title(const std::string& text) {
  title_->SetInput(text.c_str());
}

} // namespace ptet::view
