#include "lod/load_queue.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <new>
#include <string>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

/// A queue whose requests, sets with one block, take `parts` each. A part begins when it is let.
class Served {
public:
  explicit Served(int parts)
      : left_(8, parts), queue_([this](const BlockSet& asked) {
          const auto block = static_cast<std::size_t>(std::find(asked.begin(), asked.end(), 1) - asked.begin());
          std::unique_lock guard(mutex_);
          has_begun_ = true;
          changed_.notify_all();
          changed_.wait(guard, [this] { return may_go_on_; });
          order_ += static_cast<char>('a' + block);
          if (fails_) throw std::bad_alloc();
          return --left_[block] > 0;
        }) {}

  void ask(char name, const void* asker = nullptr) {
    BlockSet set(left_.size(), 0);
    set[static_cast<std::size_t>(name - 'a')] = 1;
    queue_.ask_for(set, asker);
  }
  void wait_for_begin() {
    std::unique_lock guard(mutex_);
    changed_.wait(guard, [this] { return has_begun_; });
  }
  void fail() { fails_ = true; }
  void let_go_on() {
    const std::lock_guard guard(mutex_);
    may_go_on_ = true;
    changed_.notify_all();
  }
  LoadQueue& queue() { return queue_; }
  /// Names of the requests that parts were done of.
  [[nodiscard]] std::string order() {
    queue_.wait_until_done({});
    return order_;
  }

private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool has_begun_ = false, may_go_on_ = false;
  std::atomic<bool> fails_{false};
  std::string order_;
  std::vector<int> left_;
  LoadQueue queue_;
};

} // namespace

TEST_CASE("load queue: what is asked while a part of something else is done comes before the rest of it") {
  Served served(3);
  served.ask('a');
  served.wait_for_begin();
  served.ask('b');
  served.ask('c');
  served.let_go_on();
  CHECK(served.order() == "acccbbbaa");
}

TEST_CASE("load queue: what is asked again is the latest, and done once") {
  Served served(2);
  served.ask('a');
  served.wait_for_begin();
  served.ask('b');
  served.ask('c');
  served.ask('b');
  served.ask('a');
  served.let_go_on();
  CHECK(served.order() == "aabbcc");
}

TEST_CASE("load queue: who asks for something else takes back what nobody else asked for") {
  const int one = 0, other = 0;
  Served served(2);
  served.ask('a', &one);
  served.wait_for_begin();
  served.ask('b', &one); // and no more of a than the part that has begun
  served.ask('c', &one);
  served.ask('d', &other);
  served.ask('c', &other);
  served.ask('e', &one); // c is still the other's
  served.ask('f');
  served.ask('f', &one);
  served.ask('g', &one); // f may not be taken back
  served.let_go_on();
  CHECK(served.order() == "aggffcc");
}

TEST_CASE("load queue: what is asked for by one that goes is not loaded") {
  const int one = 0, other = 0;
  Served served(2);
  served.ask('a', &one);
  served.wait_for_begin();
  served.ask('b', &other);
  served.queue().forget_asker(&one);
  served.let_go_on();
  CHECK(served.order() == "abb");
  served.ask('c', &one);
  CHECK(served.order() == "abbcc");
}

TEST_CASE("load queue: however many are asked for, all that was asked is done") {
  constexpr std::size_t kBlocks = 300;
  std::mutex mutex;
  std::condition_variable changed;
  bool may_go_on = false;
  std::vector<int> done(kBlocks, 0);
  std::size_t parts = 0;
  LoadQueue queue([&](const BlockSet& asked) {
    std::unique_lock guard(mutex);
    changed.wait(guard, [&] { return may_go_on; });
    for (std::size_t b = 0; b < asked.size(); ++b)
      done[b] += asked[b] != 0 ? 1 : 0;
    ++parts;
    return false;
  });
  const auto ask = [&](std::size_t block, const void* asker) {
    BlockSet set(kBlocks, 0);
    set[block] = 1;
    queue.ask_for(set, asker);
  };
  const std::vector<int> askers(kBlocks);
  for (std::size_t b = 0; b < kBlocks; ++b)
    ask(b, b % 3 == 0 ? &askers[b] : nullptr);
  ask(5, &askers[200]);
  {
    const std::lock_guard guard(mutex);
    may_go_on = true;
  }
  changed.notify_all();
  queue.wait_until_done({});
  const std::lock_guard guard(mutex);
  CHECK(std::all_of(done.begin(), done.end(), [](int times) { return times >= 1 && times <= 2; }));
  CHECK(parts < kBlocks / 2); // as many as are kept apart, and not each by itself
}

TEST_CASE("load queue: what serving throws is told to who waits, and the rest is done") {
  Served served(2);
  served.fail();
  served.ask('a');
  served.ask('b');
  served.let_go_on();
  CHECK_THROWS_AS(served.queue().wait_until_done({}), std::bad_alloc);
  CHECK(served.order().size() == 2);
}

TEST_CASE("load queue: what serving throws is told to who asks next, once, if nobody waits") {
  Served served(1);
  served.fail();
  served.ask('a');
  served.let_go_on();
  bool is_told = false;
  for (int i = 0; i < 5000 && !is_told; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    try {
      served.ask('a');
    } catch (const std::bad_alloc&) {
      is_told = true;
    }
  }
  CHECK(is_told);
}

TEST_CASE("load queue: waiting can be given up, and so can what is asked") {
  Served served(2);
  served.ask('a');
  served.wait_for_begin();
  CHECK_THROWS_AS(served.queue().wait_until_done([](const Progress&) { return false; }), Error);
  served.queue().stop();
  served.let_go_on();
}
