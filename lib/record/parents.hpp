// Which records of a stream must be split before which.
#pragma once

#include "record/stream.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace ptet {

/// For each record the later ones that consumed what it made: those that took its modified slots next.
class StreamParents {
public:
  StreamParents() = default;
  /// `records`: valid, see RecordStream::validate().
  explicit StreamParents(const RecordStream& records);

  /// Each once, ascending.
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t record) const {
    const std::size_t row = begin_.size() - 2 - record; // found from the last record to the first
    return {parents_.data() + begin_[row], parents_.data() + begin_[row + 1]};
  }

private:
  std::vector<std::uint64_t> begin_{0};
  std::vector<std::uint32_t> parents_;
};

/// Calls `visit` with each stream record that must be split before `record`: those that consumed what it made, and the
/// others it needs. May repeat one. `parents`: of the same stream.
template <class Visit>
void for_each_parent(const RecordStream& records, const StreamParents& parents, std::size_t record, Visit&& visit) {
  for (const std::uint32_t parent : parents.of(record))
    visit(parent);
  for (const std::uint32_t other : records.others_needed(record))
    visit(other);
}

} // namespace ptet
