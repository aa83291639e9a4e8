// The window: panels, sliders, the focus widgets, keys. It holds the settings, changes them as the user does, and shows
// what the scenes make of them.
//
//    ____________________________________
//   | caption          | original        |     panels, one or two, with one camera
//   |                  |                 |
//   |      box or sphere to drag         |     an overlay over both: scalar bar, sliders, help
//   |__--o-----__[scalar bar]__----o---__|
//      error bound          plane or isovalue
//
// Thread rule: one thread, the one that opened the display. interact() is for a process that had no other viewer with a
// screen before (a fault of VTK 9.1's event loop).
#pragma once

#include "focus_widgets.hpp"
#include "keys.hpp"
#include "overlay.hpp"
#include "panel.hpp"
#include "scene.hpp"

#include <memory>
#include <optional>
#include <string>

#include <vtkSmartPointer.h>

class vtkCamera;
class vtkColorTransferFunction;
class vtkRenderer;
class vtkRenderWindow;
class vtkRenderWindowInteractor;
class vtkSliderWidget;

namespace ptet::view {

struct Look {
  int width = 1280, height = 800; ///< pixels
  bool edges = true;
  bool split = false;
  bool text = true;           ///< captions, in pictures
  std::optional<Range> range; ///< of the colours; none: that of what was seen so far
  std::optional<View> camera; ///< none: all of it, seen from the front, right and above
};

/// The plane across an axis through the middle of the box that shows its cut to a camera at the front, right and above.
[[nodiscard]] Plane plane_across(std::size_t axis, const DatasetInfo& info);

class Viewer {
public:
  /// `name`: of the file, for captions. Without a screen it draws off-screen and has no interactor. An X server must
  /// be there in any case, see virtual_display.hpp.
  Viewer(const std::shared_ptr<const Dataset>& dataset, std::string name, const Settings& settings, const Look& look,
         bool on_screen);
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  /// Until the user quits. Wants a dataset that loads in the background, else it waits for reads.
  void interact();
  /// One step of bounded time towards what is asked, and draws. False: there is no more to do.
  bool advance();
  /// Goes all the way, waiting for blocks, and draws.
  void finish();
  /// What was last drawn, as PNG, whole or not at all. Throws Error(kIo); a file of that name is as it was then.
  void write_picture(const std::string& path);
  void execute(Command command);

  [[nodiscard]] const Settings& settings() const { return settings_; }
  [[nodiscard]] const Look& look() const { return look_; }
  [[nodiscard]] const Frame& frame() const { return scene_.frame(); }
  /// nullptr: the screen was never split.
  [[nodiscard]] const Frame* original_frame() const { return original_ ? &original_->frame() : nullptr; }
  [[nodiscard]] vtkRenderWindow& window() const;
  [[nodiscard]] vtkRenderWindowInteractor* interactor() const; ///< nullptr when off-screen

private:
  void make_interactive();
  void place_camera();
  void find_place_of_camera();
  [[nodiscard]] Point eye() const;
  void arrange_panels();

  void on_key();
  void on_timer();
  void on_error_slider();
  void on_place_slider();

  bool step();
  void refresh();
  void set_colours();
  void set_sliders();
  void show_focus_widget();
  [[nodiscard]] std::optional<Region> drawn_focus() const;
  void start_focus(bool is_box);
  [[nodiscard]] Settings original_settings() const;
  /// Least and largest place of the plane that cuts the box, or isovalue.
  [[nodiscard]] Range reach_of_place() const;
  void set_place(double value);
  void keep_picture();
  void change_error(double factor);
  void next_colour();

  std::shared_ptr<const Dataset> dataset_;
  std::string name_;
  Settings settings_;
  Look look_;
  Scene scene_;
  std::unique_ptr<Scene> original_;
  Range shown_range_;
  std::string notice_; ///< what the last command has to say, below the caption

  vtkSmartPointer<vtkRenderWindow> window_;
  vtkSmartPointer<vtkRenderer> left_, right_;
  vtkSmartPointer<vtkColorTransferFunction> colours_;
  vtkSmartPointer<vtkCamera> camera_;
  Point placed_at_{}; ///< where the camera is if nobody has moved it
  Panel left_panel_, right_panel_;
  Overlay overlay_;
  vtkSmartPointer<vtkRenderWindowInteractor> interactor_;
  vtkSmartPointer<vtkSliderWidget> error_slider_, place_slider_;
  std::unique_ptr<FocusWidgets> focus_widgets_; ///< on a screen only
};

} // namespace ptet::view
