#include "lod/load_queue.hpp"

#include "formats/ptet/owned_mutex.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace ptet {
LoadQueue::LoadQueue(Serve serve)
    : serve_(std::move(serve)), thread_([this] {
        work();
        const Owner owner = std::move(owner_); // this queue goes with it
      }) {}

LoadQueue::~LoadQueue() {
  finish();
}

void LoadQueue::finish() {
  stop();
  if (thread_.joinable()) thread_.join();
}

void LoadQueue::end_with(Owner owner) {
  stop();
  owner_ = std::move(owner);
  thread_.detach();
}

void LoadQueue::stop() {
  {
    const std::lock_guard guard(mutex_);
    is_stopped_ = true;
  }
  has_work_.notify_all();
}

void LoadQueue::refuse_orphaned() const {
  if (is_orphaned())
    throw Error(ErrorCode::kIo, "the thread that reads in the background has stayed in the process that this one was "
                                "forked from; open the file anew");
}

void LoadQueue::ask_for(const BlockSet& set, const void* asker) {
  refuse_own_thread();
  {
    const std::lock_guard guard(mutex_);
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
    const auto before =
        std::find_if(asked_.begin(), asked_.end(), [&](const Asked& asked) { return asked->set == set; });
    if (before != asked_.end()) {
      std::rotate(asked_.begin(), before, before + 1);
    } else {
      asked_.push_front(std::make_shared<Request>(Request{set, {}, false}));
      if (asked_.size() > kMaxQueued) join_oldest();
    }
    const Asked asked = asked_.front();
    if (asker == nullptr) {
      asked->is_anyones = true;
    } else {
      const bool was_anyones = std::exchange(asked->is_anyones, true); // it stays
      take_back(asker);
      asked->is_anyones = was_anyones;
      asked->askers.push_back(asker);
    }
  }
  has_work_.notify_one();
}

/// The mutex must be held. What is being served may be one of them, and must not change.
void LoadQueue::join_oldest() {
  const Asked oldest = asked_.back();
  asked_.pop_back();
  auto joined = std::make_shared<Request>(*asked_.back());
  unite(joined->set, oldest->set);
  joined->askers.insert(joined->askers.end(), oldest->askers.begin(), oldest->askers.end());
  joined->is_anyones |= oldest->is_anyones;
  asked_.back() = std::move(joined);
}

void LoadQueue::forget_asker(const void* asker) {
  if (is_orphaned()) return;
  const std::lock_guard guard(mutex_);
  take_back(asker);
  if (asked_.empty()) is_done_.notify_all();
}

/// The mutex must be held.
void LoadQueue::take_back(const void* asker) {
  std::erase_if(asked_, [&](const Asked& asked) {
    return std::erase(asked->askers, asker) > 0 && asked->askers.empty() && !asked->is_anyones;
  });
}

void LoadQueue::work() {
  while (const Asked asked = wait_for_first()) {
    bool has_more = false;
    try {
      has_more = serve_(asked->set);
    } catch (...) {
      const std::lock_guard guard(mutex_);
      error_ = std::current_exception();
    }
    if (!has_more) forget(asked);
  }
}

/// None when no more parts are to be served.
LoadQueue::Asked LoadQueue::wait_for_first() {
  std::unique_lock guard(mutex_);
  has_work_.wait(guard, [this] { return is_stopped_ || !asked_.empty(); });
  return is_stopped_ ? nullptr : asked_.front();
}

void LoadQueue::forget(const Asked& asked) {
  const std::lock_guard guard(mutex_);
  std::erase(asked_, asked);
  if (asked_.empty()) is_done_.notify_all();
}

// A source that asks for blocks while one is read would wait for itself.
void LoadQueue::refuse_own_thread() const {
  if (is_own_thread()) file::refuse_from_within();
}

void LoadQueue::wait_until_done(const ProgressCallback& progress) {
  refuse_orphaned();
  refuse_own_thread();
  std::unique_lock guard(mutex_);
  const auto is_done = [this] { return asked_.empty(); };
  while (!is_done()) {
    is_done_.wait_for(guard, std::chrono::milliseconds(20), is_done);
    if (!progress) continue;
    guard.unlock();
    if (!progress({"reading", 0, 0})) throw Error(ErrorCode::kCancelled, "waiting for blocks was cancelled");
    guard.lock();
  }
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

} // namespace ptet
