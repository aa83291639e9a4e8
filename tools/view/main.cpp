// The program ptet-view, which `ptet view` starts: options and a file into settings, then a window or a picture.
#include "formats/file_names.hpp"
#include "ptet/dataset.hpp"
#include "tools/ptet/arguments.hpp"
#include "tools/ptet/console.hpp"
#include "tools/ptet/files.hpp"
#include "tools/ptet/view_options.hpp"
#include "viewer.hpp"
#include "virtual_display.hpp"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace ptet::cli {
namespace {

[[noreturn]] void refuse(const std::string& option, const std::string& text, const std::string& why) {
  throw Error(ErrorCode::kBadArgument, option + " '" + text + "': " + why);
}

view::Show parse_show(const std::string& text) {
  static const std::vector<std::pair<std::string, view::Show>> kNames = {{"surface", view::Show::kSurface},
                                                                         {"cells", view::Show::kCells},
                                                                         {"slice", view::Show::kSlice},
                                                                         {"iso", view::Show::kIsosurface},
                                                                         {"volume", view::Show::kVolume}};
  for (const auto& [name, show] : kNames)
    if (name == text) return show;
  refuse("--show", text, "surface, cells, slice, iso or volume is wanted");
}

view::Range parse_range(const std::string& text) {
  const std::size_t dots = text.find("..");
  const auto number = [&](const std::string& part) {
    const std::optional<double> value = finite(part);
    if (!value) refuse("--range", text, "MIN..MAX is wanted, two finite numbers");
    return *value;
  };
  const view::Range range{number(text.substr(0, dots)), number(dots == std::string::npos ? "" : text.substr(dots + 2))};
  if (!(range.least < range.most)) refuse("--range", text, "MIN must be less than MAX");
  return range;
}

/// See the help.
view::Plane parse_plane(const std::string& text, const DatasetInfo& info) {
  constexpr const char* kWanted = "x, y or z, with a place such as y:1.7, or nx,ny,nz,d is wanted";
  if (text.find(',') != std::string::npos) {
    const std::vector<double> numbers = parse_numbers("--plane", text, text);
    if (numbers.size() != 4) refuse("--plane", text, kWanted);
    const Point normal{numbers[0], numbers[1], numbers[2]};
    if (normal == Point{}) refuse("--plane", text, "the normal is 0,0,0");
    return {normal, numbers[3]};
  }
  const bool has_sign = text.starts_with('+') || text.starts_with('-');
  const std::string name = text.substr(has_sign ? 1 : 0, text.find(':') - (has_sign ? 1 : 0));
  const std::size_t axis = std::string("xyz").find(name);
  if (name.size() != 1 || axis == std::string::npos) refuse("--plane", text, kWanted);
  view::Plane plane = view::plane_across(axis, info);
  if (has_sign && (text.front() == '-') != (plane.normal[axis] < 0)) plane = {{}, -plane.offset};
  if (has_sign) plane.normal[axis] = text.front() == '-' ? -1 : 1;
  if (const std::size_t colon = text.find(':'); colon != std::string::npos) {
    const std::optional<double> place = finite(text.substr(colon + 1));
    if (!place) refuse("--plane", text, "a finite number is wanted after the colon, such as y:1.7");
    plane.offset = plane.normal[axis] * *place;
  }
  return plane;
}

std::size_t field_named(const std::string& option, const std::string& name, const DatasetInfo& info) {
  std::vector<std::string> names;
  for (const FieldInfo& field : info.fields) {
    if (field.name == name) return names.size();
    names.push_back(field.name);
  }
  throw Error(ErrorCode::kBadArgument, option + ": there is no field '" + name + "'; there are: " + quoted_list(names));
}

/// A field named error or level is reached by its name all the same.
view::ColourBy parse_colour(const std::optional<std::string>& text, const DatasetInfo& info) {
  const bool is_field = text && std::any_of(info.fields.begin(), info.fields.end(),
                                            [&](const FieldInfo& field) { return field.name == *text; });
  if (!is_field && ((text && *text == "error") || (!text && info.fields.empty()))) return {view::ColourKind::kError, 0};
  if (!is_field && text && *text == "level") return {view::ColourKind::kLevel, 0};
  return {view::ColourKind::kField, text ? field_named("--colour", *text, info) : 0};
}

std::optional<double> parse_error(const ViewArguments& arguments) {
  if (!arguments.error) {
    const bool asks_else = arguments.tets || arguments.vertices || arguments.focus;
    return asks_else ? std::nullopt : std::optional(0.01);
  }
  if (*arguments.error == "none") return std::nullopt;
  const Bound bound = parse_bound("--error", *arguments.error);
  if (!bound.relative && bound.value != 0)
    refuse("--error", *arguments.error, "a percentage such as 1% is wanted, 0 or none");
  return bound.value;
}

view::Settings settings_of(const ViewArguments& arguments, const DatasetInfo& info) {
  view::Settings settings;
  if (arguments.show) settings.show = parse_show(*arguments.show);
  settings.colour = parse_colour(arguments.colour, info);
  settings.error = parse_error(arguments);
  if (arguments.tets) settings.max_tets = parse_count("--tets", *arguments.tets).of(info.tets);
  if (arguments.vertices) settings.max_vertices = parse_count("--vertices", *arguments.vertices).of(info.vertices);
  if (arguments.focus) settings.focus = parse_region("--focus", *arguments.focus);
  settings.plane = parse_plane(arguments.plane.value_or("y"), info);
  settings.iso_field = settings.colour.field;
  if (arguments.isovalue) {
    const ValuesOfInterest values = parse_isovalue("--isovalue", *arguments.isovalue);
    settings.iso_field = field_named("--isovalue", values.field, info);
    settings.isovalue = values.min;
  } else if (settings.show == view::Show::kIsosurface) {
    throw Error(ErrorCode::kBadArgument, "--show iso: --isovalue FIELD=V is wanted, too");
  }
  return settings;
}

view::Look look_of(const ViewArguments& arguments) {
  view::Look look;
  if (arguments.size) {
    constexpr std::uint64_t kLeast = 64, kMost = 16384;
    const std::size_t times = std::min(arguments.size->find('x'), arguments.size->size());
    look.width = static_cast<int>(parse_whole("--size", arguments.size->substr(0, times), kLeast, kMost));
    const std::size_t second = std::min(times + 1, arguments.size->size());
    look.height = static_cast<int>(parse_whole("--size", arguments.size->substr(second), kLeast, kMost));
  }
  if (arguments.range) look.range = parse_range(*arguments.range);
  if (arguments.camera) look.camera = parse_view("--camera", *arguments.camera, false);
  look.edges = !arguments.no_edges;
  look.split = arguments.split;
  look.text = !arguments.no_text;
  return look;
}

void make_picture(const ViewArguments& arguments, const view::Look& look) {
  if (ending_of(*arguments.screenshot) != ".png")
    refuse("--screenshot", *arguments.screenshot, "the ending must be .png");
  const std::string target = checked_output("--screenshot", *arguments.screenshot, arguments.input);
  OpenOptions options;
  options.limits = machine_limits();
  const auto dataset = Dataset::open(arguments.input, options);
  const view::Settings settings = settings_of(arguments, dataset->info());
  std::unique_ptr<view::VirtualDisplay> display;
  if (!view::has_display()) display = std::make_unique<view::VirtualDisplay>();
  {
    view::Viewer viewer(dataset, std::filesystem::path(arguments.input).filename(), settings, look, false);
    viewer.finish();
    if (settings.show == view::Show::kIsosurface && viewer.frame().polygons.count() == 0)
      std::cerr << "ptet: note: there is no isosurface: nothing of the mesh has the value of --isovalue\n";
    if (settings.show == view::Show::kSlice && viewer.frame().polygons.count() == 0)
      std::cerr << "ptet: note: there is no slice: nothing of the mesh is at --plane\n";
    if (settings.show == view::Show::kCells && viewer.frame().polygons.count() == 0)
      std::cerr << "ptet: note: nothing is drawn: no cell has its centre behind --plane\n";
    for (const view::Frame* frame : {&viewer.frame(), viewer.original_frame()})
      if (frame != nullptr && !frame->failure.empty())
        throw Error(frame->failure_code, "the picture cannot be had in full: " + frame->failure);
    viewer.write_picture(target);
  }
}

void open_window(const ViewArguments& arguments, const view::Look& look) {
  OpenOptions options;
  options.background = true;
  options.limits = machine_limits();
  const auto dataset = Dataset::open(arguments.input, options);
  const view::Settings settings = settings_of(arguments, dataset->info());
  if (!view::has_display()) {
    throw Error(ErrorCode::kIo,
                "there is no display to open a window on; with --screenshot OUT.png a picture is made without one");
  }
  view::Viewer(dataset, std::filesystem::path(arguments.input).filename(), settings, look, true).interact();
}

void run(const ViewArguments& arguments) {
  const view::Look look = look_of(arguments);
  if (arguments.show) (void)parse_show(*arguments.show); // before the file is opened
  if (arguments.screenshot)
    make_picture(arguments, look);
  else
    open_window(arguments, look);
}

} // namespace
} // namespace ptet::cli

int main(int argc, char** argv) {
  using namespace ptet::cli;
  std::signal(SIGXFSZ, SIG_IGN); // a full limit is an error of writing
  CLI::App command("", "ptet view");
  ViewArguments arguments;
  add_view_options(command, arguments);
  try {
    command.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return command.exit(error) == 0 ? kExitOk : kExitUsage;
  }
  return guarded([&] {
    about_file(arguments.input, [&] { run(arguments); });
    return kExitOk;
  });
}
