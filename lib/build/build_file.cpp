#include "build/builder.hpp"
#include "build/describe_options.hpp"
#include "formats/ptet/manifest.hpp"
#include "formats/ptet/writer.hpp"
#include "mesh/prepare.hpp"
#include "ptet/build.hpp"
#include "ptet/version.hpp"

#include <chrono>
#include <filesystem>

namespace ptet {
namespace {

/// All that goes into a file, and the report of how it was made.
struct Built {
  PreparedMesh prepared;
  RecordStream records;
  file::Manifest manifest;
};

Built collapse_all(TetMesh mesh, const BuildOptions& options, const std::string& source_name,
                   const std::string& source_hash, BuildReport& report, const ProgressCallback& progress) {
  report.input_vertices = mesh.vertex_count();
  report.input_tets = mesh.tets.size();
  Built built;
  built.prepared = prepare(std::move(mesh), progress);
  report.notes = built.prepared.notes;
  built.records = build::build_records(built.prepared, options, report, progress);

  built.manifest.tool_version = kVersion;
  built.manifest.source_name = source_name;
  built.manifest.source_hash = source_hash;
  built.manifest.options = build::describe_options(options, built.prepared, built.records.fields);
  built.manifest.notes = report.notes;
  return built;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

BuildReport build_file(TetMesh mesh, const std::string& path, const BuildOptions& options,
                       const std::string& source_name, const std::string& source_hash,
                       const ProgressCallback& progress) {
  const auto start = std::chrono::steady_clock::now();
  BuildReport report;
  const Built built = collapse_all(std::move(mesh), options, source_name, source_hash, report, progress);
  report.file_bytes = file::write(path, built.prepared.mesh, built.records, built.manifest, progress);
  if (!options.checkpoint.path.empty()) std::filesystem::remove(options.checkpoint.path);
  report.total_seconds = seconds_since(start);
  return report;
}

std::vector<std::byte> build_memory(TetMesh mesh, const BuildOptions& options, BuildReport* report,
                                    const std::string& source_name, const std::string& source_hash,
                                    const ProgressCallback& progress) {
  const auto start = std::chrono::steady_clock::now();
  BuildReport own_report;
  BuildReport& filled = report != nullptr ? *report : own_report;
  filled = {};
  const Built built = collapse_all(std::move(mesh), options, source_name, source_hash, filled, progress);
  std::vector<std::byte> bytes = file::encode(built.prepared.mesh, built.records, built.manifest, progress);
  filled.file_bytes = bytes.size();
  filled.total_seconds = seconds_since(start);
  return bytes;
}

} // namespace ptet
