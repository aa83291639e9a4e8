// Which version of a file each version of a record stream is. The file's appear as its records are split, coarse to
// fine, in an order of their own; those of the stream were numbered as collapses made them.
#pragma once

#include "formats/ptet/ordering.hpp"
#include "mesh/large_pages.hpp"
#include "record/refinement.hpp"
#include "record/stream.hpp"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <oneapi/tbb/enumerable_thread_specific.h>

namespace ptet::file {

class VersionMatch {
public:
  /// Matches the base. `consumers`: by stream version, see find_consumers(). `records` and `order` must outlive the
  /// object. Throws Error(kBadInput) when the records do not lead to a closed base mesh.
  VersionMatch(const RecordStream& records, const FileOrder& order, std::span<const std::uint32_t> consumers,
               const Refinement& refinement);

  /// Matches what the splits of these records of the file have brought, in parallel. Throws Error(kBadInput) when that
  /// is not what the collapses consumed.
  void add_fine(const Refinement& refinement, std::span<const std::uint32_t> records);

  /// The stream version; RecordStream's numbers.
  [[nodiscard]] std::uint32_t stream_of(VersionId version) const { return stream_of_[version.index()]; }
  /// The refinement's; none when it has not appeared yet.
  [[nodiscard]] VersionId version_of(std::uint32_t stream_version) const { return version_of_[stream_version]; }

private:
  using Keys = std::vector<std::pair<std::uint64_t, std::uint32_t>>;
  /// Of one thread.
  struct Scratch {
    Keys fine_keys, stream_keys;
  };

  void add_fine(const Refinement& refinement, RecordId r, Scratch& scratch);
  [[nodiscard]] Tet in_file(Tet tet) const;

  const RecordStream& records_;
  const FileOrder& order_;
  LargeVector<std::uint32_t> stream_of_; ///< by version of the refinement
  LargeVector<VersionId> version_of_;    ///< by version of the stream
  oneapi::tbb::enumerable_thread_specific<Scratch> scratch_;
};

} // namespace ptet::file
