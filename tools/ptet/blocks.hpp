// The blocks of a .ptet file: which holds a record, and which must be loaded with it.
#pragma once

#include "formats/ptet/reader.hpp"

#include <cstdint>
#include <vector>

namespace ptet::cli {

/// `wanted` and, transitively, the blocks they need; ascending. Loaded ones may be among them.
[[nodiscard]] std::vector<std::uint32_t> with_needs(const std::vector<file::BlockInfo>& blocks,
                                                    std::vector<std::uint32_t> wanted);

/// The block that holds a record.
[[nodiscard]] std::uint32_t block_of(const std::vector<file::BlockInfo>& blocks, RecordId record);

} // namespace ptet::cli
