#include "build/certify.hpp"

#include "build/mesh_scales.hpp"
#include "error/tolerances.hpp"
#include "ptet/error.hpp"
#include "record/ghost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::build {
namespace {

/// Records between two reports of progress.
constexpr std::size_t kCertifyBatch = 1024;
constexpr std::uint32_t kNoConsumer = std::numeric_limits<std::uint32_t>::max();

/// By version that a record made, in the order in which they were made: the record that consumed it, or kNoConsumer.
std::vector<std::uint32_t> consumers(const RecordStream& records) {
  constexpr std::uint32_t kOriginal = std::numeric_limits<std::uint32_t>::max(); // not made by a record
  std::vector<std::uint32_t> consumer(records.version_count() - records.slot_count(), kNoConsumer);
  std::vector<std::uint32_t> held(records.slot_count(), kOriginal); // by slot: the version
  std::uint32_t made = 0;
  for (std::uint32_t r = 0; r < records.size(); ++r) {
    for (const std::uint32_t slot : records.star(r))
      if (held[slot] != kOriginal) consumer[held[slot]] = r;
    for (const std::uint32_t slot : records.modified(r))
      held[slot] = made++;
  }
  return consumer;
}

/// The coarse versions of some records in a row.
class CoarseVersions {
public:
  CoarseVersions(const PreparedMesh& prepared, const RecordStream& records)
      : prepared_(prepared), records_(records), tets_(records.original()) {}

  /// Those of the records from the end of the last batch up to `end`. Takes what the collapses added to the volume from
  /// the uncovered volume of each.
  void next_batch(std::size_t end, std::vector<double>& uncovered_volume) {
    first_version_ += static_cast<std::uint32_t>(versions_.size());
    versions_.clear();
    begin_.assign(1, 0);
    first_record_ = std::exchange(next_record_, end);
    for (std::size_t record = first_record_; record < end; ++record) {
      uncovered_volume[record] -= make(record);
      begin_.push_back(versions_.size());
    }
  }
  /// Goes past the records up to `end`.
  void skip(std::size_t end) {
    for (; next_record_ < end; ++next_record_) {
      records_.collapse(next_record_, tets_);
      first_version_ += records_.modified_count[next_record_];
    }
  }

  [[nodiscard]] std::span<const Tet> versions() const { return versions_; }
  /// Number of the first of them among all that records made.
  [[nodiscard]] std::uint32_t first_version() const { return first_version_; }
  /// Where those of a record begin and end among versions().
  [[nodiscard]] std::pair<std::size_t, std::size_t> of(std::size_t record) const {
    return {begin_[record - first_record_], begin_[record - first_record_ + 1]};
  }

private:
  /// What it adds to the volume of the mesh; 0 where that may be rounding.
  double make(std::size_t record) {
    const bool moves_boundary = records_.moves_boundary(record);
    const double before = moves_boundary ? volume(records_.star(record)) : 0;
    records_.collapse(record, tets_);
    for (const std::uint32_t slot : records_.modified(record))
      versions_.push_back(tets_[slot]);
    return moves_boundary ? volume_change(before, volume(records_.modified(record))) : 0;
  }
  [[nodiscard]] double volume(std::span<const std::uint32_t> slots) const {
    double sum = 0;
    for (const std::uint32_t slot : slots)
      if (!records_.is_ghost(slot)) sum += volume_of(prepared_, tets_[slot]);
    return sum;
  }

  const PreparedMesh& prepared_;
  const RecordStream& records_;
  std::vector<Tet> tets_; ///< by slot, before the next record
  std::size_t first_record_ = 0, next_record_ = 0;
  std::uint32_t first_version_ = 0;
  std::vector<Tet> versions_;
  std::vector<std::size_t> begin_{0}; ///< by record of the batch, and the end
};

} // namespace

double certified(double measured) {
  return measured * (1 + kErrorSlack);
}

std::vector<double> squared_scales(const NormalizedFields& fields, double volume) {
  std::vector<double> scales;
  scales.reserve(fields.field_count());
  for (const GoverningField& field : fields.fields())
    scales.push_back(field.range > 0 && !holds_squares(field.range, volume) ? 1 : field.range * field.range);
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
  CoarseVersions coarse(prepared, records);
  coarse.skip(done);
  std::vector<double> sums; // of the coarse versions of a batch of records, as measured: version x (field, volume)

  const auto certify = [&](std::size_t record, ExactFieldError::Workspace& workspace) {
    double* const stated = records.field_error.data() + record * field_count;
    std::vector<double> errors(field_count);
    // What was seen at removed vertices stands: of those outside the version the measurement knows nothing.
    for (std::size_t f = 0; f < field_count; ++f)
      errors[f] = stated[f] / fields.fields()[f].scale();
    const auto [first, last] = coarse.of(record);
    for (std::size_t t = first; t < last; ++t)
      if (!is_ghost(coarse.versions()[t]))
        exact.measure(coarse.versions()[t], workspace, errors, {sums.data() + t * sum_count, sum_count});
    for (std::size_t f = 0; f < field_count; ++f) {
      stated[f] = std::max(stated[f], certified(errors[f]) * fields.fields()[f].range);
    }
  };
  // A version's integral counts for the record that made it, and against the one that consumed it; so does its volume
  // outside of the domain. In the order of the versions, so that the sums do not depend on the threads.
  const auto add_up = [&](std::size_t record) {
    const auto [first, last] = coarse.of(record);
    for (std::size_t t = first; t < last; ++t) {
      const double* const of_version = sums.data() + t * sum_count;
      const std::uint32_t by = consumer[coarse.first_version() + t];
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
    coarse.next_batch(end, records.uncovered_volume);
    sums.assign(coarse.versions().size() * sum_count, 0);
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(begin, end, 4), [&](const auto& range) {
      auto& workspace = workspaces.local();
      for (std::size_t record = range.begin(); record != range.end(); ++record)
        certify(record, workspace);
    });
    for (std::size_t record = begin; record != end; ++record)
      add_up(record);
    done = end;
  }
}

} // namespace ptet::build
