// All that the slots of a record stream ever held, written down.
#pragma once

#include "record/stream.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace ptet {

/// A version is a tetrahedron (or boundary face, see kDummyVertex) that existed at some time of the build.
using VersionId = Id<struct VersionTag>;

} // namespace ptet

namespace ptet::test {

/// Numbered: the original tets and ghosts by slot, then what each record made, in the order of its modified slots.
struct Versions {
  explicit Versions(const RecordStream& stream);

  std::vector<Tet> tets;
  std::vector<VersionId> coarse_begin; ///< by record: the first that it made
  std::vector<VersionId> fine;         ///< beside RecordStream::stars: what the slots held before

  /// Those that the record took, modified ones first.
  [[nodiscard]] std::span<const VersionId> consumed(std::size_t record) const {
    return {fine.data() + star_begin[record], fine.data() + star_begin[record + 1]};
  }

private:
  std::vector<std::uint64_t> star_begin;
};

} // namespace ptet::test
