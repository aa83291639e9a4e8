// A mutex that knows who holds it: a thread that comes by again gets an error, where it would wait for itself for ever.
// So it is with a source, or a report of progress, that asks the very dataset that called it.
#pragma once

#include "ptet/error.hpp"

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

namespace ptet::file {

/// As std::timed_mutex, but lock() and try_lock_until() throw Error(kBadArgument) in the thread that holds it.
class OwnedMutex {
public:
  void lock() {
    refuse_owner();
    mutex_.lock();
    owner_ = std::this_thread::get_id();
  }
  [[nodiscard]] bool try_lock_until(std::chrono::steady_clock::time_point until) {
    refuse_owner();
    if (!mutex_.try_lock_until(until)) return false;
    owner_ = std::this_thread::get_id();
    return true;
  }
  void unlock() {
    owner_ = std::thread::id();
    mutex_.unlock();
  }

private:
  void refuse_owner() const {
    if (owner_ == std::this_thread::get_id())
      throw Error(ErrorCode::kBadArgument,
                  "a dataset cannot be asked from within its own source's read or a progress callback of its own");
  }

  std::timed_mutex mutex_;
  std::atomic<std::thread::id> owner_{};
};

} // namespace ptet::file
