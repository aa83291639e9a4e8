#include "record/parents.hpp"

#include "mesh/large_pages.hpp"

#include <algorithm>
#include <limits>

namespace ptet {

StreamParents::StreamParents(const RecordStream& records) {
  constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();
  constexpr std::size_t kMostOften = 16; // parents of a record; what is not used takes no memory
  LargeVector<std::uint32_t> taken_next(records.slot_count(), kNobody); // by slot: the record, of those looked at
  reserve_large(parents_, kMostOften * records.size());
  begin_.reserve(records.size() + 1);
  for (auto record = static_cast<std::uint32_t>(records.size()); record-- > 0;) {
    const auto row = static_cast<std::ptrdiff_t>(parents_.size());
    for (const std::uint32_t slot : records.modified(record))
      if (taken_next[slot] != kNobody) parents_.push_back(taken_next[slot]);
    std::sort(parents_.begin() + row, parents_.end());
    parents_.erase(std::unique(parents_.begin() + row, parents_.end()), parents_.end());
    begin_.push_back(parents_.size());
    for (const std::uint32_t slot : records.star(record))
      taken_next[slot] = record;
  }
}

} // namespace ptet
