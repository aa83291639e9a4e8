// Progress and cancellation go through one callback; the library itself never prints.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

namespace ptet {

struct Progress {
  std::string_view stage; ///< a short verb phrase, such as "collapsing"
  std::uint64_t done = 0;
  std::uint64_t total = 0; ///< 0: unknown
};

/// Called from the thread that called the library: as a rule some hundred times a second, of small meshes more often.
/// Returning false cancels: the running call throws Error with ErrorCode::kCancelled and leaves nothing
/// behind but a checkpoint that was asked for.
using ProgressCallback = std::function<bool(const Progress&)>;

} // namespace ptet
