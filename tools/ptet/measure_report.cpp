#include "measure_report.hpp"

#include "console.hpp"
#include "plain_output.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

namespace ptet::cli {
namespace {

/// What is wrong with a mesh as such, in the order of the report.
struct Defect {
  const char* key;
  const char* text;
  std::optional<std::uint64_t> count; ///< nothing: it could not be looked for
};
std::vector<Defect> defects_of(const MeasuredMesh& side) {
  const auto count = [&](const char* code) { return count_of(side.report, code); };
  std::optional<std::uint64_t> overlapping;
  if (side.report.overlaps_examined) overlapping = count("overlapping-tets");
  return {{"inverted_tets", "inverted tets", count("inverted-tets")},
          {"flat_tets", "flat tets", count("flat-tets")},
          {"tets_with_repeated_vertices", "tets with a vertex twice", count("repeated-vertices")},
          {"duplicate_tets", "duplicate tets", count("duplicate-tets")},
          {"non_manifold_faces", "faces of more than two tets", count("faces-of-many-tets")},
          {"folded_faces", "faces with both tets on one side", count("folded-faces")},
          {"non_manifold_edges", "non-manifold boundary edges", count("non-manifold-edges")},
          {"non_manifold_vertices", "non-manifold vertices", count("non-manifold-vertices")},
          {"boundary_self_intersections", "pairs of boundary faces that intersect", side.boundary_intersections},
          {"overlapping_tets", "tets at the boundary that others reach into", overlapping}};
}

bool is_valid(const MeasuredMesh& side) {
  const std::vector<Defect> defects = defects_of(side);
  return std::all_of(defects.begin(), defects.end(),
                     [](const Defect& defect) { return defect.count.value_or(0) == 0; });
}

Json to_json(const MeasuredMesh& side) {
  const MeshReport& report = side.report;
  Json json = {{"path", side.path}, {"vertices", report.vertices}, {"tets", report.tets}, {"volume", side.volume}};
  Json& validity = json["validity"];
  validity["valid"] = is_valid(side);
  for (const Defect& defect : defects_of(side))
    validity[defect.key] = defect.count ? Json(*defect.count) : Json(nullptr);
  validity["components"] = report.components;
  validity["boundary_components"] = report.boundary_components;
  validity["euler_characteristic"] = report.euler_characteristic;
  validity["boundary_euler_characteristic"] = report.boundary_euler_characteristic;
  return json;
}

Json percent_json(double part, double whole) {
  const std::optional<double> share = percentage(part, whole);
  return share ? Json(*share) : Json(nullptr);
}

Json to_json(const FieldDifference& difference, double range, bool has_mean = true) {
  const double rms = difference.rms();
  return {{"max", difference.max},
          {"max_percent", percent_json(difference.max, range)},
          {"max_at", difference.max > 0 ? Json(difference.at) : Json(nullptr)},
          {"rms", has_mean ? Json(rms) : Json(nullptr)},
          {"rms_percent", has_mean ? percent_json(rms, range) : Json(nullptr)}};
}

Json to_json(const DistanceBounds& bounds, double diagonal) {
  return {{"lower", bounds.lower},
          {"upper", bounds.upper},
          {"lower_percent", percent_json(bounds.lower, diagonal)},
          {"upper_percent", percent_json(bounds.upper, diagonal)}};
}

DistanceBounds both_ways(const MeasureOutcome& outcome) {
  return {std::max(outcome.there.lower, outcome.back.lower), std::max(outcome.there.upper, outcome.back.upper)};
}

std::string with_percent(double value, double whole) {
  const std::string share = percent(value, whole);
  return brief(value) + (share.empty() ? "" : " (" + share + ")");
}

void print_side(const char* label, const MeasuredMesh& side) {
  const MeshReport& report = side.report;
  std::cout << label << side.path << ": " << counted(report.vertices, "vertex") << ", " << counted(report.tets, "tet")
            << ", volume " << brief(side.volume, 6) << ", " << counted(report.components, "component")
            << ", Euler characteristic " << report.euler_characteristic << '\n';
}

void print_validity(const MeasureOutcome& outcome) {
  const std::vector<Defect> before = defects_of(outcome.original), after = defects_of(outcome.simplified);
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i].count == 0u) continue;
    std::cout << "  defect      " << after[i].text << ": ";
    if (after[i].count)
      std::cout << grouped(*after[i].count);
    else
      std::cout << "not looked for, as the other defects leave no boundary that tells inside from outside";
    if (before[i].count.value_or(0) > 0) std::cout << " (the original has " << grouped(*before[i].count) << ")";
    std::cout << '\n';
  }
  std::cout << "  validity    "
            << (is_valid(outcome.simplified) ? "the simplified mesh is a manifold of positively oriented tets, and its "
                                               "boundary does not intersect itself"
                                             : "the simplified mesh has defects")
            << '\n';
}

void print_fields(const MeasureOutcome& outcome) {
  const auto line = [&](const char* label, const FieldDifference& difference, double range, bool has_mean) {
    std::cout << label << "maximum " << with_percent(difference.max, range);
    if (difference.max > 0) std::cout << " at " << placed(difference.at, outcome.original.report.diagonal());
    if (has_mean) std::cout << ", RMS " << with_percent(difference.rms(), range);
    std::cout << '\n';
  };
  const OutsideDifference& outside = outcome.outside;
  for (std::size_t f = 0; f < outcome.fields.size(); ++f) {
    const auto& [name, simplified_name, components, range] = outcome.fields[f];
    std::cout << "  field       " << on_one_line(name) << ", range " << brief(range) << '\n';
    line("    inside    ", outcome.inside.fields[f], range, true);
    if (outside.vertices + outside.points > 0) line("    outside   ", outside.fields[f], range, outside.points > 0);
  }
  std::cout << "  inside      "
            << (outcome.samples ? "sampled: " + counted(outcome.inside.points, "point") : std::string("exact")) << '\n';
  std::cout << "  outside     ";
  if (outside.vertices + outside.points == 0) {
    std::cout << "no vertex and no sample of the original\n";
  } else {
    std::cout << "sampled: " << counted(outside.vertices, "vertex") << " and "
              << counted(outside.points, "random point") << " against the closest point\n";
  }
  if (outside.missed > 0)
    std::cout << "              "
              << percent(static_cast<double>(outside.missed), static_cast<double>(outside.points + outside.missed))
              << " of its volume lies in films too thin to be sampled"
              << (outside.points > 0 ? ": the RMS is that of the rest\n" : "\n");
}

} // namespace

std::uint64_t count_of(const MeshReport& report, const char* code) {
  for (const Finding& finding : report.findings)
    if (finding.code == code && finding.severity != Severity::kNote) return finding.count;
  return 0;
}

void print_json(const MeasureOutcome& outcome, const std::optional<std::string>& errors) {
  const double diagonal = outcome.original.report.diagonal();
  Json json;
  json["original"] = to_json(outcome.original);
  json["simplified"] = to_json(outcome.simplified);
  json["overlap"] = {{"volume", outcome.inside.volume}, {"exact", !outcome.samples}};
  json["inside"] = {{"method", outcome.samples ? "sampled" : "exact"}, {"fields", Json::object()}};
  if (outcome.samples) json["inside"]["points"] = outcome.inside.points;
  json["outside"] = {{"method", "sampled"},
                     {"volume", outcome.outside.volume},
                     {"vertices", outcome.outside.vertices},
                     {"points", outcome.outside.points},
                     {"missed_points", outcome.outside.missed},
                     {"fields", Json::object()}};
  json["ranges"] = Json::object();
  for (std::size_t f = 0; f < outcome.fields.size(); ++f) {
    const auto& [name, simplified_name, components, range] = outcome.fields[f];
    json["ranges"][name] = range;
    json["inside"]["fields"][name] = to_json(outcome.inside.fields[f], range);
    if (outcome.outside.vertices + outcome.outside.points > 0)
      json["outside"]["fields"][name] = to_json(outcome.outside.fields[f], range, outcome.outside.points > 0);
  }
  json["hausdorff"] = {{"diagonal", diagonal},
                       {"original_to_simplified", to_json(outcome.there, diagonal)},
                       {"simplified_to_original", to_json(outcome.back, diagonal)},
                       {"symmetric", to_json(both_ways(outcome), diagonal)}};
  json["notes"] = outcome.notes;
  json["seconds"] = outcome.seconds;
  json["errors"] = errors ? Json(*errors) : Json(nullptr);
  print(json);
}

void print_text(const MeasureOutcome& outcome, const std::optional<std::string>& errors) {
  const double diagonal = outcome.original.report.diagonal();
  print_side("original      ", outcome.original);
  print_side("simplified    ", outcome.simplified);
  std::cout << "  overlap     " << brief(outcome.inside.volume, 6) << " ("
            << percent(outcome.inside.volume, outcome.original.volume) << " of the original, "
            << percent(outcome.inside.volume, outcome.simplified.volume) << " of the simplified mesh)\n";
  print_fields(outcome);
  const auto distance = [&](const char* label, const DistanceBounds& bounds) {
    std::cout << "  distance    " << label << with_percent(bounds.lower, diagonal) << " to "
              << with_percent(bounds.upper, diagonal) << '\n';
  };
  distance("original to simplified boundary ", outcome.there);
  distance("simplified to original boundary ", outcome.back);
  print_validity(outcome);
  for (const std::string& note : outcome.notes)
    std::cout << "  note        " << on_one_line(note) << '\n';
  if (errors) std::cout << "  written     " << *errors << '\n';
  std::cout << "  time        " << brief(outcome.seconds, 3) << " s\n";
}

} // namespace ptet::cli
