// ptet measure: how far a simplified mesh is from its original, whoever made it: fields, boundary, volumes, and whether
// it is a sound mesh. It takes the two meshes and nothing else, so it is a check of what other commands state.
#include "arguments.hpp"
#include "build/threads.hpp"
#include "commands.hpp"
#include "compare.hpp"
#include "console.hpp"
#include "files.hpp"
#include "formats/file_names.hpp"
#include "formats/vtk/write.hpp"
#include "input_pieces.hpp"
#include "measure_report.hpp"
#include "mesh/governing.hpp"
#include "mesh/value_offset.hpp"
#include "ptet/weld.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <tuple>

namespace ptet::cli {
namespace {

/// Random points outside the simplified mesh when what is inside is compared exactly.
constexpr std::uint64_t kOutsideSamples = 50'000;
/// Distances below this share of the diagonal need no closer look.
constexpr double kNegligible = 1e-9;

struct Arguments {
  std::string original, simplified;
  std::vector<std::string> fields;
  bool exact = false;
  std::optional<std::string> samples, seed, threads, tolerance, errors;
  bool weld = false;
  std::optional<std::string> weld_within;
  bool json = false;
};

/// What the options say by themselves, before the meshes are known.
struct Wishes {
  std::optional<std::uint64_t> samples;
  std::uint64_t seed = 1;
  int threads = 0;
  double tolerance = 0.01;
  std::optional<Bound> weld;
};

Wishes parse(const Arguments& arguments) {
  constexpr std::uint64_t kMany = 1'000'000'000'000;
  Wishes wishes;
  if (arguments.exact && arguments.samples)
    throw Error(ErrorCode::kBadArgument, "--exact and --samples exclude each other");
  if (arguments.errors && arguments.samples)
    throw Error(ErrorCode::kBadArgument, "--errors needs the exact comparison: leave --samples out");
  if (arguments.errors && ending_of(*arguments.errors) != ".vtu")
    throw Error(ErrorCode::kBadArgument, "--errors '" + *arguments.errors + "': the ending must be .vtu");
  if (arguments.samples) wishes.samples = parse_whole("--samples", *arguments.samples, 1, kMany);
  if (arguments.seed) wishes.seed = parse_whole("--seed", *arguments.seed, 0, kMany);
  if (arguments.threads) wishes.threads = static_cast<int>(parse_whole("--threads", *arguments.threads, 0, 1024));
  if (arguments.tolerance) {
    const Bound bound = parse_bound("--tolerance", *arguments.tolerance);
    wishes.tolerance = bound.value;
    if (!bound.relative || !(bound.value > 0))
      throw Error(ErrorCode::kBadArgument, "--tolerance '" + *arguments.tolerance + "': it must be X% with X above 0");
  }
  wishes.weld = welding_of(arguments.weld, arguments.weld_within);
  return wishes;
}

/// Throws Error(kBadInput) for what makes distances or volumes meaningless. Defects of the complex are only reported.
void check_usable(const MeasuredMesh& side) {
  static constexpr std::array kFatal = {"bad-positions",  "tiny-extent", "non-finite-positions",
                                        "huge-positions", "no-tets",     "ids-out-of-range"};
  for (const Finding& finding : side.report.findings)
    for (const char* code : kFatal)
      if (finding.code == code)
        throw Error(ErrorCode::kBadInput, "'" + side.path + "' cannot be measured: " +
                                              finding.message.substr(0, finding.message.rfind(": ")));
}

MeasuredMesh load(const std::string& path, const std::optional<Bound>& weld, ProgressLine& progress) {
  MeasuredMesh side;
  side.path = path;
  progress.stage("reading");
  side.mesh = read_mesh(path, &side.read, progress.callback());
  if (weld) side.read.notes.push_back(welding_note(weld_points(side.mesh, *weld, progress.callback()), *weld));
  side.found = examine(side.mesh, progress.callback());
  side.report = report_on(side.mesh, side.found);
  check_usable(side);
  return side;
}

/// Says so when a mesh orders the vertices of all its tets by the other convention, and when it has vertices in none.
void note_findings(const MeasuredMesh& side, std::vector<std::string>& notes) {
  for (const Finding& finding : side.report.findings) {
    if (finding.code == "inverted-tets" && finding.severity == Severity::kNote)
      notes.push_back("'" + side.path + "' orders the vertices of all its tets by the other convention");
    if (finding.code == "unused-points")
      notes.push_back(grouped(finding.count) + (finding.count == 1 ? " vertex of '" : " vertices of '") + side.path +
                      (finding.count == 1 ? "' is" : "' are") + " in no tet: counted, but not compared");
  }
}

/// Whether tets may overlap, as far as is found: some only touch. Its boundary must have been looked at.
bool overlaps_itself(const MeasuredMesh& side) {
  constexpr std::array kOverlaps = {"folded-faces", "overlapping-tets", "duplicate-tets", "faces-of-many-tets"};
  return side.boundary_intersections > 0 || std::any_of(kOverlaps.begin(), kOverlaps.end(), [&](const char* code) {
           return count_of(side.report, code) > 0;
         });
}

/// Says so where the field of the original has several values at one place.
void note_overlaps(const MeasuredMesh& original, std::vector<std::string>& notes) {
  const auto says = [&](const char* code) { return count_of(original.report, code) > 0; };
  std::string what;
  if (original.boundary_intersections > 0)
    what = "the boundary of '" + original.path + "' touches or intersects itself";
  else if (says("folded-faces"))
    what = "tets of '" + original.path + "' are folded over one another";
  else if (says("overlapping-tets"))
    what = "parts of '" + original.path + "' reach into one another";
  else
    return;
  notes.push_back(what + ": wherever its tets overlap, their values differ among themselves, and that counts "
                         "as an error here; the errors that a .ptet file states do not hold it");
}

// Fields.

bool is_floating(const PointArray& array) {
  return array.type == ScalarType::kFloat32 || array.type == ScalarType::kFloat64;
}

/// Empty when the array can be compared; else why not.
std::string unusable(const MeasuredMesh& side, const PointArray& array) {
  if (array.size() != side.mesh.vertex_count()) return "has not one row for each vertex in '" + side.path + "'";
  for (std::uint32_t v = 0; v < array.size(); ++v) {
    if (!side.found.links.used[v]) continue;
    for (std::uint32_t i = 0; i < array.components; ++i)
      if (!std::isfinite(array.value(v, i)))
        return "is not finite at vertex " + std::to_string(v) + " of '" + side.path + "'";
  }
  return {};
}

/// Of the first vertex in a tet. A field that is compared has one row for each vertex.
ValueOffset offset_of(const MeasuredMesh& original, const PointArray& array, std::uint32_t component) {
  const auto& used = original.found.links.used;
  const auto first = static_cast<std::size_t>(std::find(used.begin(), used.end(), 1) - used.begin());
  return {array, first < array.size() ? first : 0, component};
}

/// Whether integers are further apart than a double can tell them.
bool spans_too_much(const MeasuredMesh& original, const MeasuredMesh& side, const PointArray& of_original,
                    const PointArray& array) {
  if (!has_wide_integers(array)) return false;
  for (std::uint32_t i = 0; i < array.components; ++i) {
    const ValueOffset offset = offset_of(original, of_original, i);
    for (std::uint32_t v = 0; v < array.size(); ++v)
      if (side.found.links.used[v] && std::abs(offset.value(array, v, i)) >= kExactIntegers) return true;
  }
  return false;
}

std::vector<std::string> array_names(const TetMesh& mesh) {
  std::vector<std::string> names;
  for (const PointArray& array : mesh.point_arrays)
    names.push_back(array.name);
  return names;
}

const PointArray& named_array(const MeasuredMesh& side, const std::string& name) {
  const PointArray* const array = side.mesh.find(name);
  if (array != nullptr) return *array;
  throw Error(ErrorCode::kBadArgument, "--field: there is no field '" + name + "' in '" + side.path + "'; there are " +
                                           quoted_list(array_names(side.mesh)));
}

/// NAME, or NAME=OTHER where no array has the whole as its name.
std::pair<std::string, std::string> names_in(const std::string& text, const MeasuredMesh& original) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || original.mesh.find(text) != nullptr) return {text, text};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

/// The fields asked for, or every floating-point one that both meshes have (every one when the original has no such),
/// as build chooses those that govern; what is left out gets a note.
std::vector<ComparedField> choose_fields(const std::vector<std::string>& names, const MeasuredMesh& original,
                                         const MeasuredMesh& simplified, std::vector<std::string>& notes) {
  std::vector<ComparedField> fields;
  const auto why_not = [&](const PointArray& a, const PointArray& b) -> std::string {
    if (a.components != b.components)
      return "has " + std::to_string(a.components) + " components in '" + original.path + "' and " +
             std::to_string(b.components) + " in '" + simplified.path + "'";
    std::string why = unusable(original, a);
    if (why.empty()) why = unusable(simplified, b);
    if (why.empty() && (spans_too_much(original, original, a, a) || spans_too_much(original, simplified, a, b)))
      why = "has integers that are 2^53 or more apart, which cannot be compared";
    return why;
  };
  for (const std::string& text : names) {
    const auto [name, other] = names_in(text, original);
    const PointArray &a = named_array(original, name), &b = named_array(simplified, other);
    const auto before =
        std::find_if(fields.begin(), fields.end(), [&](const ComparedField& field) { return field.name == a.name; });
    if (before != fields.end()) {
      if (before->simplified_name == b.name) continue;
      throw Error(ErrorCode::kBadArgument, "--field: '" + a.name + "' is to be compared with '" +
                                               before->simplified_name + "' and with '" + b.name +
                                               "': one of them at a time");
    }
    const std::string why = why_not(a, b);
    if (!why.empty()) throw Error(ErrorCode::kBadInput, "field '" + name + "' " + why);
    fields.push_back({name, other, a.components, range_of(a, original.found.links.used)});
  }
  if (!names.empty()) return fields;
  const std::size_t notes_before = notes.size();
  const std::vector<PointArray>& arrays = original.mesh.point_arrays;
  const bool only_integers = std::none_of(arrays.begin(), arrays.end(), is_floating);
  std::vector<std::string> absent;
  for (const PointArray& a : arrays) {
    const PointArray* const b = simplified.mesh.find(a.name);
    if (!only_integers && !is_floating(a)) continue;
    if (b == nullptr) {
      absent.push_back("field '" + a.name + "' is left out: it is not in '" + simplified.path + "'");
      continue;
    }
    const bool is_of_integers = !only_integers && !is_floating(*b);
    const std::string why =
        is_of_integers ? "has integers in '" + simplified.path + "' (--field compares them)" : why_not(a, *b);
    if (why.empty()) {
      fields.push_back({a.name, a.name, a.components, range_of(a, original.found.links.used)});
    } else {
      notes.push_back("field '" + a.name + "' is left out: it " + why);
    }
  }
  if (fields.empty() && notes.size() == notes_before) {
    notes.emplace_back("the meshes have no " + std::string(only_integers ? "" : "floating-point ") +
                       "field in common: none is compared");
  } else {
    notes.insert(notes.end(), absent.begin(), absent.end());
  }
  return fields;
}

/// Vertex x channel; of integers of 64 bits what they are above those of one vertex of the original.
std::vector<double> values_of(const TetMesh& mesh, const MeasuredMesh& original,
                              const std::vector<ComparedField>& fields, std::string ComparedField::*name) {
  struct Channel {
    const PointArray* array;
    std::uint32_t component;
    ValueOffset offset;
  };
  std::vector<Channel> channels;
  for (const ComparedField& field : fields)
    for (std::uint32_t i = 0; i < field.components; ++i)
      channels.push_back({mesh.find(field.*name), i, offset_of(original, *original.mesh.find(field.name), i)});
  std::vector<double> values;
  values.reserve(mesh.vertex_count() * channels.size());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    for (const Channel& channel : channels)
      values.push_back(channel.offset.value(*channel.array, v, channel.component));
  return values;
}

// Measuring.

void measure_fields(const Wishes& wishes, MeasureOutcome& outcome, const ProgressCallback& progress) {
  const auto& [original, simplified] = std::tie(outcome.original, outcome.simplified);
  const std::vector<double> values = values_of(original.mesh, original, outcome.fields, &ComparedField::name);
  const std::vector<double> other_values =
      values_of(simplified.mesh, original, outcome.fields, &ComparedField::simplified_name);
  std::vector<std::uint32_t> components;
  for (const ComparedField& field : outcome.fields)
    components.push_back(field.components);
  const MeshComparison comparison({original.found.points, original.mesh.tets, values},
                                  {simplified.found.points, simplified.mesh.tets, other_values},
                                  simplified.found.boundary.faces, components);
  outcome.original.volume = comparison.original_volume();
  outcome.simplified.volume = comparison.simplified_volume();
  if (wishes.samples) {
    MeshComparison::Sampled sampled = comparison.sampled(*wishes.samples, wishes.seed, progress);
    outcome.inside = std::move(sampled.inside);
    outcome.outside = std::move(sampled.outside);
  } else {
    outcome.inside = comparison.exact_inside(progress);
  }
  if (!(outcome.inside.volume > 0)) {
    for (const MeasuredMesh* side : {&outcome.original, &outcome.simplified})
      if (!(side->volume > 0))
        throw Error(ErrorCode::kBadInput, "'" + side->path + "' has no volume: its tets are flat");
    const auto box = [](const MeshReport& report) {
      return placed(report.box_min, report.diagonal()) + " to " + placed(report.box_max, report.diagonal());
    };
    throw Error(ErrorCode::kBadInput, (wishes.samples ? "no sample of '" + original.path + "' lies in '" +
                                                            simplified.path + "': do the meshes overlap? They"
                                                      : std::string("the meshes do not overlap: they")) +
                                          " reach from " + box(original.report) + " and from " +
                                          box(simplified.report));
  }
  if (!wishes.samples)
    outcome.outside = comparison.sampled_outside(outcome.inside, overlaps_itself(outcome.simplified), kOutsideSamples,
                                                 wishes.seed, progress);
  outcome.vertices = comparison.at_vertices(progress);
  comparison.add_vertices(outcome.vertices, outcome.outside);
}

void measure_boundaries(const Wishes& wishes, MeasureOutcome& outcome, const ProgressCallback& progress) {
  const std::vector<Triangle> original =
      triangles_of(outcome.original.found.points, outcome.original.found.boundary.faces);
  const std::vector<Triangle> simplified =
      triangles_of(outcome.simplified.found.points, outcome.simplified.found.boundary.faces);
  const double negligible = kNegligible * outcome.original.report.diagonal();
  outcome.there = one_sided_hausdorff(original, TriangleSurface(simplified), wishes.tolerance, negligible, progress);
  outcome.back = one_sided_hausdorff(simplified, TriangleSurface(original), wishes.tolerance, negligible, progress);
}

/// The original with the errors at its vertices and in its tets.
void write_errors(const std::string& path, const MeasureOutcome& outcome, const ProgressCallback& progress) {
  TetMesh mesh = outcome.original.mesh;
  WriteOptions options;
  const std::size_t fields = outcome.fields.size();
  const auto column = [&](const std::vector<double>& table, std::size_t f) {
    std::vector<double> values;
    for (std::size_t i = f; i < table.size(); i += fields)
      values.push_back(table[i]);
    return values;
  };
  for (std::size_t f = 0; f < fields; ++f) {
    std::string name = outcome.fields[f].name + " error";
    for (int n = 2; mesh.find(name) != nullptr; ++n)
      name = outcome.fields[f].name + " error " + std::to_string(n);
    const std::vector<double> at_vertices = column(outcome.vertices.max, f);
    PointArray array{name, ScalarType::kFloat64, 1, std::vector<std::byte>(at_vertices.size() * sizeof(double))};
    if (!at_vertices.empty()) std::memcpy(array.bytes.data(), at_vertices.data(), array.bytes.size());
    mesh.point_arrays.push_back(std::move(array));
    options.cell_arrays.push_back({name, column(outcome.inside.cell_max, f)});
  }
  write_mesh(path, mesh, options, progress);
}

void run(const Arguments& arguments) {
  const Wishes wishes = parse(arguments);
  std::string target;
  if (arguments.errors) {
    for (const std::string& mesh : {arguments.original, arguments.simplified}) {
      target = checked_output("--errors", *arguments.errors, mesh);
      refuse_piece("--errors", target, mesh);
    }
  }
  const auto begin = Clock::now();
  build::Threads threads(static_cast<unsigned>(wishes.threads));
  ProgressLine progress;
  MeasureOutcome outcome;
  outcome.samples = wishes.samples;
  threads.run([&] {
    outcome.original = load(arguments.original, wishes.weld, progress);
    outcome.simplified = load(arguments.simplified, wishes.weld, progress);
  });
  for (const MeasuredMesh* side : {&outcome.original, &outcome.simplified})
    add_reading_notes(side->path, side->read, outcome.notes);
  note_findings(outcome.original, outcome.notes);
  note_findings(outcome.simplified, outcome.notes);
  outcome.fields = choose_fields(arguments.fields, outcome.original, outcome.simplified, outcome.notes);
  if (arguments.errors && outcome.fields.empty())
    throw Error(ErrorCode::kBadInput,
                "--errors: there are no errors to write: " +
                    outcome.notes.back()); // which says why no field is compared
  threads.run([&] {
    for (MeasuredMesh* side : {&outcome.original, &outcome.simplified})
      side->boundary_intersections =
          count_boundary_intersections(side->found.points, side->found.boundary.faces, progress.callback());
    measure_fields(wishes, outcome, progress.callback());
    measure_boundaries(wishes, outcome, progress.callback());
    note_overlaps(outcome.original, outcome.notes);
  });
  if (arguments.errors) {
    progress.stage("writing");
    write_errors(target, outcome, progress.callback());
  }
  outcome.seconds = seconds_since(begin);
  progress.erase();
  arguments.json ? print_json(outcome, arguments.errors) : print_text(outcome, arguments.errors);
}

constexpr const char* kExamples = R"(Examples:
  ptet measure fire.vtu coarse.vtu
  ptet measure fire.vtu coarse.vtu --field t --json
  ptet measure wing.vtu decimated.vtu --field pressure=scalars --samples 1000000 --seed 7
  ptet measure fire.vtu coarse.vtu --errors errors.vtu

SIMPLIFIED may be any tetrahedral mesh of about the same domain, made by whatever program; it need not share vertices
with ORIGINAL. The difference of a field is the Euclidean norm over its components.

inside    where the two domains overlap: exact by clipping tets against tets, or with --samples at random points spread
          over the volume (then the maximum is a lower bound). Where tets overlap others of their own mesh, every pair
          counts.
outside   the rest of ORIGINAL's domain, against the value at the closest point of SIMPLIFIED. Always sampled: the
          vertices of ORIGINAL that lie there, and 50,000 random points (with --samples: those of the N that fall there).
          The RMS is over the points; films so thin that no point is found in them are said to be left out.
distance  the one-sided Hausdorff distances between the boundaries, each between a lower bound that is attained and an
          upper bound that is certified, as a rule at most --tolerance apart, or below 1e-9 of the diagonal; needles
          may take more cuts than are made.
validity  tets whose orientation or shape is wrong (exact), what is no manifold, boundary faces that intersect (exact).
          What is found does not change the exit code.

--errors writes ORIGINAL with an array "NAME error" for each field: at vertices the difference there, in tets the
greatest difference over what SIMPLIFIED covers of it (NaN where that is nothing).

--json prints {"original", "simplified": {"volume", "validity": {"valid", ...}}, "overlap", "inside", "outside":
{"fields": {NAME: {"max", "max_percent", "max_at", "rms", "rms_percent"}}}, for outside also "missed_points", those that
were to lie in such films, "ranges", "hausdorff", "notes", "seconds"}. What there is no number of is null: the place of a
maximum of 0, percents of a field that is constant, tets that overlap where tets are folded or lie in one place.
)";

} // namespace

void add_measure(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("measure", "Compare any simplified mesh with its original: fields, boundary, validity");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("ORIGINAL", arguments->original, "the mesh that counts as the truth")
      ->required()
      ->option_text(" ");
  command->add_option("SIMPLIFIED", arguments->simplified, "the mesh to compare: .vtu, .pvtu, .vtk or Exodus")
      ->required()
      ->option_text(" ");
  command
      ->add_option("--field", arguments->fields,
                   "compare this point array; repeatable. NAME=OTHER when\nSIMPLIFIED calls it OTHER. Without it "
                   "every\nfloating-point array that both have (every array\nwhen the original has none)")
      ->allow_extra_args(false)
      ->option_text("NAME[=OTHER]");
  command->add_flag("--exact", arguments->exact, "errors inside exact, by clipping (what it does anyway)");
  command->add_option("--samples", arguments->samples, "errors inside at N random points instead")->option_text("N");
  command->add_option("--seed", arguments->seed, "of the random points (1)")->option_text("N");
  command->add_option("--tolerance", arguments->tolerance, "between the bounds of a distance (1%)")->option_text("X%");
  command
      ->add_option("--threads", arguments->threads,
                   "worker threads; 0: as many as the machine has (0).\nThe result does not depend on it")
      ->option_text("N");
  command->add_option("--errors", arguments->errors, "write ORIGINAL with its errors as a .vtu")->option_text("OUT");
  command->add_flag("--weld", arguments->weld,
                    "first make one point of those that have the same place\n"
                    "and the same values, as build --weld does");
  command->add_option("--weld-within", arguments->weld_within, "the same as build --weld-within")->option_text("D");
  command->add_flag("--json", arguments->json, "the report as one JSON object");
  command->footer(kExamples);
  command->callback([arguments] { run(*arguments); });
}

} // namespace ptet::cli
