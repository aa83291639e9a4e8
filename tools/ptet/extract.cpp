// ptet extract: one mesh out of a .ptet file, and an honest account of what was asked and what was achieved.
#include "arguments.hpp"
#include "blocks.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "formats/ptet/reader.hpp"
#include "formats/surface/write.hpp"
#include "formats/vtk/write.hpp"
#include "ptet/dataset.hpp"

#include <algorithm>
#include <array>
#include <iostream>
#include <memory>
#include <optional>

namespace ptet::cli {
namespace {

struct Arguments {
  std::string input;
  std::optional<std::string> output;
  std::vector<std::string> field_error;
  std::optional<std::string> domain_error;
  std::optional<std::string> tets;
  std::optional<std::string> vertices;
  std::vector<std::string> focus;
  std::optional<std::string> focus_error;
  bool errors = false;
  bool json = false;
};

/// What the options say by themselves, before the file is known.
struct Wishes {
  std::vector<FieldBound> field_error;
  std::optional<Bound> domain_error;
  std::optional<Count> tets, vertices;
  std::vector<FocusRegion> focus;
  Bound focus_error{0, true};
};

enum class OutputKind { kNone, kVolume, kSurface };

OutputKind kind_of(const std::optional<std::string>& path) {
  if (!path) return OutputKind::kNone;
  const std::string ending = ending_of(*path);
  if (ending == ".vtu" || ending == ".vtk") return OutputKind::kVolume;
  static constexpr std::array kSurfaces = {".obj", ".ply", ".stl", ".off"};
  if (std::find(kSurfaces.begin(), kSurfaces.end(), ending) != kSurfaces.end()) return OutputKind::kSurface;
  throw Error(ErrorCode::kBadArgument, "-o '" + *path +
                                           "': the ending must be .vtu or .vtk (the volume), or .obj, .ply, "
                                           ".stl or .off (its boundary surface)");
}

Wishes parse(const Arguments& arguments) {
  Wishes wishes;
  wishes.field_error = parse_field_bounds("--field-error", arguments.field_error);
  if (arguments.domain_error) wishes.domain_error = parse_bound("--domain-error", *arguments.domain_error);
  if (arguments.tets) wishes.tets = parse_count("--tets", *arguments.tets);
  if (arguments.vertices) wishes.vertices = parse_count("--vertices", *arguments.vertices);
  for (const std::string& text : arguments.focus)
    wishes.focus.push_back(parse_focus("--focus", text));
  if (arguments.focus_error) {
    if (wishes.focus.empty()) throw Error(ErrorCode::kBadArgument, "--focus-error: there is no --focus to hold it in");
    wishes.focus_error = parse_bound("--focus-error", *arguments.focus_error);
  }
  if (arguments.errors && kind_of(arguments.output) != OutputKind::kVolume) {
    throw Error(ErrorCode::kBadArgument, "--errors: cell arrays need -o with a .vtu or .vtk file");
  }
  return wishes;
}

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

Request request_for(const Wishes& wishes, const DatasetInfo& info, bool with_errors) {
  std::vector<std::string> all, governing;
  for (const FieldInfo& field : info.fields)
    all.push_back(field.name);
  for (const FieldInfo* field : governing_fields(info))
    governing.push_back(field->name);
  Request request;
  request.field_error = resolve_field_bounds("--field-error", wishes.field_error, all, governing);
  request.domain_error = wishes.domain_error;
  if (wishes.tets) request.max_tets = wishes.tets->of(info.tets);
  if (wishes.vertices) request.max_vertices = wishes.vertices->of(info.vertices);
  request.focus = wishes.focus;
  request.focus_error = wishes.focus_error;
  request.origins = with_errors;
  return request;
}

/// For each governing field the error of each tet: that of the collapse that made it; 0 for an original tet.
std::vector<CellArray> error_arrays(const std::string& path, const Extraction& extraction) {
  file::Reader reader(file::open_file(path));
  file::Content content = reader.read_base();
  const std::vector<file::BlockInfo>& blocks = reader.blocks();
  std::vector<std::uint32_t> wanted;
  for (const RecordId record : extraction.made_by) {
    if (record.is_none()) continue;
    const std::uint32_t block = block_of(blocks, record);
    if (wanted.empty() || wanted.back() != block) wanted.push_back(block);
  }
  reader.load(with_needs(blocks, std::move(wanted)), content);

  std::vector<CellArray> arrays;
  for (const file::ArrayInfo& array : reader.header().arrays) {
    if (!array.governing) continue;
    const std::size_t column = arrays.size();
    std::vector<double> errors(extraction.made_by.size(), 0);
    for (std::size_t t = 0; t < errors.size(); ++t) {
      const RecordId record = extraction.made_by[t];
      if (record.is_none()) continue;
      const std::size_t row = std::size_t{record.index()} * content.errors_per_record;
      errors[t] = decode_error(content.own[row + column], array.range);
    }
    arrays.push_back({"error of " + array.name, std::move(errors)});
  }
  return arrays;
}

std::string to_text(const FocusRegion& region) {
  if (const Box* const box = std::get_if<Box>(&region)) {
    return "box " + cli::to_text(box->min) + " to " + cli::to_text(box->max);
  }
  const Sphere& sphere = std::get<Sphere>(region);
  return "sphere around " + cli::to_text(sphere.centre) + ", radius " + brief(sphere.radius, 6);
}

Json to_json(const FocusRegion& region) {
  if (const Box* const box = std::get_if<Box>(&region)) return {{"box", {{"min", box->min}, {"max", box->max}}}};
  const Sphere& sphere = std::get<Sphere>(region);
  return {{"sphere", {{"centre", sphere.centre}, {"radius", sphere.radius}}}};
}

/// Everything there is to say after an extraction.
struct Outcome {
  std::string input;
  std::optional<std::string> output;
  DatasetInfo info;
  Request request;
  Extraction extraction;
  double seconds = 0; ///< opening and extraction
  double write_seconds = 0;
};

void print_json(const Outcome& outcome) {
  const auto& [input, output, info, request, extraction, seconds, write_seconds] = outcome;
  Json asked = Json::object();
  for (const FieldBound& bound : request.field_error) {
    asked["field_error"][bound.field] = bound.bound.absolute(field_named(info, bound.field).range);
  }
  if (request.domain_error) asked["domain_error"] = request.domain_error->absolute(info.diagonal);
  if (request.max_tets) asked["tets"] = *request.max_tets;
  if (request.max_vertices) asked["vertices"] = *request.max_vertices;
  if (!request.focus.empty()) {
    for (const FocusRegion& region : request.focus)
      asked["focus"].push_back(to_json(region));
    asked["focus_error"] = Json::object();
    for (const FieldInfo* field : governing_fields(info)) {
      asked["focus_error"][field->name] = request.focus_error.absolute(field->range);
    }
  }
  Json achieved = {{"field_error", Json::object()}, {"domain_error", extraction.domain_error}};
  const auto fields = governing_fields(info);
  for (std::size_t i = 0; i < fields.size(); ++i)
    achieved["field_error"][fields[i]->name] = extraction.field_error[i];
  achieved["rms_error"] = extraction.rms_error.empty() ? Json(nullptr) : Json::object();
  for (std::size_t i = 0; i < extraction.rms_error.size(); ++i)
    achieved["rms_error"][fields[i]->name] = extraction.rms_error[i];

  Json json;
  json["asked"] = asked;
  json["achieved"] = achieved;
  json["vertices"] = extraction.mesh.vertex_count();
  json["tets"] = extraction.mesh.tets.size();
  json["bytes_read"] = extraction.bytes_read;
  json["seconds"] = seconds;
  json["limited_by"] = name_of(extraction.limited_by);
  json["output"] = output ? Json(*output) : Json(nullptr);
  if (output) json["write_seconds"] = write_seconds;
  print(json);
}

/// "0.0123 (1% of its range)"
std::string error_text(double error, double scale, const char* of) {
  const std::string share = percent(error, scale);
  return brief(error) + (share.empty() ? "" : " (" + share + " of " + of + ")");
}

constexpr const char* kOfRange = "its range";
constexpr const char* kOfDiagonal = "the diagonal";

void print_asked(const Request& request, const DatasetInfo& info) {
  const auto line = [](const std::string& text) { std::cout << "  asked     " << text << '\n'; };
  for (const FieldBound& bound : request.field_error) {
    const double range = field_named(info, bound.field).range;
    line(bound.field + " within " + error_text(bound.bound.absolute(range), range, kOfRange));
  }
  if (request.domain_error) {
    line("domain within " + error_text(request.domain_error->absolute(info.diagonal), info.diagonal, kOfDiagonal));
  }
  if (request.max_tets) line("at most " + counted(*request.max_tets, "tet"));
  if (request.max_vertices) line("at most " + counted(*request.max_vertices, "vertex"));
  for (const FocusRegion& region : request.focus) {
    const Bound& bound = request.focus_error;
    const std::string size = brief(bound.relative ? 100 * bound.value : bound.value) + (bound.relative ? "%" : "");
    line((bound.value == 0 ? "the original" : "error within " + size) + " in the focus, " + to_text(region));
  }
  if (request.field_error.empty() && !request.domain_error && !request.max_tets && !request.max_vertices &&
      request.focus.empty()) {
    line("the original");
  }
}

const char* explain(const Request& request, const Extraction& extraction) {
  switch (extraction.limited_by) {
  case LimitedBy::kNothing: return "nothing: this is the original mesh";
  case LimitedBy::kError: return "error: what was asked is reached";
  case LimitedBy::kFocus: return "focus: nothing is asked outside it";
  case LimitedBy::kBudget:
    if (extraction.mesh.tets.size() <= request.max_tets.value_or(extraction.mesh.tets.size()) &&
        extraction.mesh.vertex_count() <= request.max_vertices.value_or(extraction.mesh.vertex_count()))
      return "budget: the next split does not fit";
    return request.focus.empty() ? "budget: it is less than the base mesh, and that is the least there is"
                                 : "budget: the focus alone takes more, and is restored all the same";
  case LimitedBy::kTime: return "time: what was asked takes longer";
  }
  return "";
}

void print_text(const Outcome& outcome) {
  const auto& [input, output, info, request, extraction, seconds, write_seconds] = outcome;
  const auto share = [](std::uint64_t part, std::uint64_t whole) {
    return percent(static_cast<double>(part), static_cast<double>(whole));
  };
  std::ostream& out = std::cout;
  out << input << '\n';
  print_asked(request, info);
  const auto fields = governing_fields(info);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    out << "  achieved  " << fields[i]->name << " within "
        << error_text(extraction.field_error[i], fields[i]->range, kOfRange);
    if (!extraction.rms_error.empty()) {
      const std::string share_of_range = percent(extraction.rms_error[i], fields[i]->range);
      out << ", RMS " << brief(extraction.rms_error[i]) << (share_of_range.empty() ? "" : " (" + share_of_range + ")");
    }
    out << '\n';
  }
  out << "  achieved  domain within " << error_text(extraction.domain_error, info.diagonal, kOfDiagonal) << '\n';
  out << "  mesh      " << counted(extraction.mesh.vertex_count(), "vertex") << " ("
      << share(extraction.mesh.vertex_count(), info.vertices) << " of the original), "
      << counted(extraction.mesh.tets.size(), "tet") << " (" << share(extraction.mesh.tets.size(), info.tets) << ")\n";
  out << "  limited   by " << explain(request, extraction) << '\n';
  out << "  time      " << brief(seconds, 3) << " s, " << counted(extraction.bytes_read, "byte") << " read of "
      << grouped(info.file_bytes) << '\n';
  if (output) out << "  written   " << *output << " in " << brief(write_seconds, 3) << " s\n";
}

void run(const Arguments& arguments) {
  const Wishes wishes = parse(arguments);
  const OutputKind kind = kind_of(arguments.output);
  Outcome outcome;
  outcome.input = arguments.input;
  outcome.output = arguments.output;
  const std::string target = arguments.output ? checked_output(*arguments.output, arguments.input) : std::string{};

  ProgressLine progress;
  const auto begin = Clock::now();
  const auto dataset = Dataset::open(arguments.input);
  outcome.info = dataset->info();
  outcome.request = request_for(wishes, outcome.info, arguments.errors);
  outcome.extraction = dataset->extract(outcome.request, progress.callback());
  outcome.seconds = seconds_since(begin);

  const auto write_begin = Clock::now();
  if (kind != OutputKind::kNone) progress.stage("writing");
  if (kind == OutputKind::kVolume) {
    WriteOptions options;
    if (arguments.errors) options.cell_arrays = error_arrays(arguments.input, outcome.extraction);
    write_mesh(target, outcome.extraction.mesh, options, progress.callback());
  } else if (kind == OutputKind::kSurface) {
    write_surface(target, outcome.extraction.mesh, outcome.extraction.boundary_faces);
  }
  outcome.write_seconds = seconds_since(write_begin);
  progress.erase();

  if (arguments.json) {
    print_json(outcome);
  } else {
    print_text(outcome);
  }
}

constexpr const char* kExamples = R"(Examples:
  ptet extract fire.ptet --field-error 1% -o coarse.vtu
  ptet extract fire.ptet --field-error u=2%,v=0.01 --domain-error 0.5% --errors -o mixed.vtu
  ptet extract fire.ptet --vertices 5% --focus box:0,0,0,100,100,50 -o detail.vtu
  ptet extract fire.ptet --focus sphere:10,20,5,8 --focus-error 0.5% -o near.vtu
  ptet extract fire.ptet --tets 20000 -o skin.stl
  ptet extract fire.ptet --field-error 0.1% --json

With no bound, budget or focus the mesh is the original. X% of a field error is of the field's range, X% of a domain
error of the bounding-box diagonal; a plain X is in the units of the field or of the mesh. Bounds and budgets may be
combined: refining stops at the first that is reached, and the report says which.

--json prints {"asked", "achieved": {"field_error": {NAME: x}, "domain_error", "rms_error": {NAME: x} | null},
"vertices", "tets", "bytes_read", "seconds", "limited_by": "error" | "budget" | "focus" | "nothing", "output"}: errors
absolute, seconds for opening and extraction ("write_seconds" for the writing). The RMS error is that over the
domain of the original where the mesh covers it; a build that did not measure it leaves none.
)";

} // namespace

void add_extract(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("extract", "Get one mesh out of a .ptet file, by error, size or focus");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("FILE", arguments->input, "the .ptet file")->required()->option_text(" ");
  command
      ->add_option("-o,--output", arguments->output,
                   "the mesh as .vtu or .vtk, or its boundary surface as\n"
                   ".obj, .ply, .stl or .off; without it only the report")
      ->option_text("OUT");
  command
      ->add_option("--field-error", arguments->field_error,
                   "largest field error: X or X% for every field, NAME=X\n"
                   "or NAME=X% for one; repeatable, or with commas. By name\ngoes before for every field")
      ->allow_extra_args(false)
      ->option_text("X|NAME=X,...");
  command->add_option("--domain-error", arguments->domain_error, "largest domain error")->option_text("X|X%");
  command->add_option("--tets", arguments->tets, "at most so many tets: the smallest error that fits")
      ->option_text("N|N%");
  command->add_option("--vertices", arguments->vertices, "at most so many vertices")->option_text("N|N%");
  command
      ->add_option("--focus", arguments->focus,
                   "box:x0,y0,z0,x1,y1,z1 or sphere:x,y,z,r: the original\ninside, repeatable; outside as coarse as "
                   "the rest allows")
      ->allow_extra_args(false)
      ->option_text("REGION");
  command->add_option("--focus-error", arguments->focus_error, "largest error inside the focus (0: the original)")
      ->option_text("X|X%");
  command->add_flag(
      "--errors", arguments->errors,
      "add for each field a cell array with the error of each\ntet (.vtu and .vtk); reads all of the file");
  command->add_flag("--json", arguments->json, "the report as one JSON object");
  command->footer(kExamples);
  command->callback([arguments] { about_file(arguments->input, [&] { run(*arguments); }); });
}

} // namespace ptet::cli
