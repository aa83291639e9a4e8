// What is asked of a thread that loads blocks, and the thread: the latest request first, a part of one at a time.
//
//   ask_for(C) -> [ C | B | A ] -> a part of C, of whatever is first by then, ... -> a request of which nothing is left
//                                                                                    leaves the queue
//
// A request stays in its place while a part of it is served, so one that is asked meanwhile comes before the rest of
// it. Who moves on takes back what it asked for before: of a view that moves only where it is now is loaded.
#pragma once

#include "lod/block_needs.hpp"
#include "ptet/progress.hpp"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <unistd.h>

namespace ptet {

/// Thread rule: any number of threads may ask and wait.
class LoadQueue {
public:
  /// Called by the thread: does a part of what is asked, returns whether anything is left of it. What it throws is
  /// handed to who asks or waits; after stop() it is dropped.
  using Serve = std::function<bool(const BlockSet& asked)>;

  explicit LoadQueue(Serve serve);
  /// Waits for the part that is being served.
  ~LoadQueue();
  LoadQueue(const LoadQueue&) = delete;
  LoadQueue& operator=(const LoadQueue&) = delete;

  /// One that is asked again and again is queued once, as the latest. Of too many the two oldest become one. What the
  /// same `asker`, if any, asked for before is wanted no more.
  /// Throws what serving threw, once, and asks for nothing then; Error(kBadArgument) when asked by what serves.
  void ask_for(const BlockSet& set, const void* asker = nullptr);
  /// The asker is no more, or wants nothing.
  void forget_asker(const void* asker);
  /// Returns once nothing asked for is left to do. Throws Error(kCancelled) when `progress` says so, what serving
  /// threw, and Error(kBadArgument) when asked by what serves.
  void wait_until_done(const ProgressCallback& progress);

  /// No more parts are to be served; for what serves one to look at.
  void stop();
  /// The same, and waits for the part that is being served.
  void finish();
  [[nodiscard]] bool is_stopped() const { return is_stopped_; }
  /// In a forked process, where the queue's thread is not, another may have its number.
  [[nodiscard]] bool is_own_thread() const { return !is_orphaned() && std::this_thread::get_id() == thread_.get_id(); }
  /// Whoever owns the queue, and how it goes.
  using Owner = std::unique_ptr<void, void (*)(void* owner)>;
  /// To be called by what serves, where nobody else knows the owner any more: no more parts are served, and at its end
  /// the thread, which cannot wait for itself, lets the owner go.
  void end_with(Owner owner);
  /// Whether this process was forked from the one that has the thread. Whatever that held then, it holds here for ever:
  /// no lock may be taken, and the queue must be left alone, since its destructor would wait for the thread.
  [[nodiscard]] bool is_orphaned() const { return ::getpid() != process_; }
  /// Throws Error(kIo) then.
  void refuse_orphaned() const;

private:
  struct Request {
    BlockSet set;
    std::vector<const void*> askers; ///< those whose last request it is; wanted as long as there is one
    bool is_anyones = false;         ///< also asked for without an asker, so that nobody can take it back
  };
  using Asked = std::shared_ptr<Request>;
  static constexpr std::size_t kMaxQueued = 64;

  void refuse_own_thread() const;
  void work();
  [[nodiscard]] Asked wait_for_first();
  void forget(const Asked& asked);
  void take_back(const void* asker);
  void join_oldest();

  const Serve serve_;
  std::mutex mutex_;
  std::deque<Asked> asked_;  ///< the latest first
  std::exception_ptr error_; ///< what serving threw
  std::condition_variable has_work_, is_done_;
  std::atomic<bool> is_stopped_{false};
  const pid_t process_ = ::getpid();
  Owner owner_{nullptr, nullptr}; ///< where it goes with the thread
  std::thread thread_;
};

} // namespace ptet
