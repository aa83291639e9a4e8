#include "caption.hpp"

#include "lod/region.hpp"
#include "mesh/number_text.hpp"
#include "number.hpp"
#include "tools/brief_up.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace ptet::view {

namespace {

std::string percent(double part, double whole) {
  return brief(whole > 0 ? 100 * part / whole : 0) + "%";
}

/// Of a bound: rounded up.
std::string percent_up(double part, double whole) {
  return brief_up(whole > 0 ? 100 * part / whole : 0, 3) + "%";
}

std::string milliseconds(double ms) {
  std::array<char, 32> text{};
  (void)std::snprintf(text.data(), text.size(), "%.1f ms", ms);
  return text.data();
}

std::string asked(const Settings& settings) {
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (settings.error) add(*settings.error == 0 ? "the original" : "error " + name_of_error(settings.error));
  if (settings.max_tets) add("at most " + grouped(*settings.max_tets) + " tets");
  if (settings.max_vertices) add("at most " + grouped(*settings.max_vertices) + " vertices");
  if (settings.focus) add("the original in the focus");
  return text.empty() ? "nothing" : text;
}

/// The colour's field if its errors are known, else the worst of all.
std::string achieved(const DatasetInfo& info, const Settings& settings, const Frame& frame) {
  std::string name;
  double worst = -1;
  std::size_t row = 0;
  for (std::size_t f = 0; f < info.fields.size(); ++f) {
    const FieldInfo& field = info.fields[f];
    if (!field.governing || row >= frame.field_error.size()) continue;
    const double error = frame.field_error[row++];
    const double fraction = field.range > 0 ? error / field.range : 0;
    const bool is_colour = settings.colour.kind == ColourKind::kField && settings.colour.field == f;
    if (!is_colour && fraction <= worst) continue;
    worst = fraction;
    name = field.name;
    if (is_colour) break;
  }
  const std::string boundary = "boundary " + percent_up(frame.domain_error, info.diagonal) + " of the diagonal" +
                               (info.errors_are_bounds ? "" : "\n(seen in the build, no bounds)");
  return name.empty() ? boundary : name + " " + percent_up(worst, 1) + " of its range,\n" + boundary;
}

} // namespace

const char* name_of(Show show) {
  switch (show) {
  case Show::kSurface: return "boundary surface";
  case Show::kCells: return "cells cut open";
  case Show::kSlice: return "slice";
  case Show::kIsosurface: return "isosurface";
  case Show::kVolume: return "volume";
  }
  return "";
}

std::string name_of(const ColourBy& colour, const DatasetInfo& info) {
  switch (colour.kind) {
  case ColourKind::kField: return colour.field < info.fields.size() ? info.fields[colour.field].name : "";
  case ColourKind::kError: return "error, % of the range";
  case ColourKind::kLevel: return "level (0: original)";
  }
  return "";
}

std::string name_of(const Plane& plane, const DatasetInfo& info) {
  const std::optional<std::size_t> axis = plane.axis();
  if (!axis) return "";
  return std::string(1, "xyz"[*axis]) + " = " + brief_within(info.box_max[*axis] - info.box_min[*axis], plane.place());
}

std::string name_of_error(const std::optional<double>& error) {
  if (!error) return "none";
  return *error == 0 ? "0" : percent(*error, 1);
}

std::string caption(const std::string& file, const DatasetInfo& info, const Settings& settings, const Frame& frame) {
  std::string text = file + ": " + name_of(settings.show);
  if (settings.show == Show::kIsosurface && settings.isovalue && settings.iso_field < info.fields.size())
    text += " of " + info.fields[settings.iso_field].name + " at " +
            brief_within(info.fields[settings.iso_field].range, *settings.isovalue);
  const bool has_plane = settings.show == Show::kSlice || settings.show == Show::kCells;
  if (has_plane && settings.plane.axis()) text += " at " + name_of(settings.plane, info);
  text += "\nasked: " + asked(settings);
  text += "\nachieved: " + achieved(info, settings, frame);
  text += "\n" + grouped(frame.tets) + " of " + grouped(info.tets) + " tets (" +
          percent(static_cast<double>(frame.tets), static_cast<double>(info.tets)) + ")\n" +
          milliseconds(frame.cut_ms) + (frame.has_read ? " for the cut and reading, " : " for the cut, ") +
          milliseconds(frame.geometry_ms) + " for what is drawn";
  if (settings.focus && !meets(*settings.focus, info.box_min, info.box_max)) text += "\nthe focus is beside the mesh";
  if (!frame.is_complete) text += frame.limited_by == LimitedBy::kLoading ? "\nloading ..." : "\nrefining ...";
  if (!frame.failure.empty()) text += "\ncoarser where the file is damaged: " + frame.failure;
  return text;
}

} // namespace ptet::view
