// ptet verify: that a .ptet file is what its specification says, and with the original that nothing of it was lost.
#include "blocks.hpp"
#include "commands.hpp"
#include "compare.hpp"
#include "console.hpp"
#include "files.hpp"
#include "formats/ptet/reader.hpp"
#include "formats/vtk/read.hpp"
#include "mesh/predicates.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ptet::cli {
namespace {

struct Arguments {
  std::string input;
  std::optional<std::string> original;
  bool json = false;
};

/// How often one thing was found wrong, and the id of the first.
class Tally {
public:
  explicit Tally(std::string what) : what_(std::move(what)) {}
  void add(std::uint64_t id) {
    if (count_++ == 0) first_ = id;
  }
  void report(Findings& findings) const {
    if (count_ == 0) return;
    findings.wrong.push_back(what_ + ": " + grouped(count_) + ", the first is " + std::to_string(first_));
  }

private:
  std::string what_;
  std::uint64_t count_ = 0;
  std::uint64_t first_ = 0;
};

/// What was looked at, for the report.
struct Extent {
  std::uint64_t blocks = 0;
  std::uint64_t records = 0;
  std::uint64_t versions = 0;
};

Point position(const file::Content& content, VertexId v) {
  const PointArray& table = content.positions;
  return {table.value(v.index(), 0), table.value(v.index(), 1), table.value(v.index(), 2)};
}

int orientation_of(const file::Content& content, const Tet& tet) {
  return orientation(position(content, tet[0]), position(content, tet[1]), position(content, tet[2]),
                     position(content, tet[3]));
}

/// The errors and order codes that a cut relies on: a record's monotone error is at least its own, and at most its
/// parents', as its order code is, so that a threshold alone is a closed cut; a block's is the largest of its records'.
void check_errors(const file::Reader& reader, const file::Content& content, Findings& findings) {
  Tally below_own("records whose monotone error is below their own");
  Tally above_parent("records whose monotone error is above a parent's");
  Tally order_above_parent("records whose order code is above a parent's");
  Tally not_after_parent("records whose generation is not after a parent's");
  Tally wrong_maximum("blocks whose largest error is not that of their records");
  Tally wrong_order("blocks whose largest order code is not that of their records");
  Tally unknown_need("blocks that hold a record with a parent in a block they do not name");
  const std::size_t columns = content.errors_per_record;
  const auto& blocks = reader.blocks();
  for (std::uint32_t b = 0; b < blocks.size(); ++b) {
    const file::BlockInfo& block = blocks[b];
    std::vector<ErrorCode16> largest(columns, 0);
    OrderCode largest_order = 0;
    bool needs_named = true;
    for (std::uint32_t r = block.first_record; r < block.first_record + block.record_count; ++r) {
      const ErrorCode16* const own = content.own.data() + r * columns;
      const ErrorCode16* const monotone = content.monotone.data() + r * columns;
      bool own_ok = true, parents_ok = true, collapses_ok = true, order_ok = true;
      largest_order = std::max(largest_order, content.order[r]);
      for (std::size_t c = 0; c < columns; ++c) {
        own_ok = own_ok && monotone[c] >= own[c];
        largest[c] = std::max(largest[c], monotone[c]);
      }
      for (const RecordId parent : content.refinement.parents(RecordId{r})) {
        const ErrorCode16* const above = content.monotone.data() + parent.index() * columns;
        for (std::size_t c = 0; c < columns; ++c)
          parents_ok = parents_ok && above[c] >= monotone[c];
        collapses_ok = collapses_ok && content.order[parent.index()] >= content.order[r];
        order_ok = order_ok && content.generation[parent.index()] < content.generation[r];
        const std::uint32_t home = block_of(blocks, parent);
        needs_named = needs_named && (home == b || std::binary_search(block.needs.begin(), block.needs.end(), home));
      }
      if (!own_ok) below_own.add(r);
      if (!parents_ok) above_parent.add(r);
      if (!collapses_ok) order_above_parent.add(r);
      if (!order_ok) not_after_parent.add(r);
    }
    if (block.max_error != largest) wrong_maximum.add(b);
    if (block.max_order != largest_order) wrong_order.add(b);
    if (!needs_named) unknown_need.add(b);
  }
  for (const Tally* tally : {&below_own, &above_parent, &order_above_parent, &not_after_parent, &wrong_maximum,
                             &wrong_order, &unknown_need}) {
    tally->report(findings);
  }
}

/// A focus reads the blocks whose box it meets: no star of a record may lie outside its block's box.
void check_boxes(const file::Reader& reader, const file::Content& content, Findings& findings) {
  Tally outside("blocks whose box does not hold the stars of their records");
  const Refinement& refinement = content.refinement;
  for (std::uint32_t b = 0; b < reader.blocks().size(); ++b) {
    const file::BlockInfo& block = reader.blocks()[b];
    bool inside = true;
    for (std::uint32_t r = block.first_record; inside && r < block.first_record + block.record_count; ++r) {
      const std::uint32_t first = refinement.first_fine(RecordId{r}).index();
      for (std::uint32_t t = first; t < first + refinement.fine_count(RecordId{r}); ++t) {
        for (const VertexId v : refinement.vertices(VersionId{t})) {
          if (v == kDummyVertex) continue;
          const Point p = position(content, v);
          for (std::size_t axis = 0; axis < 3; ++axis) {
            inside = inside && p[axis] >= block.box_min[axis] && p[axis] <= block.box_max[axis];
          }
        }
      }
    }
    if (!inside) outside.add(b);
  }
  outside.report(findings);
}

/// The fine version that became the coarse version `t` in the collapse of `record`; none when there is none.
VersionId fine_of(const Refinement& refinement, VersionId t, RecordId record) {
  Tet wanted = refinement.vertices(t);
  std::replace(wanted.begin(), wanted.end(), refinement.target(record), refinement.vertex_of(record));
  std::sort(wanted.begin(), wanted.end());
  const std::uint32_t first = refinement.first_fine(record).index();
  for (std::uint32_t fine = first; fine < first + refinement.fine_count(record); ++fine) {
    Tet corners = refinement.vertices(VersionId{fine});
    std::sort(corners.begin(), corners.end());
    if (corners == wanted) return VersionId{fine};
  }
  return {};
}

/// Every tet of every level is positively oriented, exactly. Flat ones of the original are tolerated, and with them
/// what they become; never anything inverted, and nothing flat that comes from a tet that was not.
void check_orientations(const file::Content& content, Findings& findings) {
  Tally inverted("inverted tets (versions)");
  Tally flat("flat tets (versions) that come from tets that are not flat");
  std::uint64_t flat_originals = 0;
  const Refinement& refinement = content.refinement;
  for (std::uint32_t t = 0; t < refinement.version_count(); ++t) {
    if (t % 65536 == 0) stop_if_interrupted();
    if (refinement.is_ghost(VersionId{t})) continue;
    const RecordId creator = refinement.creator(VersionId{t});
    const int sign = orientation_of(content, refinement.vertices(VersionId{t}));
    if (sign > 0) continue;
    if (creator.is_none()) { // an original tet; what orientation a flat one has is for its neighbours to say
      sign < 0 ? inverted.add(t) : static_cast<void>(++flat_originals);
    } else if (sign < 0) {
      inverted.add(t);
    } else {
      const VersionId before = fine_of(refinement, VersionId{t}, creator);
      if (before.is_none() || orientation_of(content, refinement.vertices(before)) != 0) flat.add(t);
    }
  }
  inverted.report(findings);
  flat.report(findings);
  if (flat_originals > 0) findings.notes.push_back(counted(flat_originals, "flat tet") + " in the original");
}

/// All that is finest: the mesh that was built from, in the file's numbering.
TetMesh full_mesh(const file::Content& content) {
  TetMesh mesh;
  mesh.positions = content.positions;
  mesh.point_arrays = content.arrays;
  const Refinement& refinement = content.refinement;
  for (std::uint32_t t = 0; t < refinement.version_count(); ++t) {
    if (!refinement.is_ghost(VersionId{t}) && refinement.creator(VersionId{t}).is_none()) {
      mesh.tets.push_back(refinement.vertices(VersionId{t}));
    }
  }
  return mesh;
}

/// Everything that can be known from the file alone; returns its full mesh.
TetMesh check_file(file::Reader& reader, ProgressLine& progress, Findings& findings, Extent& extent) {
  progress.stage("loading");
  file::Content content = reader.read_base();
  std::vector<std::uint32_t> blocks;
  for (std::uint32_t b = 0; b < reader.blocks().size(); ++b)
    blocks.push_back(b);
  reader.load(blocks, content);
  extent = {blocks.size(), content.refinement.record_count(), content.refinement.version_count()};

  progress.stage("checking the structure");
  const std::string broken = content.refinement.validate();
  if (!broken.empty()) {
    findings.wrong.push_back("structure: " + broken);
    return {};
  }
  if (content.refinement.applied_count() != content.refinement.record_count()) {
    findings.wrong.push_back(
        "structure: " + grouped(content.refinement.record_count() - content.refinement.applied_count()) +
        " records are in no block");
    return {};
  }
  check_errors(reader, content, findings);
  check_boxes(reader, content, findings);
  progress.stage("checking orientations");
  check_orientations(content, findings);
  TetMesh full = full_mesh(content);
  if (full.tets.size() != reader.header().tet_count) {
    findings.wrong.push_back("full refinement has " + counted(full.tets.size(), "tet") + ", the header says " +
                             grouped(reader.header().tet_count));
  }
  return full;
}

void check_original(const Arguments& arguments, const file::Reader& reader, const TetMesh& full, ProgressLine& progress,
                    Findings& findings) {
  progress.stage("reading the original");
  const TetMesh original = read_mesh(*arguments.original, nullptr, progress.callback());
  const std::string& expected = reader.manifest().source_hash;
  if (!expected.empty() && hash_file(*arguments.original, progress.callback()) != expected) {
    findings.notes.push_back("'" + *arguments.original +
                             "' is not byte for byte the file that was built from; its contents are compared");
  }
  progress.stage("comparing");
  compare_meshes(original, full, findings);
}

void report(const Arguments& arguments, const Findings& findings, const Extent& extent) {
  if (arguments.json) {
    Json json;
    json["file"] = arguments.input;
    json["original"] = arguments.original ? Json(*arguments.original) : Json(nullptr);
    json["ok"] = findings.wrong.empty();
    json["wrong"] = findings.wrong;
    json["notes"] = findings.notes;
    json["blocks"] = extent.blocks;
    json["records"] = extent.records;
    json["versions"] = extent.versions;
    print(json);
  } else {
    std::cout << arguments.input << '\n';
    for (const std::string& wrong : findings.wrong)
      std::cout << "  wrong     " << wrong << '\n';
    for (const std::string& note : findings.notes)
      std::cout << "  note      " << note << '\n';
    std::cout << "  checked   " << counted(extent.blocks, "block") << ", " << counted(extent.records, "record") << ", "
              << counted(extent.versions, "version") << '\n';
    if (findings.wrong.empty()) {
      std::cout << "  sound" << (arguments.original ? ", and full refinement equals the original" : "") << '\n';
    }
  }
  std::cout.flush();
}

void run(const Arguments& arguments) {
  if (!is_ptet_file(arguments.input)) {
    throw Error(ErrorCode::kCorruptFile, "'" + arguments.input + "' is not a .ptet file");
  }
  ProgressLine progress;
  Findings findings;
  Extent extent;
  try {
    file::Reader reader(file::open_file(arguments.input));
    const TetMesh full = check_file(reader, progress, findings, extent);
    if (arguments.original && findings.wrong.empty()) check_original(arguments, reader, full, progress, findings);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruptFile) throw;
    findings.wrong.emplace_back(error.what());
  }
  stop_if_interrupted();
  progress.erase();
  report(arguments, findings, extent);
  if (!findings.wrong.empty()) {
    throw Error(ErrorCode::kCorruptFile, "'" + arguments.input + "' failed verification: " + findings.wrong.front());
  }
}

constexpr const char* kExamples = R"(Examples:
  ptet verify fire.ptet
  ptet verify fire.ptet --original fire.vtu

Reads everything: hashes, table, all records. Checks that the records fit together, that errors and order
codes never fall short of those of finer records, and, exactly, that no tet of any level is inverted. With --original: that full refinement gives
the same vertices, positions and values bit for bit, and the same tets; their order may differ, and inverted tets of the
original are turned. Exit code 4 when anything is wrong.
)";

} // namespace

void add_verify(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("verify", "Check a .ptet file, and that it gives back the original");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("FILE", arguments->input, "the .ptet file")->required()->option_text(" ");
  command->add_option("--original", arguments->original, "the mesh it was built from")->option_text("MESH");
  command->add_flag("--json", arguments->json, "the findings as one JSON object");
  command->footer(kExamples);
  command->callback([arguments] { run(*arguments); });
}

} // namespace ptet::cli
