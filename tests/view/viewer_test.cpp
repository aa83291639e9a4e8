// The viewer's window under a virtual display: pictures by what must be in them, and events as a user makes them.
#include "formats/ptet/writer.hpp"
#include "support/file_parts.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/temp_folder.hpp"
#include "tools/view/viewer.hpp"
#include "tools/view/virtual_display.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <sys/resource.h>
#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkRendererCollection.h>

using namespace ptet;
using namespace ptet::view;

namespace {

void want_display() {
  static const std::unique_ptr<VirtualDisplay> display = has_display() ? nullptr : std::make_unique<VirtualDisplay>();
  REQUIRE(has_display());
}

std::shared_ptr<const Dataset> dataset() {
  static const auto opened = [] {
    const TetMesh mesh = test::grid({{6, 5, 5}, {}, 2, 3});
    return Dataset::open_memory(file::encode(mesh, test::simplify_naively(mesh), {}));
  }();
  return opened;
}

/// The same, as large as it is told; as doubles.
std::shared_ptr<const Dataset> dataset_of_size(double scale, double offset = 0) {
  TetMesh mesh = test::grid({{6, 5, 5}, {}, 2, 3});
  PointArray positions{"", ScalarType::kFloat64, 3, {}};
  positions.resize(mesh.vertex_count());
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    Point p = mesh.position(VertexId(v));
    for (double& x : p)
      x = offset + scale * x;
    std::memcpy(positions.bytes.data() + v * sizeof(Point), p.data(), sizeof(Point));
  }
  mesh.positions = positions;
  return Dataset::open_memory(file::encode(mesh, test::simplify_naively(mesh), {}));
}

Point middle() {
  const DatasetInfo& info = dataset()->info();
  Point p{};
  for (std::size_t i = 0; i < 3; ++i)
    p[i] = (info.box_min[i] + info.box_max[i]) / 2;
  return p;
}

Settings settings_for(Show show) {
  Settings settings;
  settings.show = show;
  settings.plane = plane_across(1, dataset()->info());
  return settings;
}

Look small() {
  Look look;
  look.width = 480;
  look.height = 360;
  return look;
}

using Colour = std::array<int, 3>;

class Picture {
public:
  explicit Picture(const std::string& path) {
    reader_->SetFileName(path.c_str());
    reader_->Update();
  }
  [[nodiscard]] int width() const { return reader_->GetOutput()->GetDimensions()[0]; }
  [[nodiscard]] int height() const { return reader_->GetOutput()->GetDimensions()[1]; }
  /// From the lower left.
  [[nodiscard]] Colour at(int x, int y) const {
    const auto* const p = static_cast<const unsigned char*>(reader_->GetOutput()->GetScalarPointer(x, y, 0));
    return {p[0], p[1], p[2]};
  }
  template <class Is>
  [[nodiscard]] int count(int from, int to, Is&& is) const {
    int found = 0;
    for (int x = from; x < to; ++x)
      for (int y = 0; y < height(); ++y)
        found += is(at(x, y)) ? 1 : 0;
    return found;
  }

private:
  vtkNew<vtkPNGReader> reader_;
};

bool is_drawn(const Colour& c) {
  return c != Colour{255, 255, 255};
}
bool is_blue(const Colour& c) {
  return c[2] > 150 && c[0] < 60 && c[1] < 140;
}

Picture picture_of(const Settings& settings, const Look& look, const std::shared_ptr<const Dataset>& data = dataset()) {
  want_display();
  const test::TempFolder folder;
  Viewer viewer(data, "test.ptet", settings, look, false);
  viewer.finish();
  viewer.write_picture(folder / "p.png");
  return Picture(folder / "p.png");
}

/// A viewer with a window, driven by events.
class Window {
public:
  explicit Window(const Settings& settings, const std::shared_ptr<const Dataset>& data = dataset()) {
    want_display();
    viewer_ = std::make_unique<Viewer>(data, "test.ptet", settings, small(), true);
    viewer_->advance();
    settle();
  }
  Viewer* operator->() { return viewer_.get(); }
  void press(const std::string& key) {
    events().SetKeySym(key.c_str());
    events().InvokeEvent(vtkCommand::KeyPressEvent);
    events().InvokeEvent(vtkCommand::CharEvent);
    settle();
  }
  void settle() {
    while (!viewer_->frame().is_complete)
      events().InvokeEvent(vtkCommand::TimerEvent);
  }
  void drag(int x0, int y0, int x1, int y1) {
    constexpr int kSteps = 5;
    move(x0, y0);
    events().InvokeEvent(vtkCommand::LeftButtonPressEvent);
    for (int i = 1; i <= kSteps; ++i)
      move(x0 + (x1 - x0) * i / kSteps, y0 + (y1 - y0) * i / kSteps);
    events().InvokeEvent(vtkCommand::LeftButtonReleaseEvent);
    settle();
  }
  /// Where a point of the domain is in the window.
  std::array<int, 2> place_of(const Point& p) {
    vtkRenderer* const renderer = viewer_->window().GetRenderers()->GetFirstRenderer();
    renderer->SetWorldPoint(p[0], p[1], p[2], 1);
    renderer->WorldToDisplay();
    return {int(renderer->GetDisplayPoint()[0]), int(renderer->GetDisplayPoint()[1])};
  }

private:
  vtkRenderWindowInteractor& events() { return *viewer_->interactor(); }
  void move(int x, int y) {
    events().SetEventInformation(x, y);
    events().InvokeEvent(vtkCommand::MouseMoveEvent);
  }
  std::unique_ptr<Viewer> viewer_;
};

/// Presses q when all is there, or after very many ticks.
struct Patience {
  Viewer* viewer;
  int ticks = 0;

  void on_tick() {
    constexpr int kMost = 2000;
    if (!viewer->frame().is_complete && ++ticks < kMost) return;
    viewer->interactor()->SetKeySym("q");
    viewer->interactor()->InvokeEvent(vtkCommand::KeyPressEvent);
  }
};

} // namespace

TEST_CASE("every representation draws something, and another thing") {
  std::set<int> amounts;
  Look look = small();
  look.text = false;
  for (const Show show : {Show::kSurface, Show::kCells, Show::kSlice, Show::kIsosurface, Show::kVolume}) {
    Settings settings = settings_for(show);
    settings.error = 0.1;
    settings.isovalue = 100;
    Scene scene(dataset());
    (void)scene.step(settings);
    settings.isovalue = (scene.frame().range.least + scene.frame().range.most) / 2;
    const Picture picture = picture_of(settings, look);
    CHECK(picture.width() == 480);
    CHECK(picture.height() == 360);
    // Above the scalar bar.
    int drawn = 0;
    for (int x = 0; x < 480; ++x)
      for (int y = 100; y < 360; ++y)
        drawn += is_drawn(picture.at(x, y)) ? 1 : 0;
    CHECK(drawn > 2000);
    CHECK(amounts.insert(drawn).second);
  }
}

TEST_CASE("meshes of any extent, anywhere, are drawn alike") {
  Look look = small();
  look.text = false;
  look.edges = false;
  const auto picture = [&](Show show, const std::shared_ptr<const Dataset>& data, double scale, double offset,
                           bool with_camera) {
    const DatasetInfo& info = data->info();
    Settings settings;
    settings.show = show;
    settings.error = 0;
    settings.plane = plane_across(1, info);
    settings.plane.offset += 0.37 * scale; // through the centre of no tet
    settings.focus = Sphere{{offset + scale * 48, offset + scale * 40, offset + scale * 40}, scale * 20};
    Look here = look;
    if (with_camera)
      here.camera = View{{offset + scale * 300, offset - scale * 250, offset + scale * 200},
                         {-260 * scale, 290 * scale, -160 * scale}};
    return picture_of(settings, here, data);
  };
  const auto differing = [](const Picture& a, const Picture& b) {
    int count = 0;
    for (int x = 0; x < 480; ++x) {
      for (int y = 100; y < 360; ++y) {
        const Colour p = a.at(x, y), q = b.at(x, y);
        count += std::abs(p[0] - q[0]) + std::abs(p[1] - q[1]) + std::abs(p[2] - q[2]) > 60 ? 1 : 0;
      }
    }
    return count;
  };
  const auto plain = dataset_of_size(1);
  for (const Show show : {Show::kSurface, Show::kCells, Show::kSlice, Show::kVolume}) {
    const bool with_camera = show == Show::kCells || show == Show::kVolume;
    const Picture wanted = picture(show, plain, 1, 0, with_camera);
    CHECK(wanted.count(0, 480, is_drawn) > 2000);
    for (const auto& [scale, offset] : {std::pair{1e-9, 0.0}, {1e-30, 0.0}, {1e20, 0.0}, {0.01, 1e6}}) {
      INFO(scale << " from " << offset << ", " << static_cast<int>(show));
      const auto data = dataset_of_size(scale, offset);
      CHECK(differing(wanted, picture(show, data, scale, offset, with_camera)) < 300); // of 124,800
    }
  }
}

TEST_CASE("the focus is outlined, and finer inside") {
  Settings settings = settings_for(Show::kSlice);
  const Picture without = picture_of(settings, small());
  settings.focus = Sphere{middle(), 0.2 * dataset()->info().diagonal};
  const Picture with = picture_of(settings, small());
  CHECK(without.count(0, 480, is_blue) == 0);
  CHECK(with.count(0, 480, is_blue) > 100);
  const auto is_dark = [](const Colour& c) { return c[0] + c[1] + c[2] < 330 && c[0] < 140; };
  CHECK(with.count(0, 480, is_dark) > without.count(0, 480, is_dark)); // more edges
}

TEST_CASE("a split screen has the original on the right") {
  Settings settings = settings_for(Show::kSlice);
  Look look = small();
  look.width = 800;
  look.split = true;
  look.text = false;
  const Picture picture = picture_of(settings, look);
  const int left = picture.count(0, 400, is_drawn), right = picture.count(400, 800, is_drawn);
  CHECK(left > 4000);
  CHECK(right > 4000);
  int differing = 0;
  for (int x = 0; x < 400; ++x)
    for (int y = 100; y < 360; ++y)
      differing += picture.at(x, y) != picture.at(x + 400, y) ? 1 : 0;
  CHECK(differing > 500);
}

TEST_CASE("keys do what the table says") {
  Window window(settings_for(Show::kSurface));
  window.press("3");
  CHECK(window->settings().show == Show::kSlice);
  window.press("2");
  CHECK(window->settings().show == Show::kCells);
  window.press("5");
  CHECK(window->settings().show == Show::kVolume);
  CHECK(!window->frame().cells.tets.empty());
  window.press("4");
  CHECK(window->settings().show == Show::kIsosurface);
  REQUIRE(window->settings().isovalue);
  CHECK(window->frame().polygons.count() > 0);
  const double isovalue = *window->settings().isovalue;
  window.press("Right");
  CHECK(*window->settings().isovalue > isovalue);
  window.press("1");
  const std::uint64_t coarse = window->frame().tets;
  CHECK(coarse == dataset()->info().base_tets);
  for (int i = 0; i < 12; ++i)
    window.press("Down");
  REQUIRE(window->settings().error);
  CHECK(window->frame().tets > coarse);
  window.press("Up");
  CHECK(*window->settings().error < 0.01);
  const double offset = window->settings().plane.offset;
  window.press("x");
  CHECK(window->settings().plane.normal == Point{1, 0, 0});
  window.press("y");
  CHECK(window->settings().plane.offset == offset);
  window.press("f");
  CHECK(window->settings().plane.normal == Point{0, 1, 0});
  CHECK(window->settings().plane.offset == -offset);
  for (std::size_t field = 1; field < dataset()->info().fields.size(); ++field) {
    window.press("c");
    CHECK(window->settings().colour == ColourBy{ColourKind::kField, field});
  }
  window.press("c");
  CHECK(window->settings().colour.kind == ColourKind::kError);
  window.press("c");
  CHECK(window->settings().colour.kind == ColourKind::kLevel);
  window.press("c");
  CHECK(window->settings().colour == ColourBy{});
  window.press("e");
  CHECK_FALSE(window->look().edges);
  window.press("s");
  CHECK(window->look().split);
  while (!window->original_frame()->is_complete)
    window->advance();
  CHECK(window->original_frame()->tets == dataset()->info().tets);
  window.press("s");
  CHECK_FALSE(window->look().split);
  window.press("h");
  window.press("r");
  window.press("w"); // of no meaning here: VTK's own keys are not in force
  window.press("b");
  REQUIRE(window->settings().focus);
  CHECK(std::holds_alternative<Box>(*window->settings().focus));
  window.press("n");
  CHECK_FALSE(window->settings().focus);
}

TEST_CASE("a screen that is split has the mesh in either half, and stays as the user has turned it") {
  Window window(settings_for(Show::kSurface));
  vtkCamera& camera = *window->window().GetRenderers()->GetFirstRenderer()->GetActiveCamera();
  const double whole = camera.GetDistance();
  window.press("s");
  CHECK(camera.GetDistance() > 1.2 * whole); // half as wide
  window.press("s");
  CHECK(camera.GetDistance() == Approx(whole));
  camera.Azimuth(40);
  window.press("s");
  CHECK(camera.GetDistance() == Approx(whole));
  window.press("r");
  CHECK(camera.GetDistance() > 1.2 * whole);
}

TEST_CASE("the error slider is dragged") {
  Window window(settings_for(Show::kSurface));
  REQUIRE_FALSE(window->settings().error); // the slider is at its right end
  const std::uint64_t coarse = window->frame().tets;
  window.drag(int(0.311 * 480), int(0.05 * 360), int(0.12 * 480), int(0.05 * 360));
  REQUIRE(window->settings().error);
  CHECK(*window->settings().error < 0.05);
  CHECK(window->frame().tets > coarse);
  window.drag(int(0.12 * 480), int(0.05 * 360), int(0.02 * 480), int(0.05 * 360));
  CHECK(window->settings().error == 0.0);
  CHECK(window->frame().tets == dataset()->info().tets);
}

TEST_CASE("the plane's slider moves the slice") {
  Window window(settings_for(Show::kSlice));
  const double place = window->settings().plane.place(); // on y: the normal points the other way
  const auto y = int(0.05 * 360);
  window.drag(int(0.825 * 480), y, int(0.9 * 480), y);
  CHECK(window->settings().plane.place() > place);
  const std::uint64_t number = window->frame().number;
  window.drag(int(0.9 * 480), y, int(0.75 * 480), y);
  CHECK(window->settings().plane.place() < place);
  CHECK(window->frame().number > number);
}

TEST_CASE("the focus is dragged, and the original appears inside") {
  for (const std::string key : {"o", "b"}) {
    Window window(settings_for(Show::kSurface));
    const std::uint64_t coarse = window->frame().tets;
    window.press(key);
    CHECK(window->frame().tets > coarse);
    REQUIRE(window->settings().focus);
    const Region before = *window->settings().focus;
    const auto [x, y] = window.place_of(middle());
    window.drag(x, y, x + 50, y + 15);
    const Region after = *window->settings().focus;
    CHECK_FALSE(after == before);
    Request request;
    request.focus.push_back({after});
    CHECK(window->frame().tets == dataset()->extract(request).mesh.tets.size());
    CHECK(after.index() == before.index());
    if (key == "o") {
      CHECK(std::get<Sphere>(after).centre[0] > std::get<Sphere>(before).centre[0]);
      CHECK(std::get<Sphere>(after).radius == Approx(std::get<Sphere>(before).radius));
    }
  }
}

TEST_CASE("the focus of a tiny mesh is dragged in its own units") {
  constexpr double kScale = 1e-9;
  const auto data = dataset_of_size(kScale);
  for (const std::string key : {"o", "b"}) {
    Window window({}, data);
    const std::uint64_t coarse = window->frame().tets;
    window.press(key);
    CHECK(window->frame().tets > coarse);
    REQUIRE(window->settings().focus);
    const Region before = *window->settings().focus;
    const auto [x, y] = window.place_of({0, 0, 0}); // where the middle is drawn
    window.drag(x, y, x + 50, y + 15);
    const Region after = *window->settings().focus;
    CHECK_FALSE(after == before);
    REQUIRE(after.index() == before.index());
    Request request;
    request.focus.push_back({after});
    CHECK(window->frame().tets == data->extract(request).mesh.tets.size());
    if (key == "o") {
      const Sphere &from = std::get<Sphere>(before), &to = std::get<Sphere>(after);
      CHECK(to.centre[0] - from.centre[0] > 5 * kScale);
      CHECK(to.centre[0] - from.centre[0] < 96 * kScale);
      CHECK(to.radius == Approx(from.radius));
    }
  }
}

// In a process of its own: VTK 9.1 keeps interactors whose loop never ran on a list that the next loop goes through.
TEST_CASE("the window opens at once, fills as blocks come, and closes", "[.loop]") {
  want_display();
  const TetMesh mesh = test::grid({{6, 5, 5}, {}, 2, 3});
  std::atomic<bool> is_held = true;
  const auto source = std::make_shared<test::FailingSource>(file::encode(mesh, test::simplify_naively(mesh), {}));
  OpenOptions options;
  options.background = true;
  const auto slow = Dataset::open(source, options);
  source->set([&](std::uint64_t, std::uint64_t) {
    while (is_held)
      std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return false;
  });
  Settings settings = settings_for(Show::kSurface);
  settings.error = 0;
  Viewer viewer(slow, "a.ptet", settings, small(), true);
  CHECK(viewer.advance());
  CHECK(viewer.frame().tets < mesh.tets.size());
  is_held = false;
  Patience patience{&viewer};
  viewer.interactor()->AddObserver(vtkCommand::TimerEvent, &patience, &Patience::on_tick);
  viewer.interact();
  CHECK(viewer.frame().is_complete);
  CHECK(viewer.frame().tets == mesh.tets.size());
}

TEST_CASE("a picture that cannot be written is an error") {
  want_display();
  Viewer viewer(dataset(), "test.ptet", settings_for(Show::kSurface), small(), false);
  viewer.finish();
  CHECK_THROWS_AS(viewer.write_picture("/nonexistent/p.png"), Error);
  // A file that can grow to no more than some bytes.
  const test::TempFolder folder;
  const std::string path = folder / "p.png";
  viewer.write_picture(path);
  const std::string before = test::read_bytes(path);
  viewer.execute(Command::kSlice);
  const auto restore = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &limit) == 0);
  const rlimit small_limit{100, limit.rlim_max};
  REQUIRE(setrlimit(RLIMIT_FSIZE, &small_limit) == 0);
  CHECK_THROWS_AS(viewer.write_picture(path), Error);
  const std::filesystem::path before_in = std::filesystem::current_path();
  std::filesystem::current_path(folder / "");
  CHECK_NOTHROW(viewer.execute(Command::kPicture)); // a key ends no window
  REQUIRE(setrlimit(RLIMIT_FSIZE, &limit) == 0);
  (void)std::signal(SIGXFSZ, restore);
  CHECK(test::read_bytes(path) == before);
  CHECK(folder.names() == std::vector<std::string>{"p.png"});
  viewer.execute(Command::kPicture);
  viewer.execute(Command::kPicture);
  std::filesystem::current_path(before_in);
  CHECK(folder.names() == std::vector<std::string>{"p.png", "ptet-view-2.png", "ptet-view.png"});
}
