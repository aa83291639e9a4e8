#include "build/certify.hpp"

#include "build/mesh_scales.hpp"
#include "error/tolerances.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::build {
namespace {

/// Records between two reports of progress.
constexpr std::size_t kCertifyBatch = 1024;
constexpr std::uint32_t kNoConsumer = std::numeric_limits<std::uint32_t>::max();

bool is_ghost(const Tet& tet) {
  return std::find(tet.begin(), tet.end(), kDummyVertex) != tet.end();
}

/// The versions before this one are original.
std::uint32_t first_made(const RecordStream& records) {
  return records.original_tet_count + records.original_ghost_count;
}

/// By version from `first_made` on: the record that consumed it, or kNoConsumer.
std::vector<std::uint32_t> consumers(const RecordStream& records) {
  const std::uint32_t first = first_made(records);
  std::vector<std::uint32_t> consumer(records.versions.size() - first, kNoConsumer);
  for (std::uint32_t r = 0; r < records.size(); ++r)
    for (const VersionId t : records.consumed(r))
      if (t.index() >= first) consumer[t.index() - first] = r;
  return consumer;
}

/// What a collapse adds to the volume of the mesh; 0 where that may be rounding.
double volume_added(const PreparedMesh& prepared, const RecordStream& records, std::size_t record) {
  if (!records.moves_boundary(record)) return 0;
  double before = 0, after = 0;
  for (const VersionId t : records.consumed(record))
    if (const Tet& tet = records.versions[t.index()]; !is_ghost(tet)) before += volume_of(prepared, tet);
  const std::uint32_t first = records.coarse_begin[record].index();
  for (std::uint32_t t = first; t < first + records.modified_count[record]; ++t)
    if (!is_ghost(records.versions[t])) after += volume_of(prepared, records.versions[t]);
  return volume_change(before, after);
}

} // namespace

double certified(double measured) {
  return measured * (1 + kErrorSlack);
}

std::vector<double> squared_scales(const NormalizedFields& fields, double volume) {
  std::vector<double> scales;
  scales.reserve(fields.field_count());
  for (const GoverningField& field : fields.fields())
    scales.push_back(holds_squares(field.range, volume) ? field.range * field.range : 1);
  return scales;
}

void certify_field_errors(const PreparedMesh& prepared, const NormalizedFields& fields, RecordStream& records,
                          const ProgressCallback& progress, std::uint64_t* certified_before) {
  std::uint64_t none = 0;
  std::uint64_t& done = certified_before != nullptr ? *certified_before : none;
  const std::size_t field_count = fields.field_count();
  if (done == 0) {
    records.squared_error.assign(records.size() * field_count, 0.0);
    records.uncovered_volume.assign(records.size(), 0.0);
  }
  if (records.size() == 0) return;
  const ExactFieldError exact(prepared, fields.view());
  oneapi::tbb::enumerable_thread_specific<ExactFieldError::Workspace> workspaces(
      [&] { return ExactFieldError::Workspace(exact); });
  const std::vector<std::uint32_t> consumer = consumers(records);
  const std::vector<double> scale = squared_scales(fields, records.volume);
  const std::size_t sum_count = field_count + 1;
  std::vector<double> sums; // of the coarse versions of a batch of records, as measured: version x (field, volume)

  const auto certify = [&](std::size_t record, std::uint32_t first_of_batch, ExactFieldError::Workspace& workspace) {
    double* const stated = records.field_error.data() + record * field_count;
    std::vector<double> errors(field_count);
    // What was seen at removed vertices stands: of those outside the version the measurement knows nothing.
    for (std::size_t f = 0; f < field_count; ++f)
      errors[f] = stated[f] / fields.fields()[f].range;
    const std::uint32_t first = records.coarse_begin[record].index();
    for (std::uint32_t t = first; t < first + records.modified_count[record]; ++t)
      if (!is_ghost(records.versions[t]))
        exact.measure(records.versions[t], workspace, errors,
                      {sums.data() + (t - first_of_batch) * sum_count, sum_count});
    for (std::size_t f = 0; f < field_count; ++f) {
      stated[f] = std::max(stated[f], certified(errors[f]) * fields.fields()[f].range);
    }
    records.uncovered_volume[record] -= volume_added(prepared, records, record);
  };
  // A version's integral counts for the record that made it, and against the one that consumed it; so does its volume
  // outside of the domain. In the order of the versions, so that the sums do not depend on the threads.
  const auto add_up = [&](std::size_t record, std::uint32_t first_of_batch) {
    const std::uint32_t first = records.coarse_begin[record].index();
    for (std::uint32_t t = first; t < first + records.modified_count[record]; ++t) {
      const double* const of_version = sums.data() + (t - first_of_batch) * sum_count;
      const std::uint32_t by = consumer[t - first_made(records)];
      for (std::size_t f = 0; f < field_count; ++f) {
        const double integral = of_version[f] * scale[f];
        records.squared_error[record * field_count + f] += integral;
        if (by != kNoConsumer) records.squared_error[by * field_count + f] -= integral;
      }
      records.uncovered_volume[record] += of_version[field_count];
      if (by != kNoConsumer) records.uncovered_volume[by] -= of_version[field_count];
    }
    if (!records.moves_boundary(record)) records.uncovered_volume[record] = 0;
  };
  while (done < records.size()) {
    const std::size_t begin = done;
    if (progress && !progress({"certifying errors", begin, records.size()}))
      throw Error(ErrorCode::kCancelled, "the build was cancelled");
    const std::size_t end = std::min(begin + kCertifyBatch, records.size());
    const std::uint32_t first = records.coarse_begin[begin].index();
    sums.assign((records.coarse_begin[end - 1].index() + records.modified_count[end - 1] - first) * sum_count, 0);
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(begin, end, 4), [&](const auto& range) {
      auto& workspace = workspaces.local();
      for (std::size_t record = range.begin(); record != range.end(); ++record)
        certify(record, first, workspace);
    });
    for (std::size_t record = begin; record != end; ++record)
      add_up(record, first);
    done = end;
  }
}

} // namespace ptet::build
