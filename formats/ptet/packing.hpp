// The sections of a file, packed: one zstd frame, or the bytes as they are. PTET.md, "Directory".
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace ptet::file {

/// A frame that expands no more than kMaxExpansion times, or `raw` itself where a frame is no smaller. Calls
/// `look(done)`, which may throw, with how many bytes are done, every few megabytes. Same bytes, same frame.
/// Throws Error(kLimit) where memory runs out.
[[nodiscard]] std::vector<std::byte> packed(std::span<const std::byte> raw,
                                            const std::function<void(std::size_t done)>& look);

} // namespace ptet::file
