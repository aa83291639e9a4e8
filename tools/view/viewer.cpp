#include "viewer.hpp"

#include "caption.hpp"
#include "formats/whole_file.hpp"
#include "ink.hpp"
#include "number.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <span>
#include <system_error>

#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkCommand.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSliderWidget.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

namespace ptet::view {
namespace {

constexpr double kStepMs = 20; // of a step while the user waits
constexpr int kTimerMs = 15;   // between looks for more to do
constexpr double kRadian = 180 / 3.14159265358979323846;
// The slider of the error bound: the logarithm of percents; at its left end 0, at its right end none.
constexpr double kLeastLog = -2.25, kMostLog = 2;

struct ColourStop {
  double at, red, green, blue;
};
/// Light to dark, of one hue family, so that edges stay visible and a printed copy keeps the order.
constexpr std::array<ColourStop, 6> kSequential = {{{0.0, 0.99, 0.97, 0.89},
                                                    {0.2, 0.99, 0.87, 0.58},
                                                    {0.4, 0.98, 0.69, 0.35},
                                                    {0.6, 0.93, 0.46, 0.27},
                                                    {0.8, 0.78, 0.25, 0.24},
                                                    {1.0, 0.52, 0.10, 0.20}}};

/// The mouse turns, moves and zooms as usual; keys are the viewer's, none of VTK's own.
class ViewerStyle : public vtkInteractorStyleTrackballCamera {
public:
  static ViewerStyle* New();
  vtkTypeMacro(ViewerStyle, vtkInteractorStyleTrackballCamera) ViewerStyle(const ViewerStyle&) = delete;
  ViewerStyle& operator=(const ViewerStyle&) = delete;
  void OnChar() override {}

protected:
  ViewerStyle() = default;
  ~ViewerStyle() override = default;
};
vtkStandardNewMacro(ViewerStyle)

    double log_of(const std::optional<double>& error) {
  if (!error) return kMostLog;
  return *error <= 0 ? kLeastLog : std::clamp(std::log10(100 * *error), kLeastLog, kMostLog);
}
std::optional<double> error_at(double log) {
  if (log >= kMostLog) return std::nullopt;
  return log <= kLeastLog ? 0 : std::pow(10, log) / 100;
}

/// What the second slider sets.
double place_of(const Settings& settings) {
  return settings.show == Show::kIsosurface ? settings.isovalue.value_or(0) : settings.plane.place();
}

} // namespace

Plane plane_across(std::size_t axis, const DatasetInfo& info) {
  Plane plane{{0, 0, 0}, 0};
  plane.normal[axis] = axis == 1 ? -1 : 1;
  plane.offset = plane.normal[axis] * (info.box_min[axis] + info.box_max[axis]) / 2;
  return plane;
}

Viewer::Viewer(const std::shared_ptr<const Dataset>& dataset, std::string name, const Settings& settings,
               const Look& look, bool on_screen)
    : dataset_(dataset), name_(std::move(name)), settings_(settings), look_(look), scene_(dataset),
      window_(vtkSmartPointer<vtkRenderWindow>::New()), left_(vtkSmartPointer<vtkRenderer>::New()),
      right_(vtkSmartPointer<vtkRenderer>::New()), colours_(vtkSmartPointer<vtkColorTransferFunction>::New()),
      camera_(vtkSmartPointer<vtkCamera>::New()), left_panel_(*left_, *colours_), right_panel_(*right_, *colours_),
      overlay_(*colours_, look.width, look.height, help_on_keys()) {
  colours_->SetNanColor(kGrey[0], kGrey[1], kGrey[2]);
  window_->SetNumberOfLayers(2);
  window_->SetMultiSamples(4);
  window_->SetSize(look_.width, look_.height);
  window_->SetWindowName(("ptet view " + name_).c_str());
  if (!on_screen) window_->SetOffScreenRendering(1);
  for (vtkRenderer* renderer : {left_.GetPointer(), right_.GetPointer()}) {
    renderer->SetBackground(1, 1, 1);
    renderer->SetActiveCamera(camera_);
  }
  window_->AddRenderer(left_);
  window_->AddRenderer(&overlay_.renderer());
  if (on_screen) make_interactive();
  arrange_panels();
  place_camera();
}

Viewer::~Viewer() {
  if (interactor_ == nullptr) return;
  focus_widgets_.reset();
  error_slider_->SetInteractor(nullptr);
  place_slider_->SetInteractor(nullptr);
  // Window and interactor hold each other.
  interactor_->SetInteractorStyle(nullptr);
  window_->SetInteractor(nullptr);
  interactor_->SetRenderWindow(nullptr);
}

vtkRenderWindow& Viewer::window() const {
  return *window_;
}
vtkRenderWindowInteractor* Viewer::interactor() const {
  return interactor_;
}

void Viewer::make_interactive() {
  interactor_ = vtkSmartPointer<vtkRenderWindowInteractor>::New();
  interactor_->SetRenderWindow(window_);
  interactor_->SetInteractorStyle(vtkSmartPointer<ViewerStyle>::New());
  interactor_->AddObserver(vtkCommand::KeyPressEvent, this, &Viewer::on_key);
  interactor_->AddObserver(vtkCommand::TimerEvent, this, &Viewer::on_timer);
  interactor_->Initialize();

  error_slider_ = overlay_.make_slider(*interactor_, 0.03, 0.32);
  place_slider_ = overlay_.make_slider(*interactor_, 0.68, 0.97);
  error_slider_->AddObserver(vtkCommand::InteractionEvent, this, &Viewer::on_error_slider);
  place_slider_->AddObserver(vtkCommand::InteractionEvent, this, &Viewer::on_place_slider);
  error_slider_->EnabledOn();

  focus_widgets_ = std::make_unique<FocusWidgets>(*interactor_, *left_, [this](const Region& drawn) {
    settings_.focus = scene_.placement().in_file(drawn);
    step(); // the widget draws
  });
  show_focus_widget();
}

Point Viewer::eye() const {
  Point at{};
  camera_->GetPosition(at.data());
  return at;
}

void Viewer::place_camera() {
  find_place_of_camera();
  placed_at_ = eye();
}

void Viewer::find_place_of_camera() {
  if (look_.camera) {
    const View& view = *look_.camera;
    const Point at = {view.eye[0] + view.direction[0], view.eye[1] + view.direction[1],
                      view.eye[2] + view.direction[2]};
    camera_->SetPosition(scene_.placement().drawn(view.eye).data());
    camera_->SetFocalPoint(scene_.placement().drawn(at).data());
    camera_->SetViewUp(view.up.data());
    camera_->SetViewAngle(view.vertical_angle * kRadian);
    return;
  }
  const DatasetInfo& info = dataset_->info();
  camera_->SetViewAngle(30);
  camera_->SetFocalPoint(0, 0, 0);
  camera_->SetPosition(0.45, -1, 0.4);
  camera_->SetViewUp(0, 0, 1);
  const Point low = scene_.placement().drawn(info.box_min);
  const Point high = scene_.placement().drawn(info.box_max);
  std::array<double, 6> bounds{};
  for (std::size_t i = 0; i < 3; ++i) {
    bounds[2 * i] = low[i];
    bounds[2 * i + 1] = high[i];
  }
  left_->ResetCamera(bounds.data());
  // The ball around the box fits; where there is room at both sides, the box may be nearer.
  const int* const size = window_->GetSize();
  camera_->Zoom(std::clamp((look_.split ? 0.5 : 1.0) * size[0] / std::max(1, size[1]), 1.0, 1.3));
}

std::optional<Region> Viewer::drawn_focus() const {
  if (!settings_.focus) return std::nullopt;
  return scene_.placement().drawn(*settings_.focus);
}

void Viewer::arrange_panels() {
  left_->SetViewport(0, 0, look_.split ? 0.5 : 1, 1);
  right_->SetViewport(0.5, 0, 1, 1);
  window_->RemoveRenderer(right_);
  if (!look_.split) return;
  window_->AddRenderer(right_);
  if (!original_) original_ = std::make_unique<Scene>(dataset_);
}

Settings Viewer::original_settings() const {
  Settings settings = settings_;
  settings.error = 0;
  settings.max_tets.reset();
  settings.max_vertices.reset();
  settings.focus.reset();
  return settings;
}

bool Viewer::step() {
  scene_.step(settings_, kStepMs);
  bool is_complete = scene_.frame().is_complete;
  if (look_.split) is_complete = original_->step(original_settings(), kStepMs).is_complete && is_complete;
  refresh();
  return !is_complete;
}

bool Viewer::advance() {
  const bool is_more = step();
  window_->Render();
  return is_more;
}

void Viewer::finish() {
  while (!scene_.step(settings_).is_complete)
    dataset_->wait_until_loaded();
  while (look_.split && !original_->step(original_settings()).is_complete)
    dataset_->wait_until_loaded();
  refresh();
  window_->Render();
}

void Viewer::refresh() {
  set_colours();
  left_panel_.show(scene_.frame(), settings_.show, look_.edges);
  const bool is_dragged = focus_widgets_ && focus_widgets_->is_shown();
  const std::optional<Region> focus = drawn_focus();
  left_panel_.show_focus(is_dragged ? std::nullopt : focus);
  if (look_.text) {
    const std::string text = caption(name_, dataset_->info(), settings_, scene_.frame());
    left_panel_.set_title(text + (notice_.empty() ? "" : "\n" + notice_));
  }
  if (look_.split) {
    right_panel_.show(original_->frame(), settings_.show, look_.edges);
    right_panel_.show_focus(focus);
    if (look_.text)
      right_panel_.set_title("the original" + std::string(original_->frame().is_complete ? "" : ", loading ..."));
  }
  constexpr double kMostLevels = 12;
  const bool by_level = settings_.colour.kind == ColourKind::kLevel && shown_range_.most <= kMostLevels;
  overlay_.describe_colours(name_of(settings_.colour, dataset_->info()), shown_range_,
                            by_level ? std::optional(1 + static_cast<int>(shown_range_.most)) : std::nullopt);
  set_sliders();
  left_->ResetCameraClippingRange();
}

void Viewer::set_colours() {
  Range range = scene_.frame().range;
  if (look_.split && !original_->frame().range.empty()) {
    range.widen(original_->frame().range.least);
    range.widen(original_->frame().range.most);
  }
  const bool has_gaps = range.has_gaps || (look_.split && original_->frame().range.has_gaps);
  if (look_.range && settings_.colour.kind == ColourKind::kField) range = *look_.range;
  if (range.empty()) range = {0, 1};
  range.has_gaps = has_gaps;
  if (range.least == range.most) range.most = range.least + std::max(1e-12, std::fabs(range.least) * 1e-6);
  if (range == shown_range_) return;
  shown_range_ = range;
  colours_->RemoveAllPoints();
  for (const ColourStop& stop : kSequential)
    colours_->AddRGBPoint(range.least + stop.at * (range.most - range.least), stop.red, stop.green, stop.blue);
  const double size = scene_.placement().drawn(dataset_->info().diagonal);
  left_panel_.set_range(range, size);
  right_panel_.set_range(range, size);
}

Range Viewer::reach_of_place() const {
  const DatasetInfo& info = dataset_->info();
  Range reach;
  if (settings_.show == Show::kIsosurface) return scene_.mesh().range(1);
  if (const std::optional<std::size_t> axis = settings_.plane.axis()) return {info.box_min[*axis], info.box_max[*axis]};
  for (unsigned bits = 0; bits < 8; ++bits) {
    double offset = 0;
    for (std::size_t i = 0; i < 3; ++i)
      offset += settings_.plane.normal[i] * ((bits >> i & 1U) != 0 ? info.box_max[i] : info.box_min[i]);
    reach.widen(offset);
  }
  return reach;
}

void Viewer::set_place(double value) {
  const Range reach = reach_of_place();
  if (reach.empty()) return;
  const double place = std::clamp(value, reach.least, reach.most);
  if (settings_.show == Show::kIsosurface)
    settings_.isovalue = place;
  else
    settings_.plane.move_to(place);
}

void Viewer::set_sliders() {
  if (!error_slider_) return;
  set_slider(*error_slider_, {kLeastLog, kMostLog}, log_of(settings_.error),
             "error bound: " + name_of_error(settings_.error));

  const bool is_iso = settings_.show == Show::kIsosurface;
  const bool has_place = is_iso || settings_.show == Show::kCells || settings_.show == Show::kSlice;
  const Range reach = reach_of_place();
  if ((place_slider_->GetEnabled() != 0) != (has_place && !reach.empty()))
    place_slider_->SetEnabled(has_place && !reach.empty() ? 1 : 0);
  if (!has_place || reach.empty()) return;
  const double place = place_of(settings_);
  const std::string where = is_iso || !settings_.plane.axis() ? brief_within(reach.most - reach.least, place)
                                                              : name_of(settings_.plane, dataset_->info());
  set_slider(*place_slider_, reach, place, (is_iso ? "isovalue: " : "plane: ") + where);
}

void Viewer::on_error_slider() {
  settings_.error = error_at(value_of(*error_slider_));
  step(); // the widget draws
}

void Viewer::on_place_slider() {
  set_place(value_of(*place_slider_));
  step();
}

void Viewer::on_timer() {
  const bool is_complete = scene_.frame().is_complete && (!look_.split || original_->frame().is_complete);
  if (!is_complete) advance();
}

void Viewer::on_key() {
  const char* const symbol = interactor_->GetKeySym();
  if (symbol == nullptr) return;
  if (const std::optional<Command> command = command_of(symbol)) execute(*command);
}

void Viewer::show_focus_widget() {
  if (focus_widgets_) focus_widgets_->show(drawn_focus());
}

void Viewer::start_focus(bool is_box) {
  const DatasetInfo& info = dataset_->info();
  Box box;
  Sphere sphere{{}, 0.1 * info.diagonal};
  for (std::size_t i = 0; i < 3; ++i) {
    sphere.centre[i] = (info.box_min[i] + info.box_max[i]) / 2;
    const double half = 0.15 * (info.box_max[i] - info.box_min[i]);
    box.min[i] = sphere.centre[i] - half;
    box.max[i] = sphere.centre[i] + half;
  }
  settings_.focus = is_box ? Region{box} : Region{sphere};
}

void Viewer::change_error(double factor) {
  const double log = log_of(settings_.error) + std::log10(factor);
  settings_.error = error_at(std::clamp(log, kLeastLog, kMostLog));
}

void Viewer::next_colour() {
  ColourBy& colour = settings_.colour;
  switch (colour.kind) {
  case ColourKind::kField:
    if (colour.field + 1 < dataset_->info().fields.size())
      ++colour.field;
    else
      colour.kind = ColourKind::kError;
    break;
  case ColourKind::kError: colour.kind = ColourKind::kLevel; break;
  case ColourKind::kLevel:
    colour = dataset_->info().fields.empty() ? ColourBy{ColourKind::kError, 0} : ColourBy{};
    break;
  }
}

/// In the working directory, beside those that are there.
void Viewer::keep_picture() {
  std::string path = "ptet-view.png";
  std::error_code status;
  for (int i = 2; std::filesystem::exists(path, status); ++i)
    path = "ptet-view-" + std::to_string(i) + ".png";
  advance(); // without what the last command had to say
  try {
    write_picture(path);
    notice_ = "written: " + path;
  } catch (const Error& error) { // no reason to lose what is on the screen
    notice_ = error.what();
  }
}

void Viewer::execute(Command command) {
  notice_.clear();
  const auto move_place = [&](double part) {
    const Range reach = reach_of_place();
    set_place(place_of(settings_) + part * (reach.most - reach.least));
  };
  switch (command) {
  case Command::kSurface: settings_.show = Show::kSurface; break;
  case Command::kCells: settings_.show = Show::kCells; break;
  case Command::kSlice: settings_.show = Show::kSlice; break;
  case Command::kIsosurface:
    settings_.show = Show::kIsosurface;
    if (!settings_.isovalue) set_place((reach_of_place().least + reach_of_place().most) / 2);
    break;
  case Command::kVolume: settings_.show = Show::kVolume; break;
  case Command::kNextColour: next_colour(); break;
  case Command::kFiner: change_error(0.5); break;
  case Command::kCoarser: change_error(2); break;
  case Command::kBack: move_place(-0.02); break;
  case Command::kForth: move_place(0.02); break;
  case Command::kPlaneX: settings_.plane = plane_across(0, dataset_->info()); break;
  case Command::kPlaneY: settings_.plane = plane_across(1, dataset_->info()); break;
  case Command::kPlaneZ: settings_.plane = plane_across(2, dataset_->info()); break;
  case Command::kFlipPlane:
    for (double& x : settings_.plane.normal)
      x = -x;
    settings_.plane.offset = -settings_.plane.offset;
    break;
  case Command::kFocusBox:
  case Command::kFocusSphere: start_focus(command == Command::kFocusBox); break;
  case Command::kNoFocus: settings_.focus.reset(); break;
  case Command::kEdges: look_.edges = !look_.edges; break;
  case Command::kSplit: {
    const bool is_as_placed = eye() == placed_at_;
    look_.split = !look_.split;
    arrange_panels();
    if (is_as_placed) place_camera(); // there is another room for it now
    break;
  }
  case Command::kResetCamera: place_camera(); break;
  case Command::kPicture: keep_picture(); break;
  case Command::kHelp: overlay_.toggle_help(); break;
  case Command::kQuit:
    if (interactor_ != nullptr) interactor_->TerminateApp();
    return;
  }
  if (command == Command::kFocusBox || command == Command::kFocusSphere || command == Command::kNoFocus)
    show_focus_widget();
  advance();
}

void Viewer::interact() {
  advance();
  interactor_->CreateRepeatingTimer(kTimerMs);
  interactor_->Start();
}

void Viewer::write_picture(const std::string& path) {
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(window_);
  image->SetInputBufferTypeToRGB();
  image->ReadFrontBufferOff();
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(image->GetOutputPort());
  writer->WriteToMemoryOn();
  writer->Write();
  const vtkUnsignedCharArray* const bytes = writer->GetResult();
  const unsigned char* const begin = const_cast<vtkUnsignedCharArray*>(bytes)->GetPointer(0); // NOLINT
  WholeFile file(path);
  file.write(std::as_bytes(std::span(begin, static_cast<std::size_t>(bytes->GetNumberOfValues()))));
  file.commit();
}

} // namespace ptet::view
