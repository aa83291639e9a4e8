// ptet build: a mesh in, a .ptet file with all its levels out, and a report of how that went.
#include "ptet/build.hpp"

#include "arguments.hpp"
#include "build_methods.hpp"
#include "build_report.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "formats/file_names.hpp"
#include "formats/surface/write.hpp"
#include "formats/vtk/read.hpp"
#include "formats/vtk/write.hpp"
#include "input_pieces.hpp"
#include "mesh/governing.hpp"
#include "ptet/dataset.hpp"
#include "ptet/pieces_build.hpp"
#include "ranks.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>

namespace ptet::cli {
namespace {

struct Arguments {
  std::string input;
  std::optional<std::string> output;
  std::vector<std::string> fields;
  std::vector<std::string> max_field_error;
  std::optional<std::string> max_domain_error;
  std::optional<std::string> target_vertices;
  std::optional<std::string> min_quality;
  std::optional<std::string> method;
  std::optional<std::string> predict;
  std::optional<std::string> evaluate;
  std::optional<std::string> objective;
  std::optional<std::string> max_star;
  std::optional<std::string> pieces;
  bool weld = false;
  std::optional<std::string> weld_within;
  bool keep_order = false;
  std::optional<std::string> threads;
  std::optional<std::string> memory_limit;
  std::optional<std::string> checkpoint;
  std::optional<std::string> checkpoint_every;
  bool resume = false;
  bool force = false;
  bool json = false;
  bool quiet = false;
};

/// What the options say by themselves, before the mesh is known.
struct Wishes {
  BuildOptions options;
  std::vector<FieldBound> max_field_error;
  std::optional<Count> target;
};

constexpr std::array kPredictions = {
    Prediction::kExact,    Prediction::kLocal,       Prediction::kGradient, Prediction::kQuadric,
    Prediction::kSimulate, Prediction::kWeightedSum, Prediction::kPerTet,
};
constexpr std::array kEvaluations = {
    Evaluation::kExact,
    Evaluation::kNone,
    Evaluation::kVertices,
    Evaluation::kSamples,
};
constexpr std::array kObjectives = {
    Objective::kBoth,
    Objective::kMaximum,
    Objective::kRootMeanSquare,
};

std::string_view name_of(const Method& method) {
  return method.name;
}

/// The entry of a table whose name was given.
template <class Table>
const auto& chosen(const char* option, const std::string& name, const Table& table) {
  std::vector<std::string> names;
  for (const auto& entry : table) {
    const std::string_view known = name_of(entry);
    if (name == known) return entry;
    names.emplace_back(known);
  }
  throw Error(ErrorCode::kBadArgument, std::string(option) + " '" + name + "': it is one of " + quoted_list(names));
}

void choose_method(const Arguments& arguments, BuildOptions& options) {
  if (arguments.method) {
    const Method& method = chosen("--method", *arguments.method, kMethods);
    options.prediction = method.prediction;
    options.evaluation = method.evaluation;
  }
  if (arguments.predict) options.prediction = chosen("--predict", *arguments.predict, kPredictions);
  if (arguments.evaluate) options.evaluation = chosen("--evaluate", *arguments.evaluate, kEvaluations);
  if (arguments.objective) options.objective = chosen("--objective", *arguments.objective, kObjectives);
  if (options.prediction == Prediction::kExact && options.evaluation != Evaluation::kExact) {
    if (arguments.predict || arguments.method)
      throw Error(ErrorCode::kBadArgument,
                  "the collapses of method exact are ordered by errors measured everywhere: it "
                  "goes with --evaluate exact; for less, give another --predict");
    options.prediction = Prediction::kQuadric;
  }
  if (arguments.objective && !simulates(options))
    throw Error(ErrorCode::kBadArgument,
                "--objective '" + *arguments.objective +
                    "': it is what exact, BF and BFS order collapses by; this method does not");
}

Wishes parse(const Arguments& arguments) {
  Wishes wishes;
  wishes.options.fields = arguments.fields;
  wishes.max_field_error = parse_field_bounds("--max-field-error", arguments.max_field_error);
  if (arguments.max_domain_error) {
    wishes.options.max_domain_error = parse_bound("--max-domain-error", *arguments.max_domain_error);
  }
  if (arguments.target_vertices) wishes.target = parse_count("--target-vertices", *arguments.target_vertices);
  if (arguments.min_quality) {
    wishes.options.min_quality = parse_number("--min-quality", *arguments.min_quality);
    if (*wishes.options.min_quality >= 1) {
      throw Error(ErrorCode::kBadArgument,
                  "--min-quality '" + *arguments.min_quality + "': it must be below 1, the shape of a regular tet");
    }
  }
  choose_method(arguments, wishes.options);
  if (arguments.max_star) {
    wishes.options.max_star =
        static_cast<std::uint32_t>(parse_whole("--max-star", *arguments.max_star, kLeastMaxStar, kGreatestMaxStar));
  }
  wishes.options.weld = welding_of(arguments.weld, arguments.weld_within);
  wishes.options.keep_order = arguments.keep_order;
  if (arguments.pieces) {
    wishes.options.pieces = static_cast<std::uint32_t>(parse_whole("--pieces", *arguments.pieces, 1, kMostPieces));
    if (wishes.options.pieces > 1 && arguments.checkpoint)
      throw Error(ErrorCode::kBadArgument,
                  "--checkpoint: a build over pieces keeps no checkpoints; leave out --pieces");
  }
  if (arguments.threads) {
    wishes.options.threads = static_cast<unsigned>(parse_whole("--threads", *arguments.threads, 0, 1024));
  }
  if (arguments.memory_limit) wishes.options.memory_limit = parse_memory_limit(*arguments.memory_limit);
  if (arguments.checkpoint_every) {
    wishes.options.checkpoint.every_seconds = parse_duration("--checkpoint-every", *arguments.checkpoint_every);
  }
  wishes.options.checkpoint.resume = arguments.resume;
  if (!arguments.checkpoint && (arguments.checkpoint_every || arguments.resume)) {
    throw Error(ErrorCode::kBadArgument,
                std::string(arguments.resume ? "--resume" : "--checkpoint-every") + ": it goes with --checkpoint FILE");
  }
  return wishes;
}

std::vector<std::string> names_of(const TetMesh& mesh) {
  std::vector<std::string> names;
  for (const PointArray& array : mesh.point_arrays)
    names.push_back(array.name);
  return names;
}

/// The rule of BuildOptions::fields. `cell_arrays`: names that are not those of point arrays.
std::vector<std::string> governing_names(const TetMesh& mesh, const std::vector<std::string>& asked,
                                         const std::vector<std::string>& cell_arrays) {
  const std::vector<std::string> all = names_of(mesh);
  for (const std::string& name : asked) {
    if (mesh.find(name) != nullptr) continue;
    if (std::find(cell_arrays.begin(), cell_arrays.end(), name) != cell_arrays.end())
      throw Error(ErrorCode::kBadArgument, "--field: only cells have values of '" + name + "': " + kCellsToPoints);
    throw Error(ErrorCode::kBadArgument,
                "--field: there is no point array '" + name + "'; there are: " + quoted_list(all));
  }
  if (!asked.empty()) return asked;
  std::vector<std::string> names;
  for (const std::uint32_t i : governing_by_default(mesh.point_arrays))
    names.push_back(all[i]);
  return names;
}

/// Whether a mesh or a surface would have such a name, not a .ptet file.
bool is_name_of_mesh(const std::string& path) {
  static constexpr std::array kOnlyRead = {".pvtu", ".e", ".g", ".ex2", ".exo", ".exii"};
  return is_mesh_name(path) || is_surface_name(path) ||
         std::find(kOnlyRead.begin(), kOnlyRead.end(), ending_of(path)) != kOnlyRead.end();
}

std::string output_of(const Arguments& arguments) {
  const std::string path = arguments.output.value_or(std::filesystem::path(arguments.input).stem().string() + ".ptet");
  std::string target = checked_output("-o", path, arguments.input);
  refuse_piece("-o", target, arguments.input);
  if (!arguments.force && is_name_of_mesh(target)) {
    throw Error(ErrorCode::kBadArgument,
                "-o '" + path +
                    "': this ending is a mesh's, and a .ptet file is written; give a name that ends in "
                    ".ptet, or --force");
  }
  const bool meant = arguments.force || ending_of(target) == ".ptet";
  if (!meant && size_of_file(target) > 0 && !is_ptet_file(target)) {
    throw Error(ErrorCode::kBadArgument,
                "'" + path + "' exists and is not a .ptet file; give another name with -o, or --force to replace it");
  }
  return target;
}

/// Looked at before the mesh is read, which may take long.
std::string checkpoint_of(const Arguments& arguments, const std::string& output) {
  if (!arguments.checkpoint) return {};
  const std::string& given = *arguments.checkpoint;
  std::string path = checked_output("--checkpoint", given, arguments.input);
  refuse_piece("--checkpoint", path, arguments.input);
  if (is_same_file(path, output))
    throw Error(ErrorCode::kBadArgument, "--checkpoint '" + given + "': this is the output file");
  std::error_code status;
  const bool exists = std::filesystem::exists(path, status);
  if (exists && !arguments.resume) {
    throw Error(ErrorCode::kBadArgument, "--checkpoint '" + given +
                                             "': it is there already; go on from it with --resume, or remove it to "
                                             "begin anew");
  }
  if (!exists && arguments.resume) {
    throw Error(ErrorCode::kIo, "--resume: there is no checkpoint '" + given + "'; without --resume the build begins");
  }
  return path;
}

/// As BuildOptions has it. Of how many vertices a percentage is, the build knows.
double target_of(const Count& target, std::size_t vertices) {
  return target.relative && target.value < 1 ? target.value : static_cast<double>(target.of(vertices));
}

/// Both passes, the first by all processes. Nothing where this is not the first of them.
std::optional<BuildReport> build_together(Ranks& ranks, TetMesh mesh, const BuildOutcome& outcome,
                                          const BuildOptions& options, const std::string& name, const std::string& hash,
                                          const ProgressCallback& progress) {
  PiecesBuild pieces(std::move(mesh), options, progress);
  const auto begin = Clock::now();
  std::vector<Decided> decided = ranks.decide(pieces, progress);
  if (!ranks.is_first()) return std::nullopt;
  const double seconds = seconds_since(begin);
  pieces.set_threads(ranks.threads_afterwards(options.threads));
  BuildReport report = pieces.write(outcome.output, std::move(decided), name, hash, progress);
  report.piece_seconds = seconds;
  return report;
}

void run(const Arguments& arguments) {
  const auto begin = Clock::now();
  Ranks ranks;
  const Wishes wishes = parse(arguments);
  if (ranks.count() > 1 && wishes.options.pieces < 2)
    throw Error(ErrorCode::kBadArgument, "mpirun started " + std::to_string(ranks.count()) +
                                             " processes, which can only share pieces of a mesh: give --pieces N");
  if (is_ptet_file(arguments.input)) {
    throw Error(ErrorCode::kBadInput,
                "'" + arguments.input + "' is a .ptet file already; 'ptet extract' gets meshes out of it");
  }
  BuildOutcome outcome;
  outcome.input = arguments.input;
  outcome.output = output_of(arguments);
  const std::string checkpoint = checkpoint_of(arguments, outcome.output);

  ProgressLine progress(arguments.quiet);
  const ProgressCallback callback = ranks.watching(progress.callback());
  progress.stage("reading");
  TetMesh mesh = read_mesh(arguments.input, &outcome.read, callback, wishes.options.memory_limit);
  note_values_of_cells(mesh, outcome.read);
  outcome.input_bytes = bytes_of(arguments.input, outcome.read);
  BuildOptions options = wishes.options;
  options.checkpoint.path = checkpoint;
  options.max_field_error = resolve_field_bounds("--max-field-error", wishes.max_field_error, names_of(mesh),
                                                 governing_names(mesh, options.fields, outcome.read.cell_arrays));
  if (wishes.target) options.target_vertices = target_of(*wishes.target, mesh.vertex_count());
  const std::string hash =
      ranks.is_first() ? hash_input(arguments.input, outcome.read.more_files, callback) : std::string();
  stop_if_interrupted();
  const std::string name = std::filesystem::path(arguments.input).filename().string();
  try {
    if (options.pieces > 1) {
      auto report = build_together(ranks, std::move(mesh), outcome, options, name, hash, callback);
      if (!report) return;
      outcome.build = std::move(*report);
    } else {
      outcome.build = build_file(std::move(mesh), outcome.output, options, name, hash, callback);
    }
  } catch (const Error& error) {
    std::error_code status;
    if (options.checkpoint.path.empty() || !std::filesystem::exists(options.checkpoint.path, status)) throw;
    const std::string how = "'" + *arguments.checkpoint + "'; the same command goes on from there with --resume";
    if (error.code() == ErrorCode::kCancelled) throw Interrupted("what was done is in " + how);
    // A full disk, as a rule: hours of work are not lost.
    if (error.code() == ErrorCode::kIo)
      throw Error(error.code(), error.what() + ("; what was done before is in " + how));
    throw;
  }
  outcome.options = std::move(options);
  outcome.build.total_seconds = seconds_since(begin); // reading included: it is what the user waited for
  outcome.info = open_dataset(outcome.output, std::numeric_limits<std::uint64_t>::max())->info();
  progress.erase();

  if (arguments.json) {
    print_json(outcome);
  } else if (!arguments.quiet) {
    print_text(outcome);
  }
}

constexpr const char* kExamples = R"(Examples:
  ptet build fire.vtu -o fire.ptet
  ptet build wing.vtu --field pressure --max-domain-error 0.5% --target-vertices 2%
  ptet build wing.vtu --max-field-error pressure=1%,velocity=5% --json > report.json
  ptet build wing.vtu --checkpoint wing.ckpt --checkpoint-every 10m
  ptet build wing.vtu --checkpoint wing.ckpt --checkpoint-every 10m --resume
  ptet build wing.vtu --pieces 16
  mpirun -n 4 ptet build wing.vtu --pieces 16

OUT is written beside its final name and renamed when it is whole: after a failure or Ctrl-C there is what was there
before. X% of a field error is of the field's range, X% of a domain error of the bounding-box diagonal; a plain X is in
the units of the field or of the mesh. Cells that are not tetrahedra are split into tetrahedra. Go on only from
checkpoints that you wrote: damage is found, but a forged one is trusted.
)";

/// The mesh, and how far down it is taken.
void add_mesh_and_limits(CLI::App& command, Arguments& arguments) {
  command.add_option("IN", arguments.input, "the mesh: .vtu, .pvtu, .vtk or Exodus")->required()->option_text(" ");
  command
      .add_option("-o,--output", arguments.output,
                  "the file to write; without it IN's name with .ptet,\n"
                  "in the current folder")
      ->option_text("OUT.ptet");
  command
      .add_option("--field", arguments.fields,
                  "a point array whose errors are measured and kept small;\n"
                  "repeatable; without it every floating-point array\n(every array when none is). All others are "
                  "carried along")
      ->allow_extra_args(false)
      ->option_text("NAME");
  command
      .add_option("--max-field-error", arguments.max_field_error,
                  "no collapse with a larger field error: X or X% for\n"
                  "every field, NAME=X or NAME=X% for one; repeatable,\nor with commas")
      ->allow_extra_args(false)
      ->option_text("X|NAME=X,...");
  command.add_option("--max-domain-error", arguments.max_domain_error, "no collapse with a larger one (2%)")
      ->option_text("X|X%");
  command.add_option("--target-vertices", arguments.target_vertices, "stop at so many vertices (1%)")
      ->option_text("N|N%");
  command
      .add_option("--min-quality", arguments.min_quality,
                  "no tet below this shape (1 regular, 0 flat), unless\n"
                  "its place had a worse one before (0.001; less for\nmeshes with flat parts)")
      ->option_text("Q");
}

/// How the next collapse is found.
void add_method(CLI::App& command, Arguments& arguments) {
  command
      .add_option("--method", arguments.method,
                  "exact, or one of the paper's LN, GN, QN, BF, BFS, or\n"
                  "staadt-gross or trotts, to compare with (exact)")
      ->option_text("NAME");
  command
      .add_option("--objective", arguments.objective,
                  "the field error that is kept small: max, rms or both\n(both); for exact, BF and BFS")
      ->option_text("WHAT");
  command
      .add_option("--predict", arguments.predict,
                  "what orders the collapses, instead of the method's:\n"
                  "exact, local, gradient, quadric, simulate,\nweighted-sum or per-tet")
      ->option_text("HOW");
  command
      .add_option(
          "--evaluate", arguments.evaluate,
          "where errors are measured, instead of the\n"
          "method's: exact (everywhere), samples (inside the\n"
          "original tets, and at removed vertices), vertices\n(these only: fast, and no bound in between) or none\n"
          "(as predicted); alone: with --predict quadric")
      ->option_text("HOW");
  command
      .add_option("--max-star", arguments.max_star,
                  "most tets and boundary faces around a vertex after\na collapse (64)")
      ->option_text("N");
}

/// How the build goes about it.
void add_run(CLI::App& command, Arguments& arguments) {
  command
      .add_option("--pieces", arguments.pieces,
                  "cut the mesh in N pieces, collapse one after the other,\n"
                  "then the seams and what is left together (1). The file\n"
                  "depends on N, not on how the pieces were collapsed:\n"
                  "one after the other, or by the processes of mpirun")
      ->option_text("N");
  command.add_flag("--weld", arguments.weld,
                   "first make one point of those that have the same place\n"
                   "and the same values, bit for bit: what the pieces of a\n"
                   ".pvtu share is otherwise a boundary");
  command
      .add_option("--weld-within", arguments.weld_within,
                  "the same, and what rounding has set apart: points of the\n"
                  "boundary no more than D apart, or D% of the diagonal,\n"
                  "with values as near, as a part of their range; D up to\n0.1%")
      ->option_text("D");
  command.add_flag("--keep-order", arguments.keep_order,
                   "also keep in what order points and cells stood, for\n"
                   "extract --input-order: some 2 bytes a vertex and up to 3\na tet more");
  command
      .add_option("--threads", arguments.threads,
                  "worker threads; 0: as many as the machine has (0).\nThe file does not depend on it")
      ->option_text("N");
  command
      .add_option("--memory-limit", arguments.memory_limit,
                  "refuse a build that would have more memory resident,\n"
                  "before it has: 8GB, 500MB or bytes (no limit)")
      ->option_text("N|NMB|NGB");
  command
      .add_option("--checkpoint", arguments.checkpoint,
                  "keep what was done in FILE from time to time, and on\n"
                  "Ctrl-C, SIGTERM or a lost terminal, to go on from\nafter an interruption; removed when OUT is "
                  "there.\nNot with --pieces")
      ->option_text("FILE");
  command
      .add_option("--checkpoint-every", arguments.checkpoint_every,
                  "how often: seconds, or with m or h (5m); in between\nrounds of collapses")
      ->option_text("N|Ns|Nm|Nh");
  command.add_flag("--resume", arguments.resume,
                   "go on from the checkpoint: OUT will be the same, byte\n"
                   "for byte, as without the interruption. Refused when\n"
                   "the mesh, the options (but --threads) or the program\nare not those of the checkpoint");
}

} // namespace

void add_build(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("build", "Simplify a mesh and write all its levels to one .ptet file");
  const auto arguments = std::make_shared<Arguments>();
  add_mesh_and_limits(*command, *arguments);
  add_method(*command, *arguments);
  add_run(*command, *arguments);
  command->add_flag("--force", arguments->force,
                    "write OUT even when its name is that of a mesh, or neither\nits name nor its contents are those "
                    "of a .ptet file");
  command->add_flag("--json", arguments->json, "the report as one JSON object");
  command->add_flag("-q,--quiet", arguments->quiet, "no report but that of --json, and no progress");
  command->footer(kExamples);
  command->callback([arguments] { run(*arguments); });
}

} // namespace ptet::cli
