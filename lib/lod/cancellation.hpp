// Asks the caller of the library now and then whether to go on.
#pragma once

#include "ptet/error.hpp"
#include "ptet/progress.hpp"

#include <chrono>

namespace ptet {

/// Of one call; used by its thread alone, and no lock held that the caller may need.
class Cancellation {
public:
  /// `progress` must outlive it; may be empty.
  explicit Cancellation(const ProgressCallback& progress) : progress_(progress) {}

  /// Asks at the first call, and then so many times a second. Once cancelled is cancelled for good.
  [[nodiscard]] bool is_wanted() {
    if (is_wanted_ || !progress_) return is_wanted_;
    const auto now = std::chrono::steady_clock::now();
    if (was_asked_ && now - asked_at_ < kBetween) return false;
    was_asked_ = true;
    asked_at_ = now;
    return is_wanted_ = !progress_({"reading", 0, 0});
  }
  /// Throws Error(kCancelled).
  void check() {
    if (is_wanted()) throw Error(ErrorCode::kCancelled, "the request was cancelled");
  }

private:
  static constexpr std::chrono::milliseconds kBetween{5};

  const ProgressCallback& progress_;
  bool was_asked_ = false, is_wanted_ = false;
  std::chrono::steady_clock::time_point asked_at_;
};

} // namespace ptet
