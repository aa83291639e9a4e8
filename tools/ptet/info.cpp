// ptet info: what a mesh is and what a build would make of it, or what a .ptet file holds.
#include "arguments.hpp"
#include "build/threads.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "formats/file_names.hpp"
#include "formats/vtk/read.hpp"
#include "mesh/examination.hpp"
#include "plain_output.hpp"
#include "ptet/dataset.hpp"
#include "ptet/validate.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

namespace ptet::cli {
namespace {

struct Arguments {
  std::string input;
  bool levels = false;
  bool json = false;
};

const char* name_of(Severity severity) {
  switch (severity) {
  case Severity::kNote: return "note";
  case Severity::kWarning: return "warning";
  case Severity::kError: return "error";
  }
  return "";
}

/// "float32", "float64 x 3"
std::string type_text(ScalarType type, std::uint32_t components) {
  return std::string(ptet::name_of(type)) + (components == 1 ? "" : " x " + std::to_string(components));
}

// Meshes.

/// Empty where a build takes the mesh, whatever fields it has to be told of.
std::string why_not_buildable(const MeshReport& report) {
  if (report.first_error() != nullptr) return "see the errors above";
  const bool none_can = std::none_of(report.fields.begin(), report.fields.end(),
                                     [](const FieldSummary& field) { return field.can_govern; });
  return none_can && !report.fields.empty() ? "there is no field whose errors can be measured" : "";
}

/// What a build that is told of no field refuses.
std::string if_others_govern(const MeshReport& report) {
  std::string names;
  for (const FieldSummary& field : report.fields)
    if (field.governs_by_default && !field.can_govern)
      names += (names.empty() ? "'" : ", '") + on_one_line(field.name) + "'";
  return names.empty() ? "" : ", if --field names others than " + names;
}

void print_json(const std::string& path, const ReadReport& read, const TetMesh& mesh, const MeshReport& report) {
  Json fields = Json::array();
  for (const FieldSummary& field : report.fields) {
    fields.push_back({{"name", field.name},
                      {"type", ptet::name_of(field.type)},
                      {"components", field.components},
                      {"min", field.min},
                      {"max", field.max},
                      {"not_finite", field.not_finite},
                      {"governs_by_default", field.governs_by_default},
                      {"can_govern", field.can_govern}});
  }
  Json findings = Json::array();
  for (const Finding& finding : report.findings) {
    findings.push_back({{"code", finding.code},
                        {"severity", name_of(finding.severity)},
                        {"count", finding.count},
                        {"message", finding.message},
                        {"first_ids", finding.first_ids}});
  }
  Json json;
  json["kind"] = "mesh";
  json["path"] = path;
  json["format"] = read.format;
  json["file_bytes"] = bytes_of(path, read);
  json["notes"] = read.notes;
  json["vertices"] = report.vertices;
  json["tets"] = report.tets;
  json["position_type"] = ptet::name_of(mesh.positions.type);
  json["boundary_faces"] = report.boundary_faces;
  json["boundary_vertices"] = report.boundary_vertices;
  json["components"] = report.components;
  json["boundary_components"] = report.boundary_components;
  json["euler_characteristic"] = report.euler_characteristic;
  json["boundary_euler_characteristic"] = report.boundary_euler_characteristic;
  json["volume"] = report.volume;
  json["boundary_area"] = report.boundary_area;
  json["box"] = {{"min", report.box_min}, {"max", report.box_max}};
  json["diagonal"] = report.diagonal();
  json["fields"] = fields;
  json["findings"] = findings;
  json["buildable"] = why_not_buildable(report).empty();
  print(json);
}

void print_text(const std::string& path, const ReadReport& read, const TetMesh& mesh, const MeshReport& report) {
  std::ostream& out = std::cout;
  out << path << ": " << read.format << ", " << counted(bytes_of(path, read), "byte") << '\n';
  out << "  mesh      " << counted(report.vertices, "vertex") << " (" << type_text(mesh.positions.type, 1) << "), "
      << counted(report.tets, "tet") << ", " << counted(report.components, "component") << ", Euler characteristic "
      << report.euler_characteristic << '\n';
  out << "  boundary  " << counted(report.boundary_vertices, "vertex") << ", " << counted(report.boundary_faces, "face")
      << ", " << counted(report.boundary_components, "component") << ", Euler characteristic "
      << report.boundary_euler_characteristic << '\n';
  out << "  box       " << placed(report.box_min, report.diagonal()) << " to "
      << placed(report.box_max, report.diagonal()) << ", diagonal " << brief(report.diagonal(), 6) << '\n';
  out << "  volume    " << brief(report.volume, 6) << ", boundary area " << brief(report.boundary_area, 6) << '\n';
  for (const FieldSummary& field : report.fields) {
    out << "  field     " << on_one_line(field.name) << ": " << type_text(field.type, field.components);
    if (!std::isnan(field.min))
      out << (field.components == 1 ? ", from " : ", length from ") << placed(field.min, field.max - field.min)
          << " to " << placed(field.max, field.max - field.min);
    if (field.not_finite > 0) out << ", not finite at " << counted(field.not_finite, "vertex");
    out << '\n';
  }
  for (const std::string& note : read.notes)
    out << "  note      " << on_one_line(note) << '\n';
  for (const Finding& finding : report.findings) {
    std::string label = name_of(finding.severity);
    label.resize(10, ' ');
    out << "  " << label << on_one_line(finding.message) << '\n';
  }
  const std::string why_not = why_not_buildable(report);
  out << "  verdict   "
      << (why_not.empty() ? "can be built from" + if_others_govern(report) : "cannot be built from: " + why_not)
      << '\n';
}

void run_mesh(const Arguments& arguments) {
  if (arguments.levels) {
    throw Error(ErrorCode::kBadArgument, "--levels: '" + arguments.input + "' is not a .ptet file, it has one level");
  }
  ProgressLine progress;
  progress.stage("reading");
  ReadReport read;
  const TetMesh mesh = read_mesh(arguments.input, &read, progress.callback());
  note_values_of_cells(mesh, read);
  progress.stage("examining");
  const MeshReport report = report_on(mesh, build::Threads(0).run([&] { return examine(mesh, progress.callback()); }));
  progress.erase();
  arguments.json ? print_json(arguments.input, read, mesh, report) : print_text(arguments.input, read, mesh, report);
}

// .ptet files.

/// What a cut with every field error and the domain error within `fraction` of their scales has.
struct Level {
  double fraction = 0;
  std::uint64_t vertices = 0;
  std::uint64_t tets = 0;
};

Extraction extract_all_of(const Dataset& dataset, const Request& request) {
  Extraction extraction = dataset.extract(request);
  if (extraction.complete) return extraction;
  const std::string what = "--levels needs all of the file: ";
  if (extraction.failures.empty())
    throw Error(ErrorCode::kLimit, what + "in memory it takes " + counted(dataset.info().memory_for_all, "byte"));
  const BlockFailure& first = extraction.failures.front();
  throw Error(first.code, what + "block " + std::to_string(first.block) + " failed, " + first.message);
}

std::vector<Level> levels_of(const Dataset& dataset) {
  std::vector<Level> levels;
  for (const double fraction : {0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001, 0.0}) {
    Request request;
    if (!dataset.info().max_field_error.empty()) request.field_error.push_back({"", {fraction, true}});
    request.domain_error = Bound{fraction, true};
    const TetMesh mesh = extract_all_of(dataset, request).mesh;
    levels.push_back({fraction, mesh.vertex_count(), mesh.tets.size()});
  }
  return levels;
}

void print_json(const std::string& path, const DatasetInfo& info, const std::vector<Level>& levels) {
  Json fields = Json::array();
  std::size_t column = 0;
  for (const FieldInfo& field : info.fields) {
    Json row = {{"name", field.name},
                {"type", ptet::name_of(field.type)},
                {"components", field.components},
                {"governing", field.governing}};
    if (field.governing) {
      row["range"] = field.range;
      row["max_error"] = info.max_field_error[column];
      if (!info.base_rms_error.empty()) row["base_rms_error"] = info.base_rms_error[column];
      ++column;
    }
    fields.push_back(row);
  }
  Json json;
  json["kind"] = "ptet";
  json["path"] = path;
  json["file_bytes"] = info.file_bytes;
  json["memory_for_all"] = info.memory_for_all;
  json["vertices"] = info.vertices;
  json["tets"] = info.tets;
  json["position_type"] = ptet::name_of(info.position_type);
  json["base"] = {{"vertices", info.base_vertices}, {"tets", info.base_tets}};
  json["records"] = info.records;
  json["blocks"] = info.blocks;
  json["box"] = {{"min", info.box_min}, {"max", info.box_max}};
  json["diagonal"] = info.diagonal;
  json["has_input_order"] = info.has_input_order;
  json["errors_are_bounds"] = info.errors_are_bounds;
  json["overlaps_itself"] = info.overlaps_itself;
  json["fields"] = fields;
  json["max_domain_error"] = info.max_domain_error;
  if (info.base_covered) json["base_covered"] = *info.base_covered;
  json["manifest"] = Json::parse(info.provenance_json);
  for (const Level& level : levels) {
    json["levels"].push_back({{"error", level.fraction}, {"vertices", level.vertices}, {"tets", level.tets}});
  }
  print(json);
}

/// A text, or the texts of a list with commas between.
std::string plain(const Json& value) {
  if (value.is_string()) return on_one_line(value.get<std::string>());
  if (!value.is_array()) return value.dump();
  std::string all;
  for (const Json& entry : value)
    all += (all.empty() ? "" : ", ") + plain(entry);
  return all;
}

void print_manifest(const Json& manifest, std::ostream& out) {
  for (const auto& [key, value] : manifest.items()) {
    if (value.is_structured()) {
      for (const auto& [name, entry] : value.items()) {
        out << "  " << key << "  " << (value.is_object() ? on_one_line(name) + ": " : "") << plain(entry) << '\n';
      }
    } else {
      out << "  " << key << "  " << plain(value) << '\n';
    }
  }
}

void print_text(const std::string& path, const DatasetInfo& info, const std::vector<Level>& levels) {
  std::ostream& out = std::cout;
  out << path << ": .ptet, " << counted(info.file_bytes, "byte") << ", "
      << brief(static_cast<double>(info.file_bytes) / static_cast<double>(std::max<std::uint64_t>(1, info.vertices)), 3)
      << " a vertex\n";
  out << "  original  " << counted(info.vertices, "vertex") << " (" << type_text(info.position_type, 1) << "), "
      << counted(info.tets, "tet") << '\n';
  out << "  base      " << counted(info.base_vertices, "vertex") << ", " << counted(info.base_tets, "tet") << '\n';
  out << "  records   " << grouped(info.records) << " in " << counted(info.blocks, "block") << '\n';
  out << "  memory    up to " << counted(info.memory_for_all, "byte") << " where all of it is loaded\n";
  out << "  box       " << placed(info.box_min, info.diagonal) << " to " << placed(info.box_max, info.diagonal)
      << ", diagonal " << brief(info.diagonal, 6) << '\n';
  std::size_t column = 0;
  for (const FieldInfo& field : info.fields) {
    out << "  field     " << on_one_line(field.name) << ": " << type_text(field.type, field.components);
    if (field.governing) {
      const double error = info.max_field_error[column];
      out << (field.range > 0 ? ", range " + brief(field.range, 6) : ", constant") << ", error up to "
          << brief_up(error);
      if (field.range > 0) out << " (" << percent_up(error, field.range) << ")";
      if (!info.base_rms_error.empty()) {
        out << ", RMS of the base " << brief_up(info.base_rms_error[column]);
        if (field.range > 0) out << " (" << percent_up(info.base_rms_error[column], field.range) << ")";
      }
      ++column;
    } else {
      out << ", carried along";
    }
    out << '\n';
  }
  out << "  domain    error up to " << brief_up(info.max_domain_error);
  if (info.diagonal > 0) out << " (" << percent_up(info.max_domain_error, info.diagonal) << " of the diagonal)";
  if (info.base_covered && *info.base_covered < 1)
    out << ", up to " << percent_up(1 - *info.base_covered, 1) << " of the volume uncovered by the base";
  out << '\n';
  if (!info.errors_are_bounds) out << "  note      " << kNoBounds << '\n';
  if (info.overlaps_itself) out << "  note      " << kOverlaps << '\n';
  print_manifest(Json::parse(info.provenance_json), out);
  for (const Level& level : levels) {
    std::string label = brief(100 * level.fraction) + "%";
    label.resize(10, ' ');
    out << "  level     " << label << counted(level.vertices, "vertex") << ", " << counted(level.tets, "tet") << '\n';
  }
}

void run_ptet(const Arguments& arguments) {
  let_interrupts_end();
  const auto dataset = open_dataset(arguments.input);
  const DatasetInfo info = dataset->info();
  const std::vector<Level> levels = arguments.levels ? levels_of(*dataset) : std::vector<Level>{};
  arguments.json ? print_json(arguments.input, info, levels) : print_text(arguments.input, info, levels);
}

constexpr const char* kExamples = R"(Examples:
  ptet info fire.vtu
  ptet info fire.vtu --json
  ptet info fire.ptet --levels

For a mesh: counts, topology, fields, and every finding with the ids of the first few cells or points: notes and
warnings are handled by a build and said, errors stop it. The exit code is 0 when the mesh could be read, whatever was
found in it. For a .ptet file (told by its contents or its name): what it holds, how large the errors of its levels
are, and where it comes from.
)";

} // namespace

void add_info(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("info", "Examine a mesh, or say what a .ptet file holds");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("FILE", arguments->input, "a mesh (.vtu, .pvtu, .vtk, Exodus) or a .ptet file")
      ->required()
      ->option_text(" ");
  command->add_flag("--levels", arguments->levels,
                    "size of the mesh with every error within 10%, ... 0%\n(reads all of the .ptet file)");
  command->add_flag("--json", arguments->json, "the report as one JSON object");
  command->footer(kExamples);
  command->callback([arguments] {
    const bool ptet = is_ptet_file(arguments->input) || ending_of(arguments->input) == ".ptet";
    about_file(arguments->input, [&] { ptet ? run_ptet(*arguments) : run_mesh(*arguments); });
  });
}

} // namespace ptet::cli
