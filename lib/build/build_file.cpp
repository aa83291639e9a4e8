#include "build/builder.hpp"
#include "build/describe_options.hpp"
#include "build/memory_need.hpp"
#include "build/piece_decisions.hpp"
#include "build/process_memory.hpp"
#include "build/threads.hpp"
#include "formats/file_names.hpp"
#include "formats/ptet/manifest.hpp"
#include "formats/ptet/writer.hpp"
#include "formats/whole_file.hpp"
#include "mesh/prepare.hpp"
#include "mesh/topology.hpp"
#include "mesh/utf8.hpp"
#include "ptet/build.hpp"
#include "ptet/error.hpp"
#include "ptet/pieces_build.hpp"
#include "ptet/version.hpp"
#include "ptet/weld.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>

namespace ptet {
namespace {

static_assert(kMostVerticesToBuild <= file::kMaxFileVertices && kMostTetsToBuild <= file::kMaxFileTets &&
              kMostTetsToBuild <= kMaxTets);

using Bytes = std::vector<std::byte>;

/// All that goes into a file.
struct Built {
  TetMesh mesh; ///< prepared
  RecordStream records;
  file::Manifest manifest;
  std::optional<file::GivenIds> given; ///< where the order of the input is kept
};

/// The mesh as the collapses want it, where memory allows a build.
struct Begun {
  PreparedMesh prepared;
  std::vector<Tet> given_tets; ///< as they were given, where their order is kept
  std::uint64_t foreseen_memory_bytes = 0;
};
Begun begin(TetMesh mesh, const BuildOptions& options, const ProgressCallback& progress) {
  build::check_options(options);
  file::check_storable(mesh);
  const build::MemoryWatch memory(mesh, options);
  (void)memory.check(build::count(mesh, options)); // its boundary takes some more
  std::optional<std::uint64_t> welded;
  if (options.weld) {
    welded = weld_points(mesh, *options.weld, progress);
  }
  std::vector<Tet> given_tets = options.keep_order ? mesh.tets : std::vector<Tet>{};
  const auto prepared = [&] {
    try {
      return prepare(std::move(mesh), progress);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kBadInput || welded.value_or(0) == 0) throw;
      throw Error(error.code(), error.what() + std::string(" (once ") + welding_note(*welded, *options.weld) +
                                    "; numbers are those of the welded mesh)");
    }
  };
  Begun begun{build::Threads(options.threads).run(prepared), std::move(given_tets)};
  if (welded) begun.prepared.notes.insert(begun.prepared.notes.begin(), welding_note(*welded, *options.weld));
  build::release_freed_memory();
  begun.foreseen_memory_bytes = memory.check(build::count(begun.prepared, options));
  return begun;
}

/// `decided`: what was decided in pieces, or null.
Built collapse_all(Begun begun, const BuildOptions& options, const std::string& source_name,
                   const std::string& source_hash, BuildReport& report, const ProgressCallback& progress,
                   const build::Decisions* decided = nullptr) {
  PreparedMesh& prepared = begun.prepared;
  report.input_vertices = prepared.mesh.vertex_count();
  report.input_tets = prepared.mesh.tets.size();
  report.notes = prepared.notes;
  report.foreseen_memory_bytes = begun.foreseen_memory_bytes;
  Built built;
  built.records = build::build_records(prepared, options, report, progress, decided);

  built.manifest.tool_version = kVersion;
  built.manifest.source_name = as_utf8(source_name);
  built.manifest.source_hash = as_utf8(source_hash);
  built.manifest.options = build::describe_options(options, prepared, built.records.fields);
  built.manifest.notes = report.notes;
  if (options.keep_order) built.given = {std::move(prepared.original_vertex), std::move(begun.given_tets)};
  built.mesh = std::move(prepared.mesh);
  built.mesh.tets = std::vector<Tet>(); // the records have what is needed of them
  prepared = {};
  build::release_freed_memory();
  return built;
}

const file::GivenIds* given_ids(const Built& built) {
  return built.given ? &*built.given : nullptr;
}

std::uint64_t write_file(const std::string& path, Built built, const BuildOptions& options,
                         const ProgressCallback& progress) {
  return build::Threads(options.threads).run([&] {
    return file::write(path, std::move(built.mesh), std::move(built.records), built.manifest, progress,
                       given_ids(built));
  });
}

Bytes encode(Built built, const BuildOptions& options, const ProgressCallback& progress) {
  return build::Threads(options.threads).run([&] {
    return file::encode(std::move(built.mesh), std::move(built.records), built.manifest, progress, given_ids(built));
  });
}

class Stopwatch {
public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  /// What is known of a build once its file is written.
  void finish(BuildReport& report, std::uint64_t file_bytes) const {
    report.file_bytes = file_bytes;
    report.total_seconds = seconds();
    report.peak_memory_bytes = build::peak_resident_bytes();
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// What all pieces decide, one after the other.
std::vector<Bytes> decide_all(const PiecesBuild& pieces, const ProgressCallback& progress) {
  constexpr std::uint64_t kSteps = 1000; // a piece
  std::vector<Bytes> decided;
  for (std::uint32_t p = 0; p < pieces.piece_count(); ++p)
    decided.push_back(pieces.decide(p, [&](const Progress& of_piece) {
      const std::uint64_t steps = kSteps * of_piece.done / std::max<std::uint64_t>(1, of_piece.total);
      return !progress || progress({"collapsing pieces", p * kSteps + steps, pieces.piece_count() * kSteps});
    }));
  return decided;
}

/// Both passes; `write` is the second.
template <class Write>
auto build_over_pieces(TetMesh mesh, const BuildOptions& options, BuildReport& report, const ProgressCallback& progress,
                       Write&& write) {
  const Stopwatch all;
  PiecesBuild pieces(std::move(mesh), options, progress);
  const Stopwatch first_pass;
  std::vector<Bytes> decided = decide_all(pieces, progress);
  const double piece_seconds = first_pass.seconds();
  auto written = write(pieces, std::move(decided));
  report.piece_seconds = piece_seconds;
  report.total_seconds = all.seconds();
  return written;
}

} // namespace

struct PiecesBuild::Impl {
  Impl(TetMesh mesh, BuildOptions given, const ProgressCallback& progress)
      : options(std::move(given)), begun(begin(std::move(mesh), options, progress)),
        decisions(std::in_place, begun.prepared, options) {}

  /// The second pass.
  [[nodiscard]] Built finish(std::vector<Bytes> decided, const std::string& source_name, const std::string& source_hash,
                             BuildReport& report, const ProgressCallback& progress) {
    if (!decisions) throw Error(ErrorCode::kBadArgument, "the second pass of a build over pieces was made before");
    const build::Decisions all = decisions->merge(decided);
    decided = {};
    decisions.reset();
    return collapse_all(std::move(begun), options, source_name, source_hash, report, progress, &all);
  }

  BuildOptions options;
  Begun begun;
  std::optional<build::PieceDecisions> decisions; ///< until the second pass
};

PiecesBuild::PiecesBuild(TetMesh mesh, const BuildOptions& options, const ProgressCallback& progress)
    : impl_(std::make_unique<Impl>(std::move(mesh), options, progress)) {}
PiecesBuild::~PiecesBuild() = default;

std::uint32_t PiecesBuild::piece_count() const {
  return impl_->options.pieces;
}

void PiecesBuild::set_threads(unsigned threads) {
  impl_->options.threads = threads;
}

std::vector<std::byte> PiecesBuild::decide(std::uint32_t piece, const ProgressCallback& progress) const {
  if (!impl_->decisions || piece >= piece_count())
    throw Error(ErrorCode::kBadArgument, "there is no piece " + std::to_string(piece) + " to be collapsed");
  return impl_->decisions->decide(piece, progress);
}

BuildReport PiecesBuild::write(const std::string& path, std::vector<Bytes> decided, const std::string& source_name,
                               const std::string& source_hash, const ProgressCallback& progress) {
  const Stopwatch time;
  BuildReport report;
  Built built = impl_->finish(std::move(decided), source_name, source_hash, report, progress);
  time.finish(report, write_file(path, std::move(built), impl_->options, progress));
  return report;
}

std::vector<std::byte> PiecesBuild::write_memory(std::vector<Bytes> decided, BuildReport* report,
                                                 const std::string& source_name, const std::string& source_hash,
                                                 const ProgressCallback& progress) {
  const Stopwatch time;
  BuildReport own_report;
  BuildReport& filled = report != nullptr ? *report : own_report;
  filled = {};
  Built built = impl_->finish(std::move(decided), source_name, source_hash, filled, progress);
  std::vector<std::byte> bytes = encode(std::move(built), impl_->options, progress);
  time.finish(filled, bytes.size());
  return bytes;
}

BuildReport build_file(TetMesh mesh, const std::string& path, const BuildOptions& options,
                       const std::string& source_name, const std::string& source_hash,
                       const ProgressCallback& progress) {
  const std::string& checkpoint = options.checkpoint.path;
  if (!checkpoint.empty() && is_same_file(checkpoint, path))
    throw Error(ErrorCode::kBadArgument, "the checkpoint '" + checkpoint + "' is the file that is to be built");
  BuildReport report;
  if (options.pieces > 1) {
    build_over_pieces(std::move(mesh), options, report, progress, [&](PiecesBuild& pieces, std::vector<Bytes> decided) {
      report = pieces.write(path, std::move(decided), source_name, source_hash, progress);
      return report.file_bytes;
    });
    return report;
  }
  const Stopwatch time;
  Built built =
      collapse_all(begin(std::move(mesh), options, progress), options, source_name, source_hash, report, progress);
  time.finish(report, write_file(path, std::move(built), options, progress));
  // The file is there: a checkpoint that stays does no harm.
  if (std::error_code ignored; !checkpoint.empty()) std::filesystem::remove(checkpoint, ignored);
  return report;
}

std::vector<std::byte> build_memory(TetMesh mesh, const BuildOptions& options, BuildReport* report,
                                    const std::string& source_name, const std::string& source_hash,
                                    const ProgressCallback& progress) {
  BuildReport own_report;
  BuildReport& filled = report != nullptr ? *report : own_report;
  filled = {};
  if (options.pieces > 1)
    return build_over_pieces(
        std::move(mesh), options, filled, progress, [&](PiecesBuild& pieces, std::vector<Bytes> decided) {
          return pieces.write_memory(std::move(decided), &filled, source_name, source_hash, progress);
        });
  const Stopwatch time;
  Built built =
      collapse_all(begin(std::move(mesh), options, progress), options, source_name, source_hash, filled, progress);
  std::vector<std::byte> bytes = encode(std::move(built), options, progress);
  time.finish(filled, bytes.size());
  return bytes;
}

} // namespace ptet
