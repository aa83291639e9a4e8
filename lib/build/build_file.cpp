#include "build/builder.hpp"
#include "formats/ptet/manifest.hpp"
#include "formats/ptet/writer.hpp"
#include "mesh/prepare.hpp"
#include "ptet/build.hpp"
#include "ptet/version.hpp"

#include <charconv>
#include <chrono>

namespace ptet {
namespace {

std::string text_of(double value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

std::string text_of(const Bound& bound) {
  return bound.relative ? text_of(bound.value * 100) + "%" : text_of(bound.value);
}

/// The options as they were used; those that cannot change the result (threads) are left out.
std::vector<std::pair<std::string, std::string>> describe(const BuildOptions& options, const PreparedMesh& prepared,
                                                          const RecordStream& records) {
  std::vector<std::pair<std::string, std::string>> described;
  for (const GoverningField& field : records.fields)
    described.emplace_back("field", prepared.mesh.point_arrays[field.array].name);
  for (const FieldBound& bound : options.max_field_error)
    described.emplace_back("max-field-error", (bound.field.empty() ? "" : bound.field + "=") + text_of(bound.bound));
  described.emplace_back("max-domain-error", text_of(options.max_domain_error));
  described.emplace_back("target-vertices", text_of(options.target_vertices));
  described.emplace_back("min-quality", text_of(options.min_quality));
  described.emplace_back("predict", name_of(options.prediction));
  described.emplace_back("evaluate", name_of(options.evaluation));
  // Other predictions do not ask for it.
  if (options.prediction == Prediction::kSimulate || options.prediction == Prediction::kExact)
    described.emplace_back("objective", name_of(options.objective));
  described.emplace_back("max-star", std::to_string(options.max_star));
  described.emplace_back("round-fraction", text_of(options.round_fraction));
  return described;
}

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
  built.prepared = prepare(std::move(mesh));
  report.notes = built.prepared.notes;
  built.records = build::build_records(built.prepared, options, report, progress);

  built.manifest.tool_version = kVersion;
  built.manifest.source_name = source_name;
  built.manifest.source_hash = source_hash;
  built.manifest.options = describe(options, built.prepared, built.records);
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
