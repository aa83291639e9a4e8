// ptet extract: one mesh out of a .ptet file, and an honest account of what was asked and what was achieved.
#include "arguments.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "extract_notes.hpp"
#include "extract_report.hpp"
#include "files.hpp"
#include "formats/surface/write.hpp"
#include "formats/vtk/read.hpp"
#include "formats/vtk/write.hpp"
#include "input_pieces.hpp"
#include "ptet/dataset.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <span>

namespace ptet::cli {
namespace {

struct Arguments {
  std::string input;
  std::optional<std::string> output;
  std::vector<std::string> field_error;
  std::optional<std::string> domain_error;
  std::optional<std::string> tets;
  std::optional<std::string> vertices;
  std::optional<std::string> bytes;
  std::optional<std::string> milliseconds;
  std::optional<std::string> memory_limit;
  std::vector<std::string> focus;
  std::vector<std::string> focus_error;
  std::vector<std::string> focus_falloff;
  std::vector<std::string> isovalue;
  std::vector<std::string> values;
  std::optional<std::string> view;
  std::optional<std::string> pixels;
  std::optional<std::string> outside;
  bool errors = false;
  bool input_order = false;
  bool salvage = false;
  bool json = false;
};

/// What the options say by themselves, before the file is known.
struct Wishes {
  std::vector<FieldBound> field_error;
  std::optional<Bound> domain_error;
  std::optional<Count> tets, vertices;
  std::optional<std::uint64_t> memory_limit;
  Request request; ///< what needs no more of the file than to be checked against it
};

enum class OutputKind { kNone, kVolume, kSurface };

OutputKind kind_of(const std::optional<std::string>& path) {
  if (!path) return OutputKind::kNone;
  if (is_mesh_name(*path)) return OutputKind::kVolume;
  if (is_surface_name(*path)) return OutputKind::kSurface;
  throw Error(ErrorCode::kBadArgument, "-o '" + *path +
                                           "': the ending must be .vtu or .vtk (the volume), or .obj, .ply, "
                                           ".stl or .off (its boundary surface)");
}

/// The regions, each with its error and falloff: one of them is for all, else there is one for each region.
std::vector<Focus> focus_of(const Arguments& arguments) {
  std::vector<Focus> focus;
  for (const std::string& text : arguments.focus)
    focus.push_back({parse_region("--focus", text), {0, true}, std::nullopt});
  const auto for_each_focus = [&](const char* option, const std::vector<std::string>& texts, auto&& set) {
    if (texts.empty()) return;
    if (focus.empty()) throw Error(ErrorCode::kBadArgument, std::string(option) + ": there is no --focus it is for");
    if (texts.size() != 1 && texts.size() != focus.size()) {
      throw Error(ErrorCode::kBadArgument, std::string(option) +
                                               ": give it once for every --focus, or once for each (" +
                                               std::to_string(focus.size()) + "), in their order");
    }
    for (std::size_t i = 0; i < focus.size(); ++i)
      set(focus[i], parse_bound(option, texts[texts.size() == 1 ? 0 : i]));
  };
  for_each_focus("--focus-error", arguments.focus_error, [](Focus& f, const Bound& bound) { f.error = bound; });
  for_each_focus("--focus-falloff", arguments.focus_falloff, [](Focus& f, const Bound& bound) { f.falloff = bound; });
  return focus;
}

std::optional<View> view_of(const Arguments& arguments) {
  if (!arguments.view) {
    for (const auto& [option, text] : {std::pair{"--pixels", arguments.pixels}, {"--outside", arguments.outside}})
      if (text) throw Error(ErrorCode::kBadArgument, std::string(option) + ": there is no --view it is for");
    return std::nullopt;
  }
  View view = parse_view("--view", *arguments.view);
  if (arguments.pixels) view.max_pixels = parse_number("--pixels", *arguments.pixels);
  if (arguments.outside) {
    view.outside = parse_number("--outside", *arguments.outside);
    if (view.outside < 1)
      throw Error(ErrorCode::kBadArgument, "--outside '" + *arguments.outside + "': a factor of at least 1 is wanted");
  }
  return view;
}

Wishes parse(const Arguments& arguments) {
  Wishes wishes;
  wishes.field_error = parse_field_bounds("--field-error", arguments.field_error);
  if (arguments.domain_error) wishes.domain_error = parse_bound("--domain-error", *arguments.domain_error);
  if (arguments.tets) wishes.tets = parse_count("--tets", *arguments.tets);
  if (arguments.vertices) wishes.vertices = parse_count("--vertices", *arguments.vertices);
  Request& request = wishes.request;
  if (arguments.bytes) request.max_bytes = parse_bytes("--bytes", *arguments.bytes);
  if (arguments.milliseconds) request.max_milliseconds = parse_number("--milliseconds", *arguments.milliseconds);
  if (arguments.memory_limit) wishes.memory_limit = parse_memory_limit(*arguments.memory_limit);
  request.focus = focus_of(arguments);
  for (const std::string& text : arguments.isovalue)
    request.values.push_back(parse_isovalue("--isovalue", text));
  for (const std::string& text : arguments.values)
    request.values.push_back(parse_values("--values", text));
  request.view = view_of(arguments);
  if (arguments.errors && kind_of(arguments.output) != OutputKind::kVolume) {
    throw Error(ErrorCode::kBadArgument, "--errors: cell arrays need -o with a .vtu or .vtk file");
  }
  if (arguments.input_order && kind_of(arguments.output) != OutputKind::kVolume)
    throw Error(ErrorCode::kBadArgument, "--input-order: an order needs -o with a .vtu or .vtk file");
  return wishes;
}

Request request_for(const Wishes& wishes, const DatasetInfo& info, const Arguments& arguments) {
  std::vector<std::string> all, governing;
  for (const FieldInfo& field : info.fields) {
    all.push_back(field.name);
    if (field.governing) governing.push_back(field.name);
  }
  Request request = wishes.request;
  request.field_error = resolve_field_bounds("--field-error", wishes.field_error, all, governing);
  request.domain_error = wishes.domain_error;
  if (wishes.tets) request.max_tets = wishes.tets->of(info.tets);
  if (wishes.vertices) request.max_vertices = wishes.vertices->of(info.vertices);
  for (const ValuesOfInterest& values : request.values)
    check_field("--isovalue, --values", values.field, all, governing);
  request.origins = arguments.errors;
  request.input_order = arguments.input_order;
  if (arguments.input_order && !info.has_input_order) {
    throw Error(ErrorCode::kBadArgument,
                "--input-order: the file does not keep the order of its input; build it with --keep-order");
  }
  return request;
}

/// For each governing field the error of each tet: that of the collapse that made it; 0 for an original tet. Where
/// records are missing nobody knows which these are: NaN.
std::vector<CellArray> error_arrays(const Dataset& dataset, const Extraction& extraction) {
  std::vector<CellArray> arrays;
  for (const FieldInfo& field : dataset.info().fields) {
    if (!field.governing) continue;
    std::vector<double> errors(extraction.made_by.size());
    dataset.origin_values(extraction.made_by, OriginValue::kFieldError, arrays.size(), errors);
    for (std::size_t t = 0; t < errors.size() && !extraction.complete; ++t)
      if (extraction.made_by[t].is_none()) errors[t] = std::numeric_limits<double>::quiet_NaN();
    arrays.push_back({"error of " + field.name, std::move(errors)});
  }
  return arrays;
}

/// Of a part of the original, as a point array; all of it says so by its order.
void name_input_vertices(Extraction& extraction) {
  if (extraction.input_vertex.empty() || extraction.limited_by == LimitedBy::kNothing) return;
  std::string name = "input vertex";
  for (int n = 2; extraction.mesh.find(name) != nullptr; ++n) // the field of an earlier extraction, perhaps
    name = "input vertex " + std::to_string(n);
  PointArray array{name, ScalarType::kUInt32, 1, {}};
  const auto bytes = std::as_bytes(std::span(extraction.input_vertex));
  array.bytes.assign(bytes.begin(), bytes.end());
  extraction.mesh.point_arrays.push_back(std::move(array));
}

/// Why the mesh is coarser than asked; nothing when it is not.
std::optional<Error> shortfall_of(const Extraction& extraction, const DatasetInfo& info, bool salvage) {
  if (extraction.complete) return std::nullopt;
  const std::string what = salvage ? "the mesh is coarser than asked: " : "the mesh cannot be had in full: ";
  const std::string hint = salvage ? "" : "; --salvage gives what is left, coarser";
  if (extraction.failures.empty())
    return Error(ErrorCode::kLimit, what + "its blocks do not fit the limit of memory; --memory-limit " +
                                        std::to_string(info.memory_for_all) + " is enough for all of the file" + hint);
  const BlockFailure& first = extraction.failures.front();
  std::string blocks = "block " + std::to_string(first.block);
  if (extraction.failures.size() > 1) blocks += " and " + counted(extraction.failures.size() - 1, "other");
  return Error(first.code, what + blocks + " failed, " + first.message + hint);
}

/// An extracted mesh must not take the place of its original, which has arrays that no .ptet file carries. Pieces of a
/// PVTU are known where it stands beside them.
void refuse_original(const Arguments& arguments, const std::string& target, const DatasetInfo& info,
                     const ProgressCallback& progress) {
  if (!std::filesystem::exists(target)) return;
  const Json provenance = Json::parse(info.provenance_json);
  const std::string name = provenance.at("source_name"), hash = provenance.at("source_hash");
  const std::string source = (std::filesystem::path(target).parent_path() / name).string();
  const bool is_piece_of_it = !name.empty() && is_piece(target, source);
  if (!is_piece_of_it && (hash.empty() || hash_input(target, {}, progress) != hash)) return;
  const std::string what =
      is_piece_of_it ? "a piece of '" + source + "'" : "the mesh that '" + arguments.input + "' was built from";
  throw Error(ErrorCode::kBadArgument,
              "-o '" + *arguments.output + "': this is " + what + ", and would be lost; give the output another name");
}

/// Of the user's time, opening the file has taken some.
Request with_what_is_left(Request request, Clock::time_point begin) {
  if (auto& milliseconds = request.max_milliseconds)
    milliseconds = std::max(0.0, *milliseconds - 1000 * seconds_since(begin));
  return request;
}

void run(const Arguments& arguments) {
  const Wishes wishes = parse(arguments);
  const OutputKind kind = kind_of(arguments.output);
  ExtractOutcome outcome;
  outcome.input = arguments.input;
  outcome.output = arguments.output;
  const std::string target =
      arguments.output ? checked_output("-o", *arguments.output, arguments.input) : std::string{};

  ProgressLine progress;
  const auto begin = Clock::now();
  const auto dataset = open_dataset(arguments.input, wishes.memory_limit);
  outcome.info = dataset->info();
  if (arguments.output) refuse_original(arguments, target, outcome.info, progress.callback());
  outcome.request = request_for(wishes, outcome.info, arguments);
  outcome.extraction = dataset->extract(with_what_is_left(outcome.request, begin), progress.callback());
  outcome.bytes = bytes_of(outcome.extraction);
  outcome.seconds = seconds_since(begin);
  outcome.notes = notes_on_wishes(outcome);
  if (outcome.info.overlaps_itself && outcome.extraction.limited_by != LimitedBy::kNothing)
    outcome.notes.emplace_back(kOverlaps);
  const std::optional<Error> shortfall = shortfall_of(outcome.extraction, outcome.info, arguments.salvage);
  if (shortfall && !arguments.salvage) throw *shortfall;

  const auto write_begin = Clock::now();
  if (kind != OutputKind::kNone) progress.stage("writing");
  if (kind == OutputKind::kVolume) {
    WriteOptions options;
    name_input_vertices(outcome.extraction);
    if (arguments.errors) options.cell_arrays = error_arrays(*dataset, outcome.extraction);
    write_mesh(target, outcome.extraction.mesh, options, progress.callback());
  } else if (kind == OutputKind::kSurface) {
    for (const std::string& note :
         notes_on_surface(write_surface(target, outcome.extraction.mesh, outcome.extraction.boundary_faces)))
      outcome.notes.push_back(note);
  }
  outcome.write_seconds = seconds_since(write_begin);
  progress.erase();

  if (arguments.json) {
    print_json(outcome);
  } else {
    print_text(outcome);
  }
  std::cout.flush();
  if (shortfall) throw *shortfall;
}

constexpr const char* kExamples = R"(Examples:
  ptet extract fire.ptet --field-error 1% -o coarse.vtu
  ptet extract fire.ptet --field-error u=2%,v=0.01 --domain-error 0.5% --errors -o mixed.vtu
  ptet extract fire.ptet --vertices 5% --focus box:0,0,0,100,100,50 -o detail.vtu
  ptet extract fire.ptet --focus sphere:10,20,5,8 --focus-error 0.5% -o near.vtu
  ptet extract fire.ptet --focus half:0,0,1,12.5 --focus-error 1% --focus-falloff 20% -o graded.vtu
  ptet extract fire.ptet --isovalue u=0.25 --field-error 1% -o isosurface.vtu
  ptet extract fire.ptet --values u=0.2..0.6 --field-error 2% --bytes 20MB -o visible.vtu
  ptet extract fire.ptet --view eye=9,-40,20:at=0,0,5:size=1280x720 --pixels 2 --outside 10 -o seen.vtu
  ptet extract fire.ptet --tets 20000 -o skin.stl
  ptet extract fire.ptet --field-error 0.1% --json
  ptet extract fire.ptet --input-order -o fire_again.vtu
  ptet extract damaged.ptet --salvage -o what_is_left.vtu

A block of the file that is damaged, or cannot be read, is an error, and nothing is written. With --salvage the mesh is
written all the same: conforming, coarser where records are missing, its errors true; the report tells the blocks, and
the exit code is that of the error.

With nothing asked the mesh is the original. X% of a field error is of the field's range, X% of a domain
error of the bounding-box diagonal; a plain X is in the units of the field or of the mesh. Bounds and budgets may be
combined: refining stops at the first that is reached, and the report says which. What a focus wants is
there whatever the budget of size, which it may pass, but only as far as --milliseconds allow.

Regions: box:x0,y0,z0,x1,y1,z1 - sphere:x,y,z,r - half:nx,ny,nz,d, the points with n.x <= d - and
obox:x,y,z,ax,ay,az,bx,by,bz,h, a box in any position: its centre, two perpendicular half axes a and b, and half its
thickness across them. Of several --focus-error or --focus-falloff each is for the --focus at the same place.
--focus-falloff X: outside, the error allowed grows by X for every diagonal of distance.

--isovalue and --values keep bounds only where the field may take such values, so that isosurfaces of the mesh and of
the original run within the bound and the rest costs little; with no bound the tets there are original ones. Of vectors
the length counts. --view keeps the boundary sharp to --pixels in a picture in perspective (angle is that of its height,
30 degrees unless it says; size 1920x1080); what is out of the picture may have --outside times the errors.

--json prints {"asked", "achieved": {"field_error": {NAME: x}, "domain_error", "errors_are_bounds": true | false,
"overlaps_itself": true | false, "rms_error": {NAME: x} | null, "covered": x | null}, "vertices", "tets", "bytes",
"bytes_read", "read_requests", "seconds", "limited_by": "error" | "budget" | "time" | "focus" | "nothing" | "memory" |
"unreadable", "complete": true | false, "failures": [{"block", "byte_offset", "message"}], "notes": [TEXT], "output"}:
errors absolute, seconds for opening and extraction ("write_seconds" for the writing), bytes those that --bytes counts.
Errors are no bounds where the build has not measured them everywhere (--evaluate). Where tets of the original lie in
one another ("overlaps_itself"), errors are those of each part by itself. With a focus, values or a view "achieved" has
the errors there by themselves: "in_focus", with the "tets" of the mesh that meet it, and "at_values", lists in the order
asked (isovalues first), and "in_view" with "pixels" (null where an eye is so near that none is a bound). The RMS error is over what the mesh covers of the
original, of whose volume that is at least the part "covered"; a build that did not measure them leaves none. Notes say
what of the wishes met nothing, that tets of the original lie in one another, and what .stl could not hold.
)";

} // namespace

void add_extract(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("extract", "Get one mesh out of a .ptet file, by error, size, focus, values or view");
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
  command->add_option("--tets", arguments->tets, "at most so many tets, those that keep errors small")
      ->option_text("N|N%");
  command->add_option("--vertices", arguments->vertices, "at most so many vertices")->option_text("N|N%");
  command->add_option("--bytes", arguments->bytes, "at most so large: points, fields, tets and boundary faces")
      ->option_text("N|NkB|NMB|NGB");
  command
      ->add_option("--milliseconds", arguments->milliseconds,
                   "refine no longer than this, reading included; what is\nthere by then is the answer")
      ->option_text("X");
  command
      ->add_option(
          "--focus", arguments->focus,
          "box:..., obox:..., sphere:... or half:... (see below): the\noriginal inside, repeatable; outside as "
          "coarse as the rest\nallows")
      ->allow_extra_args(false)
      ->option_text("REGION");
  command
      ->add_option("--focus-error", arguments->focus_error,
                   "largest error inside the focus (0: the original); once,\nor once for each --focus")
      ->allow_extra_args(false)
      ->option_text("X|X%");
  command
      ->add_option(
          "--focus-falloff", arguments->focus_falloff,
          "allow so much more for each diagonal of distance from the\nfocus; without it nothing is asked outside")
      ->allow_extra_args(false)
      ->option_text("X|X%");
  command->add_option("--isovalue", arguments->isovalue, "keep the bounds only where the field may be V; repeatable")
      ->allow_extra_args(false)
      ->option_text("FIELD=V");
  command->add_option("--values", arguments->values, "the same for an interval; MIN or MAX may be left out")
      ->allow_extra_args(false)
      ->option_text("FIELD=MIN..MAX");
  command
      ->add_option(
          "--view", arguments->view,
          "a camera: eye=x,y,z:at=x,y,z, and if need be :up=x,y,z\n:angle=DEGREES :size=WxH: as sharp as it sees")
      ->option_text("VIEW");
  command->add_option("--pixels", arguments->pixels, "largest domain error in the view, in pixels (1)")
      ->option_text("X");
  command
      ->add_option("--outside", arguments->outside,
                   "so many times the errors outside the view; without it\nnothing is asked there")
      ->option_text("FACTOR");
  command
      ->add_option("--memory-limit", arguments->memory_limit,
                   "memory that the file may take: 8GB, 500MB or bytes (as\n"
                   "much as the machine has). What does not fit in is left out,\nan error but with --salvage")
      ->option_text("N|NMB|NGB");
  command->add_flag("--errors", arguments->errors,
                    "add for each field a cell array with the error of each\ntet (.vtu and .vtk); reads all of the "
                    "file. NaN where\n--salvage cannot know it");
  command->add_flag("--input-order", arguments->input_order,
                    "vertices in the order of the mesh that the file was\n"
                    "built from, and of the original its cells, too; of less\n"
                    "than that 'input vertex' says which they are. Needs a\nfile built with --keep-order");
  command->add_flag(
      "--salvage", arguments->salvage,
      "write the mesh also where blocks of the file are damaged,\ncoarser there; the exit code still tells");
  command->add_flag("--json", arguments->json, "the report as one JSON object");
  command->footer(kExamples);
  command->callback([arguments] { about_file(arguments->input, [&] { run(*arguments); }); });
}

} // namespace ptet::cli
