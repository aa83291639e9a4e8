#include "extract_report.hpp"

#include "console.hpp"
#include "lod/region.hpp"
#include "lod/tet_runs.hpp"
#include "plain_output.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

namespace ptet::cli {
namespace {

std::vector<const FieldInfo*> governing_fields(const DatasetInfo& info) {
  std::vector<const FieldInfo*> fields;
  for (const FieldInfo& field : info.fields) {
    if (field.governing) fields.push_back(&field);
  }
  return fields;
}

const FieldInfo& field_named(const DatasetInfo& info, const std::string& name) {
  return *std::find_if(info.fields.begin(), info.fields.end(),
                       [&](const FieldInfo& field) { return field.name == name; });
}

/// Regions as text and as JSON, by their kind.
struct RegionText {
  std::string operator()(const Box& box) const { return "box " + as_given(box.min) + " to " + as_given(box.max); }
  std::string operator()(const OrientedBox& box) const {
    return "box around " + as_given(box.centre) + ", half axes " + as_given(box.half_axes[0]) + ", " +
           as_given(box.half_axes[1]) + ", " + as_given(box.half_axes[2]);
  }
  std::string operator()(const Sphere& sphere) const {
    return "sphere around " + as_given(sphere.centre) + ", radius " + as_given(sphere.radius);
  }
  std::string operator()(const HalfSpace& half_space) const {
    return "half-space up to " + as_given(half_space.offset) + " along " + as_given(half_space.normal);
  }
};
struct RegionJson {
  Json operator()(const Box& box) const { return {{"box", {{"min", box.min}, {"max", box.max}}}}; }
  Json operator()(const OrientedBox& box) const {
    return {{"oriented_box", {{"centre", box.centre}, {"half_axes", box.half_axes}}}};
  }
  Json operator()(const Sphere& sphere) const {
    return {{"sphere", {{"centre", sphere.centre}, {"radius", sphere.radius}}}};
  }
  Json operator()(const HalfSpace& half_space) const {
    return {{"half_space", {{"normal", half_space.normal}, {"offset", half_space.offset}}}};
  }
};

/// By governing field.
Json by_field(const DatasetInfo& info, const std::vector<double>& errors) {
  Json json = Json::object();
  const auto fields = governing_fields(info);
  for (std::size_t i = 0; i < errors.size(); ++i)
    json[fields[i]->name] = errors[i];
  return json;
}
Json by_field(const DatasetInfo& info, const Bound& bound) {
  Json json = Json::object();
  for (const FieldInfo* field : governing_fields(info))
    json[field->name] = bound.absolute(field->range);
  return json;
}
Json to_json(const PartErrors& errors, const DatasetInfo& info) {
  return {{"field_error", by_field(info, errors.field_error)}, {"domain_error", errors.domain_error}};
}

Json asked_json(const Request& request, const DatasetInfo& info) {
  Json asked = Json::object();
  for (const FieldBound& bound : request.field_error) {
    asked["field_error"][bound.field] = bound.bound.absolute(field_named(info, bound.field).range);
  }
  if (request.domain_error) asked["domain_error"] = request.domain_error->absolute(info.diagonal);
  if (request.input_order) asked["input_order"] = true;
  if (request.max_tets) asked["tets"] = *request.max_tets;
  if (request.max_vertices) asked["vertices"] = *request.max_vertices;
  if (request.max_bytes) asked["bytes"] = *request.max_bytes;
  if (request.max_milliseconds) asked["milliseconds"] = *request.max_milliseconds;
  for (const Focus& focus : request.focus) {
    Json json = std::visit(RegionJson{}, focus.region);
    json["error"] = by_field(info, focus.error);
    json["falloff"] = focus.falloff ? by_field(info, *focus.falloff) : Json(nullptr);
    asked["focus"].push_back(json);
  }
  for (const ValuesOfInterest& values : request.values) // an end that is not there is null
    asked["values"].push_back({{"field", values.field}, {"min", values.min}, {"max", values.max}});
  if (const auto& view = request.view) {
    asked["view"] = {{"eye", view->eye},
                     {"direction", view->direction},
                     {"up", view->up},
                     {"angle", view->vertical_angle * 180 / M_PI},
                     {"size", {view->width, view->height}},
                     {"pixels", view->max_pixels},
                     {"outside", view->outside}};
  }
  return asked;
}

/// How many tets of the mesh meet the region: what the user has named, beside what had to come with it.
std::uint64_t tets_meeting(const Region& region, const TetMesh& mesh) {
  std::uint64_t count = 0;
  for (std::size_t first = 0; first < mesh.tets.size(); first += kRunLength) {
    const TetRun run = run_from(mesh.tets, first);
    const BoundingBox box = box_around(mesh, run);
    if (!meets(region, box.low, box.high)) continue;
    count += static_cast<std::uint64_t>(
        std::count_if(run.begin(), run.end(), [&](const Tet& tet) { return meets(region, corners_of(mesh, tet)); }));
  }
  return count;
}

/// The original has no errors, whatever the build has measured.
bool are_bounds(const DatasetInfo& info, const Extraction& extraction) {
  return info.errors_are_bounds || extraction.limited_by == LimitedBy::kNothing;
}

Json achieved_json(const Extraction& extraction, const Request& request, const DatasetInfo& info) {
  Json achieved = {{"field_error", by_field(info, extraction.field_error)},
                   {"domain_error", extraction.domain_error},
                   {"errors_are_bounds", are_bounds(info, extraction)},
                   {"overlaps_itself", info.overlaps_itself}};
  achieved["rms_error"] = extraction.rms_error.empty() ? Json(nullptr) : by_field(info, extraction.rms_error);
  achieved["covered"] = extraction.covered ? Json(*extraction.covered) : Json(nullptr);
  for (std::size_t i = 0; i < extraction.in_focus.size(); ++i) {
    Json in_focus = to_json(extraction.in_focus[i], info);
    in_focus["tets"] = tets_meeting(request.focus[i].region, extraction.mesh);
    achieved["in_focus"].push_back(std::move(in_focus));
  }
  for (const PartErrors& errors : extraction.at_values)
    achieved["at_values"].push_back(to_json(errors, info));
  if (extraction.in_view) {
    achieved["in_view"] = to_json(*extraction.in_view, info);
    achieved["in_view"]["pixels"] = extraction.pixels_in_view;
  }
  return achieved;
}

std::string with_share(const std::string& number, const std::string& share, const char* of) {
  return number + (share.empty() ? "" : " (" + share + " of " + of + ")");
}
/// "0.0123 (1% of its range)", rounded up.
std::string error_text(double error, double scale, const char* of) {
  return with_share(brief_up(error), percent_up(error, scale), of);
}
/// The same of what was asked, as near as it gets.
std::string asked_text(double bound, double scale, const char* of) {
  return with_share(brief(bound), percent(bound, scale), of);
}

std::string counted_pixels(const std::string& number) {
  return number + (number == "1" ? " pixel" : " pixels");
}

constexpr const char* kOfRange = "its range";
constexpr const char* kOfDiagonal = "the diagonal";

/// What comes before an error that is stated.
const char* within(const DatasetInfo& info, const Extraction& extraction) {
  return are_bounds(info, extraction) ? " within " : " about ";
}

std::string bound_text(const Bound& bound) {
  return brief(bound.relative ? 100 * bound.value : bound.value) + (bound.relative ? "%" : "");
}

std::string values_text(const ValuesOfInterest& values) {
  const std::string field = on_one_line(values.field);
  if (values.min == values.max) return field + " = " + as_given(values.min);
  const bool has_least = std::isfinite(values.min), has_most = std::isfinite(values.max);
  if (!has_least && !has_most) return field + " has any value";
  return (has_least ? as_given(values.min) + " <= " : "") + field + (has_most ? " <= " + as_given(values.max) : "");
}

void print_asked(const Request& request, const DatasetInfo& info) {
  bool is_anything = false;
  const auto line = [&](const std::string& text) {
    std::cout << "  asked     " << text << '\n';
    is_anything = true;
  };
  for (const FieldBound& bound : request.field_error) {
    const double range = field_named(info, bound.field).range;
    line(on_one_line(bound.field) + " within " + asked_text(bound.bound.absolute(range), range, kOfRange));
  }
  if (request.domain_error) {
    line("domain within " + asked_text(request.domain_error->absolute(info.diagonal), info.diagonal, kOfDiagonal));
  }
  if (const auto& view = request.view) {
    line("domain within " + counted_pixels(as_given(view->max_pixels)) + " in the view from " + as_given(view->eye) +
         (std::isfinite(view->outside) ? ", errors " + brief(view->outside) + " times as large outside it"
                                       : ", nothing outside it"));
  }
  for (const ValuesOfInterest& values : request.values) {
    const bool has_bounds = !request.field_error.empty() || request.domain_error || request.view;
    line((has_bounds ? "that only where " : "the original where ") + values_text(values));
  }
  if (request.max_tets) line("at most " + counted(*request.max_tets, "tet"));
  if (request.max_vertices) line("at most " + counted(*request.max_vertices, "vertex"));
  if (request.max_bytes) line("at most " + counted(*request.max_bytes, "byte"));
  if (request.max_milliseconds) line("no longer than " + brief(*request.max_milliseconds) + " ms");
  for (const Focus& focus : request.focus) {
    line((focus.error.value == 0 ? "the original" : "error within " + bound_text(focus.error)) + " in the focus, " +
         std::visit(RegionText{}, focus.region) +
         (focus.falloff ? ", and " + bound_text(*focus.falloff) + " more for each diagonal away from it" : ""));
  }
  if (!is_anything) line("the original");
}

const char* explain(const Request& request, const Extraction& extraction, const DatasetInfo& info,
                    std::uint64_t bytes) {
  switch (extraction.limited_by) {
  case LimitedBy::kNothing: return "nothing: this is the original mesh";
  case LimitedBy::kError: return "error: what was asked is reached";
  case LimitedBy::kFocus:
    return "focus: what it asks is reached, with the tets that it needs around it, and nothing else is asked";
  case LimitedBy::kTime: return "time: it was up";
  case LimitedBy::kLoading: return "loading: more blocks are on their way";
  case LimitedBy::kMemory: return "memory: more blocks do not fit";
  case LimitedBy::kUnreadable: return "unreadable blocks: the rest of what was asked is in them";
  case LimitedBy::kBudget:
    if (extraction.mesh.tets.size() <= request.max_tets.value_or(extraction.mesh.tets.size()) &&
        extraction.mesh.vertex_count() <= request.max_vertices.value_or(extraction.mesh.vertex_count()) &&
        bytes <= request.max_bytes.value_or(bytes))
      return "budget: the next split does not fit";
    return extraction.mesh.tets.size() == info.base_tets
               ? "budget: it is less than the base mesh, and that is the least there is"
               : "budget: the focus alone takes more, and is restored all the same";
  }
  return "";
}

/// The errors where more was asked than elsewhere.
void print_parts(const Extraction& extraction, const Request& request, const DatasetInfo& info) {
  const auto fields = governing_fields(info);
  const auto line = [&](const std::string& where, const PartErrors& errors, const std::string& more) {
    std::cout << "  there     " << where << ": ";
    for (std::size_t i = 0; i < fields.size(); ++i)
      std::cout << on_one_line(fields[i]->name) << within(info, extraction)
                << error_text(errors.field_error[i], fields[i]->range, kOfRange) << ", ";
    std::cout << "domain" << within(info, extraction) << error_text(errors.domain_error, info.diagonal, kOfDiagonal)
              << more << '\n';
  };
  for (std::size_t i = 0; i < extraction.in_focus.size(); ++i)
    line("in the focus, " + std::visit(RegionText{}, request.focus[i].region), extraction.in_focus[i],
         ", " + counted(tets_meeting(request.focus[i].region, extraction.mesh), "tet") + " of the mesh");
  for (std::size_t i = 0; i < extraction.at_values.size(); ++i)
    line("where " + values_text(request.values[i]), extraction.at_values[i], "");
  if (extraction.in_view)
    line("in the view", *extraction.in_view, ", " + counted_pixels(brief_up(extraction.pixels_in_view)));
}

} // namespace

std::uint64_t bytes_of(const Extraction& extraction) {
  std::uint64_t bytes = extraction.mesh.positions.bytes.size() + extraction.mesh.tets.size() * sizeof(Tet) +
                        extraction.boundary_faces.size() * sizeof(std::array<VertexId, 3>);
  for (const PointArray& array : extraction.mesh.point_arrays)
    bytes += array.bytes.size();
  return bytes;
}

void print_json(const ExtractOutcome& outcome) {
  const auto& [input, output, info, request, extraction, bytes, seconds, write_seconds, notes] = outcome;
  Json json;
  json["asked"] = asked_json(request, info);
  json["achieved"] = achieved_json(extraction, request, info);
  json["vertices"] = extraction.mesh.vertex_count();
  json["tets"] = extraction.mesh.tets.size();
  json["bytes"] = bytes;
  json["bytes_read"] = extraction.bytes_read;
  json["seconds"] = seconds;
  json["read_requests"] = extraction.read_requests;
  json["limited_by"] = name_of(extraction.limited_by);
  json["complete"] = extraction.complete;
  json["failures"] = Json::array();
  for (const BlockFailure& failure : extraction.failures)
    json["failures"].push_back(
        {{"block", failure.block}, {"byte_offset", failure.byte_offset}, {"message", failure.message}});
  json["notes"] = notes;
  json["output"] = output ? Json(*output) : Json(nullptr);
  if (output) json["write_seconds"] = write_seconds;
  print(json);
}

void print_text(const ExtractOutcome& outcome) {
  const auto& [input, output, info, request, extraction, bytes, seconds, write_seconds, notes] = outcome;
  const auto share = [](std::uint64_t part, std::uint64_t whole) {
    return percent(static_cast<double>(part), static_cast<double>(whole));
  };
  std::ostream& out = std::cout;
  out << input << '\n';
  print_asked(request, info);
  const auto fields = governing_fields(info);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    out << "  achieved  " << on_one_line(fields[i]->name) << within(info, extraction)
        << error_text(extraction.field_error[i], fields[i]->range, kOfRange);
    if (!extraction.rms_error.empty()) {
      const std::string share_of_range = percent_up(extraction.rms_error[i], fields[i]->range);
      out << ", RMS " << brief_up(extraction.rms_error[i])
          << (share_of_range.empty() ? "" : " (" + share_of_range + ")");
    }
    out << '\n';
  }
  out << "  achieved  domain" << within(info, extraction)
      << error_text(extraction.domain_error, info.diagonal, kOfDiagonal);
  if (extraction.covered && *extraction.covered < 1)
    out << ", up to " << percent_up(1 - *extraction.covered, 1) << " of the volume uncovered";
  out << '\n';
  print_parts(extraction, request, info);
  if (!are_bounds(info, extraction)) out << "  note      " << kNoBounds << '\n';
  out << "  mesh      " << counted(extraction.mesh.vertex_count(), "vertex") << " ("
      << share(extraction.mesh.vertex_count(), info.vertices) << " of the original), "
      << counted(extraction.mesh.tets.size(), "tet") << " (" << share(extraction.mesh.tets.size(), info.tets) << ")\n";
  out << "  limited   by " << explain(request, extraction, info, bytes) << '\n';
  out << "  time      " << brief(seconds, 3) << " s, " << counted(extraction.bytes_read, "byte") << " read of "
      << grouped(info.file_bytes) << '\n';
  for (const std::string& note : notes)
    out << "  note      " << on_one_line(note) << '\n';
  if (output) out << "  written   " << *output << " in " << brief(write_seconds, 3) << " s\n";
}

} // namespace ptet::cli
