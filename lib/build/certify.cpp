#include "build/certify.hpp"

#include "ptet/error.hpp"

#include <algorithm>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::build {
namespace {

/// What rounding can hide of an error: a fraction of it, and of the range.
constexpr double kRelativeSlack = 1e-9;
constexpr double kAbsoluteSlack = 1e-13;
/// Records between two reports of progress.
constexpr std::size_t kBatch = 4096;

bool is_ghost(const Tet& tet) {
  return std::find(tet.begin(), tet.end(), kDummyVertex) != tet.end();
}

} // namespace

double certified(double measured) {
  return measured > kAbsoluteSlack ? measured * (1 + kRelativeSlack) : 0;
}

void certify_field_errors(const PreparedMesh& prepared, const NormalizedFields& fields, RecordStream& records,
                          const ProgressCallback& progress) {
  const std::size_t field_count = fields.field_count();
  if (field_count == 0 || records.size() == 0) return;
  const ExactFieldError exact(prepared, fields.view());
  oneapi::tbb::enumerable_thread_specific<ExactFieldError::Workspace> workspaces(
      [&] { return ExactFieldError::Workspace(exact); });
  const auto certify = [&](std::size_t record, ExactFieldError::Workspace& workspace) {
    double* const stated = records.field_error.data() + record * field_count;
    std::vector<double> errors(field_count);
    // What was seen at removed vertices stands: of those outside the version the measurement knows nothing.
    for (std::size_t f = 0; f < field_count; ++f)
      errors[f] = stated[f] / fields.fields()[f].range;
    const std::uint32_t first = records.coarse_begin[record].index();
    for (std::uint32_t t = first; t < first + records.modified_count[record]; ++t)
      if (!is_ghost(records.versions[t])) exact.measure(records.versions[t], workspace, errors);
    for (std::size_t f = 0; f < field_count; ++f) {
      stated[f] = std::max(stated[f], certified(errors[f]) * fields.fields()[f].range);
    }
  };
  for (std::size_t begin = 0; begin < records.size(); begin += kBatch) {
    if (progress && !progress({"certifying errors", begin, records.size()}))
      throw Error(ErrorCode::kCancelled, "the build was cancelled");
    const oneapi::tbb::blocked_range<std::size_t> batch(begin, std::min(begin + kBatch, records.size()), 16);
    oneapi::tbb::parallel_for(batch, [&](const auto& range) {
      auto& workspace = workspaces.local();
      for (std::size_t record = range.begin(); record != range.end(); ++record)
        certify(record, workspace);
    });
  }
}

} // namespace ptet::build
