#include "lod/content_lock.hpp"

#include <chrono>
#include <thread>

namespace ptet {

std::shared_lock<std::shared_mutex> ContentLock::shared() const {
  const std::lock_guard through(gate_);
  return std::shared_lock(content_);
}

// Waiting for the readers to leave closes the gate to all further ones. So that one reader who takes long does not
// make the others wait, the lock is only tried for a while, with the gate open in between.
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
