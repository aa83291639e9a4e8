#include "build/report.hpp"

#include <algorithm>

namespace ptet::build {
namespace {

std::uint64_t deleted_tets(const RecordStream& records) {
  std::uint64_t count = 0;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const auto deleted = records.deleted(r);
    count += static_cast<std::uint64_t>(
        std::count_if(deleted.begin(), deleted.end(), [&](std::uint32_t slot) { return !records.is_ghost(slot); }));
  }
  return count;
}

/// The errors so far at the end of each round; certified ones are known only now.
void report_walk(const PreparedMesh& prepared, const RecordStream& records, std::vector<RoundReport>& walk) {
  RoundReport so_far;
  std::size_t r = 0;
  for (RoundReport& step : walk) {
    for (; r < prepared.used_vertex_count - step.vertices; ++r) {
      for (std::size_t f = 0; f < records.fields.size(); ++f)
        so_far.field_error = std::max(so_far.field_error, records.largest_error(r, f) / records.fields[f].scale());
      so_far.domain_error = std::max(so_far.domain_error, records.domain_error[r] / records.diagonal);
    }
    step.field_error = so_far.field_error;
    step.domain_error = so_far.domain_error;
  }
}

} // namespace

void report_records(const PreparedMesh& prepared, const RecordStream& records, BuildReport& report) {
  report.records = records.size();
  report.base_vertices = prepared.used_vertex_count - records.size();
  report.base_tets = records.original_tet_count - deleted_tets(records);
  for (std::size_t f = 0; f < records.fields.size(); ++f) {
    double worst = 0;
    for (std::size_t r = 0; r < records.size(); ++r)
      worst = std::max(worst, records.largest_error(r, f));
    report.field_error.emplace_back(prepared.mesh.point_arrays[records.fields[f].array].name, worst);
  }
  for (const double error : records.domain_error)
    report.domain_error = std::max(report.domain_error, error);
  report_walk(prepared, records, report.walk);
}

} // namespace ptet::build
