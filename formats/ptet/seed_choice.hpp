// Where the growth of a record's region begins: the versions that are cheapest to name.
#pragma once

#include "formats/ptet/ordering.hpp"
#include "formats/ptet/record_codec.hpp"
#include "formats/ptet/version_match.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace ptet::file {

class SeedChoice {
public:
  /// `block_of`: by record of the file. All must outlive the object.
  SeedChoice(const RecordStream& records, const FileOrder& order, const Schema& schema,
             std::span<const BlockInfo> infos, std::span<const std::uint32_t> block_of, const VersionMatch& match)
      : records_(records), order_(order), schema_(schema), infos_(infos), block_of_(block_of), match_(match) {}

  /// The seeds of record `r` of block `state.block`, as they stand before its split; valid until the next call.
  /// Throws Error(kBadInput) when a version of its region has not appeared yet.
  [[nodiscard]] std::span<const Seed> choose(const BitCounter& coder, const BlockState& state,
                                             const Refinement& refinement, RecordId r);

private:
  /// `number`: the block's.
  [[nodiscard]] Seed seed_at(const Refinement& refinement, std::uint32_t number, VersionId version,
                             VertexId target) const;

  const RecordStream& records_;
  const FileOrder& order_;
  const Schema& schema_;
  std::span<const BlockInfo> infos_;
  std::span<const std::uint32_t> block_of_;
  const VersionMatch& match_;
  std::vector<Seed> seeds_;
  std::vector<char> reached_;
  std::vector<std::uint32_t> front_;
};

} // namespace ptet::file
