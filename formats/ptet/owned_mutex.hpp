// A mutex that knows who holds it: a thread that comes by again gets an error, where it would wait for itself for ever.
// So it is with a source, or a report of progress, that asks the very dataset that called it.
#pragma once

#include "ptet/error.hpp"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace ptet::file {

/// Throws the Error of a dataset that is asked by what it has called.
[[noreturn]] inline void refuse_from_within() {
  throw Error(ErrorCode::kBadArgument,
              "a dataset cannot be asked from within its own source's read or a progress callback of its own");
}

/// As std::timed_mutex, but lock() and try_lock_until() throw Error(kBadArgument) in the thread that holds it. Made of
/// a condition, as the thread sanitizer of older compilers does not see a timed mutex being locked.
class OwnedMutex {
public:
  void lock() {
    std::unique_lock guard(mutex_);
    refuse_owner();
    released_.wait(guard, [this] { return is_free(); });
    owner_ = std::this_thread::get_id();
  }
  [[nodiscard]] bool try_lock_until(std::chrono::steady_clock::time_point until) {
    std::unique_lock guard(mutex_);
    refuse_owner();
    if (!released_.wait_until(guard, until, [this] { return is_free(); })) return false;
    owner_ = std::this_thread::get_id();
    return true;
  }
  void unlock() {
    const std::lock_guard guard(mutex_);
    owner_ = std::thread::id();
    released_.notify_one();
  }

private:
  [[nodiscard]] bool is_free() const { return owner_ == std::thread::id(); }
  void refuse_owner() const {
    if (owner_ == std::this_thread::get_id()) refuse_from_within();
  }

  std::mutex mutex_;
  std::condition_variable released_;
  std::thread::id owner_; ///< who holds it; nobody: the id of no thread
};

} // namespace ptet::file
