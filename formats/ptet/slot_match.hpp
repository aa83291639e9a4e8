// Which slot of a record stream each place of a refinement is (Place): what a slot held first to last, from the base
// on, its place holds last to first. A collapse deletes the slots that its split gives places to, and all others stay
// what they are.
#pragma once

#include "formats/ptet/file_stars.hpp"
#include "formats/ptet/ordering.hpp"
#include "mesh/large_pages.hpp"
#include "record/refinement.hpp"
#include "record/stream.hpp"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace ptet::file {

class SlotMatch {
public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  /// Matches the base. Throws Error(kBadInput) when the records do not lead to a closed base mesh.
  SlotMatch(const RecordStream& records, const FileOrder& order, const Refinement& refinement);

  /// Matches the rims of these records of the file, which have been split, in parallel. Throws Error(kBadInput) when
  /// they are not what the collapses deleted. `stars`: of the stream.
  void add_rims(const Refinement& refinement, const FileStars& stars, std::span<const std::uint32_t> records);

  /// kNone when it has not been matched.
  [[nodiscard]] std::uint32_t slot_of(std::uint32_t place) const {
    return place < slot_of_.size() ? slot_of_[place] : kNone;
  }
  /// kNone when it has not appeared yet.
  [[nodiscard]] std::uint32_t place_of(std::uint32_t slot) const { return place_of_[slot]; }

private:
  void match(std::uint32_t slot, std::uint32_t place) {
    slot_of_[place] = slot;
    place_of_[slot] = place;
  }
  void add_rim(const Refinement& refinement, const FileStars& stars, RecordId r);

  LargeVector<std::uint32_t> slot_of_;  ///< by place of the refinement
  LargeVector<std::uint32_t> place_of_; ///< by slot of the stream
};

} // namespace ptet::file
