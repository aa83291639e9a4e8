// What opening a file leaves for decoding its blocks, and the public face of the reader does not show.
#pragma once

#include "formats/ptet/layout.hpp"
#include "formats/ptet/reader.hpp"
#include "formats/ptet/record_codec.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace ptet::file {

struct Reader::Decoding {
  Decoding(std::shared_ptr<ByteSource> source, const OpenOptions& options, Violations told)
      : reader(std::move(source), options.max_gap), limits(options.limits), violations(std::move(told)) {
    // What is within it must not wrap around where addresses have 32 bits.
    limits.max_bytes = std::min<std::uint64_t>(limits.max_bytes, std::numeric_limits<std::size_t>::max() / 2);
  }

  /// Of a number that passes a limit.
  [[nodiscard]] ErrorCode beyond_limit() const { return is_sound ? ErrorCode::kLimit : ErrorCode::kCorruptFile; }

  RangeReader reader;
  Limits limits;
  Violations violations;
  std::uint64_t claimed = 0; ///< of Limits::max_bytes
  bool is_sound = true;      ///< no hash of what says how much there is was wrong
  FixedHeader fixed;
  std::vector<Precisions> precisions; ///< of the positions, then of each array
  /// What the table says that a block's bytes are, and make.
  struct Decoded {
    std::uint32_t version_count = 0;
    std::uint64_t hash = 0;
  };
  std::vector<Decoded> decoded; ///< by block
  Section base;
  Section input_order;               ///< where there is one
  std::vector<std::byte> base_bytes; ///< as stored, so that the base can be had again without the source
  InitialProbabilities initial;
  std::vector<std::uint32_t> block_of; ///< by record
  std::optional<Schema> schema;
  std::optional<RecordCodec> codec;
};

[[noreturn]] inline void fail_file(const std::string& what, std::uint64_t offset) {
  throw Error(ErrorCode::kCorruptFile, "the file is corrupt: " + what, offset);
}

} // namespace ptet::file
