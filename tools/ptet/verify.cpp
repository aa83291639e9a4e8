// ptet verify: that a .ptet file is what its specification says, that its errors are true, and with the original that
// nothing of it was lost. Everything that is wrong is said, not only what comes first.
#include "arguments.hpp"
#include "build/threads.hpp"
#include "commands.hpp"
#include "compare.hpp"
#include "console.hpp"
#include "files.hpp"
#include "formats/ptet/stated_errors.hpp"
#include "formats/ptet/verification.hpp"
#include "formats/vtk/read.hpp"
#include "lod/input_order.hpp"
#include "plain_output.hpp"
#include "ptet/error.hpp"
#include "ptet/weld.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ptet::cli {
namespace {

/// Of one kind so many are printed, and so many kept for JSON; all are counted.
constexpr std::size_t kMostPrinted = 5;
constexpr std::size_t kMostKept = 1000;
constexpr std::uint64_t kDefaultSamples = 1000;

struct Arguments {
  std::string input;
  std::optional<std::string> original;
  std::optional<std::string> samples;
  bool json = false;
};

/// What is wrong, by kind: what differs in nothing but numbers is of one kind.
class Wrongs {
public:
  struct Kind {
    std::uint64_t count = 0;
    std::vector<file::Violation> first; ///< kMostKept at most
  };

  void add(const file::Violation& violation) {
    std::string key;
    for (const char c : violation.what)
      if (std::isdigit(static_cast<unsigned char>(c)) == 0) key += c;
    const auto [found, is_new] = place_.emplace(key, kinds_.size());
    if (is_new) kinds_.emplace_back();
    Kind& kind = kinds_[found->second];
    ++total_;
    if (++kind.count <= kMostKept) kind.first.push_back(violation);
  }
  [[nodiscard]] std::uint64_t total() const { return total_; }
  /// In the order in which they were met.
  [[nodiscard]] const std::vector<Kind>& kinds() const { return kinds_; }

private:
  std::map<std::string, std::size_t> place_;
  std::vector<Kind> kinds_;
  std::uint64_t total_ = 0;
};

/// With the place, as far as it is known.
std::string text_of(const file::Violation& violation) {
  std::string place;
  const auto add = [&](const char* what, std::uint64_t number) {
    place += (place.empty() ? "" : ", ") + std::string(what) + " " + std::to_string(number);
  };
  if (violation.version) add("version", *violation.version);
  if (violation.record) add("record", *violation.record);
  if (violation.block) add("block", *violation.block);
  if (violation.offset) add("byte", *violation.offset);
  return place.empty() ? violation.what : violation.what + " (" + place + ")";
}

Json json_of(const file::Violation& violation) {
  Json json;
  json["what"] = violation.what;
  const auto add = [&](const char* name, const auto& number) { json[name] = number ? Json(*number) : Json(nullptr); };
  add("offset", violation.offset);
  add("block", violation.block);
  add("record", violation.record);
  add("version", violation.version);
  return json;
}

/// All that there is to say in the end.
struct Outcome {
  Wrongs wrongs;
  std::vector<std::string> notes;
  std::uint64_t blocks = 0, decoded_blocks = 0, records = 0, versions = 0;
  std::optional<file::StatedErrors> errors;

  [[nodiscard]] file::Violations teller() {
    return [this](const file::Violation& violation) { wrongs.add(violation); };
  }
};

/// 0: all.
std::uint64_t samples_of(const Arguments& arguments) {
  if (!arguments.samples) return kDefaultSamples;
  if (*arguments.samples == "all") return 0;
  if (arguments.samples->find_first_not_of("0123456789") != std::string::npos)
    throw Error(ErrorCode::kBadArgument, "--samples '" + *arguments.samples + "': a whole number is wanted, or all");
  return parse_whole("--samples", *arguments.samples, 1, std::uint64_t{1} << 32);
}

/// Everything that can be known from the file alone.
file::Verified check_file(const Arguments& arguments, std::uint64_t samples, const ProgressCallback& progress,
                          Outcome& outcome) {
  file::Verified verified =
      file::verify(file::open_file(arguments.input), outcome.teller(), progress, machine_limits());
  outcome.notes = verified.notes;
  if (verified.reader) outcome.blocks = verified.reader->blocks().size();
  outcome.decoded_blocks = verified.decoded.size();
  if (verified.content) {
    outcome.records = verified.content->refinement.applied_count();
    outcome.versions = verified.content->refinement.version_count();
  }
  if (!verified.is_whole() || !verified.is_oriented) {
    outcome.notes.emplace_back("the stated errors were not measured");
    return verified;
  }
  try {
    outcome.errors = file::check_stated_errors(verified, samples, outcome.teller(), progress);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBadInput) throw;
    outcome.notes.push_back(std::string("the stated errors were not measured: ") + error.what());
  }
  return verified;
}

void weld_as_in_build(const Bound& within, TetMesh& original, ProgressLine& progress, Outcome& outcome) {
  try {
    outcome.notes.push_back("as in the build, " +
                            welding_note(weld_points(original, within, progress.callback()), within));
  } catch (const Error& error) { // the distance is that of another mesh, or none
    if (error.code() != ErrorCode::kBadArgument) throw;
    outcome.wrongs.add({std::string("the original cannot be welded as in the build: ") + error.what(), {}, {}, {}, {}});
  }
}

void check_original(const Arguments& arguments, const file::Verified& verified, ProgressLine& progress,
                    Outcome& outcome) {
  if (!verified.is_whole()) {
    outcome.notes.emplace_back("the original was not compared, as not all of the file could be decoded");
    return;
  }
  progress.stage("reading the original");
  ReadReport read;
  TetMesh original = read_mesh(*arguments.original, &read, progress.callback());
  add_reading_notes(*arguments.original, read, outcome.notes);
  if (const auto within = verified.reader->manifest().welded_within())
    weld_as_in_build(*within, original, progress, outcome);
  const std::string& expected = verified.reader->manifest().source_hash;
  if (!expected.empty() && hash_input(*arguments.original, read.more_files, progress.callback()) != expected) {
    outcome.notes.push_back("'" + *arguments.original +
                            "' is not byte for byte the file that was built from; its contents are compared");
  }
  progress.stage("comparing");
  Findings findings;
  Extraction restored;
  restored.mesh = file::finest_mesh(*verified.content);
  compare_meshes(original, restored.mesh, findings);
  for (const std::string& wrong : findings.wrong)
    outcome.wrongs.add({wrong, {}, {}, {}, {}});
  outcome.notes.insert(outcome.notes.end(), findings.notes.begin(), findings.notes.end());
  if (!verified.reader->header().has_input_order) return;
  if (outcome.wrongs.total() > 0) {
    outcome.notes.emplace_back("the order that is kept was not compared, as the rest is not sound");
    return;
  }
  for (std::uint32_t v = 0; v < restored.mesh.vertex_count(); ++v)
    restored.vertex_in_file.emplace_back(v);
  put_in_input_order(restored, verified.reader->read_input_order());
  const TetMesh& ordered = restored.mesh;
  const auto is_as_it_was = [&](const PointArray& array) {
    const PointArray* const was = original.find(array.name);
    return was != nullptr && *was == array;
  };
  if (ordered.positions.bytes != original.positions.bytes || ordered.tets != original.tets ||
      !std::all_of(ordered.point_arrays.begin(), ordered.point_arrays.end(), is_as_it_was))
    outcome.wrongs.add({"the order that is kept is not that of the original", {}, {}, {}, {}});
}

Json json_of(const file::StatedErrors& errors) {
  Json json;
  json["records"] = errors.records;
  json["versions"] = errors.versions;
  json["are_bounds"] = errors.are_bounds;
  json["by_name"] = Json::object();
  for (const file::StatedError& error : errors.errors)
    json["by_name"][error.name] = {
        {"above", error.above},
        {"largest_measured", error.most},
        {"largest_ratio_above", std::isfinite(error.most_above) ? Json(error.most_above) : Json("infinite")}};
  return json;
}

void report_json(const Arguments& arguments, const Outcome& outcome) {
  Json json;
  json["file"] = arguments.input;
  json["original"] = arguments.original ? Json(*arguments.original) : Json(nullptr);
  json["ok"] = outcome.wrongs.total() == 0;
  json["wrong_count"] = outcome.wrongs.total();
  json["wrong"] = Json::array();    // a sentence for each kind, with its number and the first place
  json["findings"] = Json::array(); // each of them, of one kind the first kMostKept
  for (const Wrongs::Kind& kind : outcome.wrongs.kinds()) {
    json["wrong"].push_back(text_of(kind.first.front()) +
                            (kind.count > 1 ? ", and " + grouped(kind.count - 1) + " more of this kind" : ""));
    for (const file::Violation& violation : kind.first)
      json["findings"].push_back(json_of(violation));
  }
  json["notes"] = outcome.notes;
  json["blocks"] = outcome.blocks;
  json["decoded_blocks"] = outcome.decoded_blocks;
  json["records"] = outcome.records;
  json["versions"] = outcome.versions;
  json["stated_errors"] = outcome.errors ? json_of(*outcome.errors) : Json(nullptr);
  print(json);
}

void print_errors(const file::StatedErrors& errors, std::uint64_t records) {
  std::cout << "  measured  errors of " << grouped(errors.records) << " of " << counted(records, "record") << '\n';
  for (const file::StatedError& error : errors.errors) {
    std::cout << "  error     " << on_one_line(error.name) << " measured up to " << brief(error.most);
    if (error.above > 0)
      std::cout << "; above the stated one in " << counted(error.above, "record") << ", up to "
                << brief(error.most_above) << " times" << (errors.are_bounds ? "" : " (which is no bound)");
    std::cout << '\n';
  }
}

void report_text(const Arguments& arguments, const Outcome& outcome) {
  std::cout << arguments.input << '\n';
  for (const Wrongs::Kind& kind : outcome.wrongs.kinds()) {
    const std::size_t printed = std::min<std::size_t>(kind.first.size(), kMostPrinted);
    for (std::size_t i = 0; i < printed; ++i)
      std::cout << "  wrong     " << on_one_line(text_of(kind.first[i])) << '\n';
    if (kind.count > printed)
      std::cout << "            and " << grouped(kind.count - printed) << " more of this kind\n";
  }
  for (const std::string& note : outcome.notes)
    std::cout << "  note      " << on_one_line(note) << '\n';
  std::cout << "  checked   " << counted(outcome.decoded_blocks, "block");
  if (outcome.decoded_blocks != outcome.blocks) std::cout << " of " << grouped(outcome.blocks);
  std::cout << ", " << counted(outcome.records, "record") << ", " << counted(outcome.versions, "version") << '\n';
  if (outcome.errors) print_errors(*outcome.errors, outcome.records);
  if (outcome.wrongs.total() == 0)
    std::cout << "  sound" << (arguments.original ? ", and full refinement equals the original" : "") << '\n';
  else
    std::cout << "  not sound: " << counted(outcome.wrongs.total(), "finding") << '\n';
}

void run(const Arguments& arguments) {
  const std::uint64_t samples = samples_of(arguments);
  if (!is_ptet_file(arguments.input)) {
    throw Error(ErrorCode::kCorruptFile, "'" + arguments.input + "' is not a .ptet file");
  }
  ProgressLine progress;
  Outcome outcome;
  build::Threads(0).run([&] {
    const file::Verified verified = check_file(arguments, samples, progress.callback(), outcome);
    if (arguments.original) check_original(arguments, verified, progress, outcome);
  });
  stop_if_interrupted();
  progress.erase();
  arguments.json ? report_json(arguments, outcome) : report_text(arguments, outcome);
  std::cout.flush();
  if (const std::uint64_t count = outcome.wrongs.total(); count > 0) {
    throw Error(ErrorCode::kCorruptFile, "'" + arguments.input + "' failed verification, with " +
                                             counted(count, "finding") +
                                             "; the first: " + text_of(outcome.wrongs.kinds().front().first.front()));
  }
}

constexpr const char* kExamples = R"(Examples:
  ptet verify fire.ptet
  ptet verify fire.ptet --original fire.vtu
  ptet verify fire.ptet --samples all --json

Reads everything, and lists all that it finds wrong, with record, block and byte; of one kind the first few, and how
many there are. Looked at: all hashes; every rule of the format, of its parts and of how they fit together; that errors
and order codes never fall short of those of finer records; exactly, that no tet of any level is inverted; and some of
the stated errors, which are measured once more: a field error over all of each tet, a domain error by how far a face is
from the original boundary. Errors that the builder did not evaluate exactly are no bounds, and may be passed. What lies
behind damage that cannot be read past is not looked at, and that is said. With --original: that full refinement gives
the same vertices, positions and values bit for bit, and the same tets; their order may differ, and inverted tets of the
original are turned, but where the file keeps the order of its input: then all comes out as it was read. Exit code 4
when anything is wrong.

Findings name records as they are numbered in the file, and versions, which are the tets and boundary faces of all
levels, from 0 on in this order: those of the coarsest mesh, then what each record's split brings back, record by
record.
)";

} // namespace

void add_verify(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("verify", "Check a .ptet file, and that it gives back the original");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("FILE", arguments->input, "the .ptet file")->required()->option_text(" ");
  command->add_option("--original", arguments->original, "the mesh it was built from")->option_text("MESH");
  command->add_option("--samples", arguments->samples, "of how many records the errors are measured (1000)")
      ->option_text("N|all");
  command->add_flag("--json", arguments->json, "the findings as one JSON object");
  command->footer(kExamples);
  command->callback([arguments] { run(*arguments); });
}

} // namespace ptet::cli
