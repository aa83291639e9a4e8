#include "lod/content_lock.hpp"

#include <chrono>
#include <thread>

namespace ptet {

std::shared_lock<std::shared_mutex> ContentLock::shared() const {
  const std::lock_guard through(gate_);
  return std::shared_lock(content_);
}

// One reader who takes long must not make the others wait at once.
std::unique_lock<std::shared_mutex> ContentLock::alone() {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kPatience{20};
  constexpr std::chrono::microseconds kBetweenTries{200};
  std::unique_lock lock(content_, std::defer_lock);
  for (const auto end = Clock::now() + kPatience;; std::this_thread::sleep_for(kBetweenTries)) {
    const std::lock_guard through(gate_);
    if (lock.try_lock()) return lock;
    if (Clock::now() < end) continue;
    lock.lock();
    return lock;
  }
}

} // namespace ptet
