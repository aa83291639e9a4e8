// Queries while a thread loads, with little time, and cancelled: every answer must be a closed cut, conforming, with
// errors that are true, and say what it lacks.
#include "lod/hierarchy.hpp"
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"
#include "support/brute_force.hpp"
#include "support/file_parts.hpp"
#include "support/loading_sample.hpp"
#include "support/meshes.hpp"
#include "support/session_checks.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <thread>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

using Bytes = std::vector<std::byte>;

/// Holds up whoever reads from a source, for ten seconds at most.
class Gate {
public:
  /// For the source's reader.
  void pass() {
    is_reading_ = true;
    for (int ms = 0; ms < 10000 && !is_open_; ++ms)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  void wait_for_reader() const {
    while (!is_reading_)
      std::this_thread::yield();
  }
  void open() { is_open_ = true; }

private:
  std::atomic<bool> is_reading_{false}, is_open_{false};
};

} // namespace

TEST_CASE("a thread loads while eight ask") {
  const LoadingSample& s = sample();
  OpenOptions options;
  options.background = true;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source, options);
    auto random = std::make_shared<std::mt19937>(seed);
    source->set([random](std::uint64_t, std::uint64_t) {
      std::this_thread::sleep_for(std::chrono::microseconds((*random)() % 2000));
      return false;
    });
    std::vector<std::vector<Extraction>> answers(8);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < answers.size(); ++t)
      threads.emplace_back([&, t] {
        for (std::size_t k = 0; k < 12; ++k)
          answers[t].push_back(dataset->extract(s.requests[(t + k) % s.requests.size()]));
      });
    for (std::thread& thread : threads)
      thread.join();
    std::size_t incomplete = 0;
    for (std::size_t t = 0; t < answers.size(); ++t)
      for (std::size_t k = 0; k < answers[t].size(); ++k) {
        const Extraction& answer = answers[t][k];
        if (answer.complete) {
          CHECK(same_mesh(answer, s.answers[(t + k) % s.requests.size()]));
          continue;
        }
        CHECK(answer.limited_by == LimitedBy::kLoading);
        CHECK(answer.failures.empty());
        if (k < 2) check_sound(answer);
        ++incomplete;
      }
    CHECK(incomplete > 0);
    for (std::size_t i = 0; i < s.requests.size(); ++i) {
      Extraction answer = dataset->extract(s.requests[i]);
      for (int round = 0; round < 100 && answer.limited_by == LimitedBy::kLoading; ++round) {
        dataset->wait_until_loaded();
        answer = dataset->extract(s.requests[i]);
      }
      CHECK(answer.complete);
      CHECK(same_mesh(answer, s.answers[i]));
    }
  }
}

TEST_CASE("what a cut is made of may be dropped while it is looked for") {
  BuildOptions quickly;
  quickly.prediction = Prediction::kQuadric;
  quickly.evaluation = Evaluation::kNone;
  const Bytes bytes = build_memory(grid({{24, 24, 24}, {}, 2, 5}), quickly);
  const DatasetInfo info = Dataset::open_memory(bytes)->info();
  const file::Reader reader(file::over_memory(bytes));
  OpenOptions options;
  options.background = true;
  for (std::uint32_t b = 0; b < reader.blocks().size(); ++b)
    options.memory_limit += reader.decoded_bytes(b);
  options.memory_limit /= 2;
  const auto around = [&](const Point& corner) {
    Request request;
    request.focus.push_back({Sphere{corner, 0.1 * info.diagonal}});
    request.max_tets = info.tets / 50;
    return request;
  };
  const Request here = around(info.box_min), there = around(info.box_max);
  int lacking = 0;
  for (int step = 1; step <= 6; ++step) {
    INFO("dropped at step " << step);
    const auto dataset = Dataset::open_memory(bytes, options);
    const auto go_there = [&] {
      (void)dataset->extract(there);
      dataset->wait_until_loaded();
    };
    (void)dataset->extract(here);
    dataset->wait_until_loaded();
    int calls = 0;
    const Extraction answer = dataset->extract(here, [&](const Progress&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(6)); // so that the next step is told, too
      if (++calls == step) std::thread(go_there).join();
      return true;
    });
    lacking += answer.limited_by == LimitedBy::kLoading ? 1 : 0;
    std::vector<char> is_used(answer.mesh.vertex_count(), 0);
    for (const Tet& tet : answer.mesh.tets)
      for (const VertexId v : tet)
        is_used[v.index()] = 1;
    CHECK(std::count(is_used.begin(), is_used.end(), 0) == 0);
  }
  CHECK(lacking > 0);
}

TEST_CASE("a thread that loads meets damage, and is stopped at any time") {
  const LoadingSample& s = sample();
  OpenOptions options;
  options.background = true;
  Bytes damaged = s.bytes;
  const auto last = static_cast<std::uint32_t>(s.blocks.size() - 1);
  flip(damaged, 8 * s.blocks[last].offset);
  {
    const auto dataset = Dataset::open_memory(damaged, options);
    (void)dataset->extract({});
    dataset->wait_until_loaded();
    const Extraction answer = dataset->extract({});
    CHECK(answer.limited_by == LimitedBy::kUnreadable);
    REQUIRE(answer.failures.size() == 1);
    check_answer_without(0, answer, left_without({last}));
    CHECK_NOTHROW(dataset->wait_until_loaded([](const Progress&) { return true; }));
  }
  for (int microseconds = 0; microseconds < 3000; microseconds += 100) {
    const auto dataset = Dataset::open_memory(s.bytes, options);
    (void)dataset->extract({});
    std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
  }
  const auto source = std::make_shared<FailingSource>(s.bytes);
  const auto dataset = Dataset::open(source, options);
  std::atomic<bool> go_on{false};
  source->set([&](std::uint64_t, std::uint64_t) {
    while (!go_on)
      std::this_thread::yield();
    return false;
  });
  CHECK(dataset->extract({}).limited_by == LimitedBy::kLoading);
  CHECK_THROWS_AS(dataset->wait_until_loaded([](const Progress&) { return false; }), Error);
  go_on = true;
  dataset->wait_until_loaded();
  CHECK(same_mesh(dataset->extract({}), s.answers[0]));
}

TEST_CASE("a session follows while a thread loads") {
  const LoadingSample& s = sample();
  OpenOptions options;
  options.background = true;
  const auto dataset = Dataset::open_memory(s.bytes, options);
  Session session(dataset);
  for (std::size_t i = 0; i < s.requests.size(); ++i) {
    INFO("request " << i);
    for (int round = 0; round < 100 && !session.update(s.requests[i]).complete; ++round)
      dataset->wait_until_loaded();
    CHECK(difference(session, session.update(s.requests[i]), s.answers[i]) == "");
  }
}

TEST_CASE("a dataset that goes while its thread reads waits for one read, no more") {
  const LoadingSample& s = sample();
  const auto source = std::make_shared<FailingSource>(s.bytes);
  OpenOptions options;
  options.background = true;
  auto dataset = Dataset::open(source, options);
  Gate gate;
  source->set([&](std::uint64_t, std::uint64_t) {
    gate.pass();
    return true; // so that each block would be tried alone
  });
  const std::uint64_t before = source->reads();
  (void)dataset->extract({});
  gate.wait_for_reader();
  std::thread other([&] { dataset.reset(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(100)); // it waits by now, most likely
  gate.open();
  other.join();
  CHECK(source->reads() - before <= 2);
}

// A view that moves over a slow source: only where it is now counts.
TEST_CASE("what a session asked a thread for before is read no more") {
  const LoadingSample& s = sample();
  const std::size_t last = 1;
  const std::uint64_t needed = Dataset::open_memory(s.bytes)->extract(s.requests[last]).bytes_read;
  REQUIRE(needed < s.bytes.size() / 2);
  const auto source = std::make_shared<FailingSource>(s.bytes);
  OpenOptions options;
  options.background = true;
  const auto dataset = Dataset::open(source, options);
  Gate gate;
  source->set([&](std::uint64_t, std::uint64_t) {
    gate.pass();
    return false;
  });
  Session session(dataset);
  session.update(s.requests[last]);
  gate.wait_for_reader();
  session.update(s.requests[0]); // the original
  session.update(s.requests[2]);
  {
    Session gone(dataset);
    gone.update(s.requests[0]);
  }
  session.update(s.requests[last]);
  gate.open();
  dataset->wait_until_loaded();
  CHECK(dataset->bytes_read() == needed);
  CHECK(difference(session, session.update(s.requests[last]), s.answers[last]) == "");
}

TEST_CASE("a session reads as much as there is time for, and gets there") {
  const LoadingSample& s = sample();
  for (const int delay_ms : {0, 15}) {
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source);
    source->set([delay_ms](std::uint64_t, std::uint64_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
      return false;
    });
    // One read, or as many as the time may have been enough for: each takes no less than the delay.
    const double ms = delay_ms == 0 ? 0 : 2.5 * delay_ms;
    const std::uint64_t reads_allowed = delay_ms == 0 ? 1 : 3;
    Session session(dataset);
    SlotCopy copy;
    std::size_t stopped = 0;
    for (const std::size_t i : {std::size_t{5}, std::size_t{3}, std::size_t{4}, std::size_t{2}, std::size_t{0}}) {
      INFO("request " << i << ", " << delay_ms << " ms a read");
      Request request = s.requests[i];
      request.max_milliseconds = ms;
      for (int round = 0; round < 1000; ++round) {
        const std::uint64_t reads = source->reads();
        const SessionUpdate& update = session.update(request);
        copy.follow(session, update);
        REQUIRE(copy.difference(session) == "");
        CHECK(source->reads() - reads <= reads_allowed);
        if (update.complete) break;
        CHECK(update.limited_by == LimitedBy::kTime);
        CHECK(update.failures.empty());
        if (source->reads() > reads && ++stopped % 8 == 1) check_sound(session.extraction());
      }
      const std::uint64_t reads = source->reads();
      CHECK(difference(session, session.update(s.requests[i]), s.answers[i]) == "");
      CHECK(source->reads() == reads);
    }
    CHECK(stopped >= 2);
    if (delay_ms > 0) CHECK(stopped < s.blocks.size() / 2); // not block by block
  }
}

TEST_CASE("a session with a view and a budget reads as much as there is time for, too") {
  const LoadingSample& s = sample();
  const auto source = std::make_shared<FailingSource>(s.bytes);
  const auto dataset = Dataset::open(source);
  Request request;
  request.view = View{dataset->info().box_max, {-1, -1, -1}};
  request.view->max_pixels = 0;
  request.max_tets = dataset->info().tets / 2;
  const Extraction answer = Dataset::open_memory(s.bytes)->extract(request);
  REQUIRE(answer.limited_by == LimitedBy::kBudget);
  request.max_milliseconds = 0;
  Session session(dataset);
  std::size_t stopped = 0;
  for (int round = 0; round < 1000; ++round) {
    const std::uint64_t reads = source->reads();
    const SessionUpdate& update = session.update(request);
    CHECK(source->reads() - reads <= 2); // the last of the blocks that seemed enough, and the first of those after them
    if (update.complete) break;
    CHECK(update.limited_by == LimitedBy::kTime);
    CHECK(update.failures.empty());
    if (source->reads() > reads && ++stopped % 8 == 1) check_sound(session.extraction());
  }
  CHECK(stopped >= s.blocks.size() / 4);
  CHECK(difference(session, session.update(request), answer) == "");
}

TEST_CASE("an extraction with time enough reads many blocks at once, one with little no more than there is time for") {
  const LoadingSample& s = sample();
  for (const std::size_t i : {std::size_t{0}, std::size_t{3}}) {
    INFO("request " << i);
    Request request = s.requests[i];
    const Extraction whole = Dataset::open_memory(s.bytes)->extract(request);
    request.max_milliseconds = 1e7;
    const Extraction timed = Dataset::open_memory(s.bytes)->extract(request);
    CHECK(timed.bytes_read == whole.bytes_read);
    CHECK(timed.read_requests < whole.read_requests + s.blocks.size() / 3);

    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto slow = Dataset::open(source);
    const std::uint64_t opening = slow->bytes_read();
    std::uint64_t longest = 0;
    for (const file::BlockInfo& block : s.blocks)
      longest = std::max<std::uint64_t>(longest, block.stored_bytes);
    source->set([](std::uint64_t, std::uint64_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
      return false;
    });
    request.max_milliseconds = 20;
    const Extraction answer = slow->extract(request);
    CHECK(answer.limited_by == LimitedBy::kTime);
    CHECK(answer.bytes_read > opening);
    CHECK(answer.bytes_read - opening <= longest);
    check_sound(answer);
  }
}

TEST_CASE("what was read is made use of, though the last of it came late") {
  const LoadingSample& s = sample();
  const auto quick = Dataset::open_memory(s.bytes);
  const std::uint64_t opening = quick->bytes_read();
  Request request;
  request.focus.push_back({Box{quick->info().box_min, quick->info().box_max}});
  const Extraction all = quick->extract(request);
  REQUIRE(all.mesh.tets.size() == quick->info().tets);

  const auto source = std::make_shared<FailingSource>(s.bytes);
  const auto dataset = Dataset::open(source);
  std::atomic<std::uint64_t> bytes{0};
  source->set([&](std::uint64_t, std::uint64_t size) {
    if ((bytes += size) >= all.bytes_read - opening) std::this_thread::sleep_for(std::chrono::milliseconds(300));
    return false;
  });
  request.max_milliseconds = 250;
  const Extraction late = dataset->extract(request);
  CHECK(late.bytes_read == all.bytes_read);
  CHECK(late.mesh.tets.size() == all.mesh.tets.size());
}

TEST_CASE("who has little time does not wait for a thread that reads") {
  const LoadingSample& s = sample();
  const auto source = std::make_shared<FailingSource>(s.bytes);
  const auto dataset = Dataset::open(source);
  Session session(dataset);
  Gate gate;
  source->set([&](std::uint64_t, std::uint64_t) {
    gate.pass();
    return false;
  });
  std::atomic<bool> is_read{false};
  std::thread reader([&] {
    (void)dataset->extract({});
    is_read = true;
  });
  gate.wait_for_reader();
  Request request = s.requests[3];
  request.max_milliseconds = 20;
  const SessionUpdate& update = session.update(request);
  const Extraction extraction = dataset->extract(request);
  CHECK_FALSE(is_read);
  CHECK_FALSE(update.complete);
  CHECK(update.limited_by == LimitedBy::kTime);
  CHECK(update.failures.empty());
  CHECK(extraction.limited_by == LimitedBy::kTime);
  CHECK(extraction.failures.empty());
  CHECK(extraction.mesh.tets.size() == dataset->info().base_tets);
  gate.open();
  reader.join();
  for (int round = 0; round < 100 && !session.update(request).complete; ++round) {
  }
  CHECK(difference(session, session.update(s.requests[3]), s.answers[3]) == "");
}

TEST_CASE("an extraction is cancelled while it reads and while it waits for another that does") {
  const LoadingSample& s = sample();
  const bool is_limited = GENERATE(false, true);
  OpenOptions options;
  if (is_limited) options.memory_limit = s.decoded_bytes / 2;
  const auto source = std::make_shared<FailingSource>(s.bytes);
  const auto dataset = Dataset::open(source, options);
  const std::uint64_t opened = source->reads();
  source->set([&](std::uint64_t offset, std::uint64_t count) {
    std::this_thread::sleep_for(std::chrono::milliseconds(6));
    // No more than one block at a time.
    return std::any_of(s.blocks.begin(), s.blocks.end(), [&](const file::BlockInfo& block) {
      return block.offset > offset && block.offset < offset + count;
    });
  });
  int asked = 0;
  const auto third_time = [&](const Progress&) { return ++asked < 3; };
  const auto is_cancelled = [&] {
    asked = 0;
    try {
      (void)dataset->extract({}, third_time);
    } catch (const Error& error) {
      return error.code() == ErrorCode::kCancelled;
    }
    return false;
  };
  CHECK(is_cancelled());
  CHECK(source->reads() - opened <= 4);

  source->set({});
  Request hurried = error_request(0.3);
  const Extraction there = dataset->extract(hurried);
  REQUIRE(there.complete);
  REQUIRE(there.mesh.tets.size() > dataset->info().base_tets);
  Gate gate;
  source->set([&](std::uint64_t, std::uint64_t) {
    gate.pass();
    return false;
  });
  std::thread reader([&] { (void)dataset->extract({}); });
  gate.wait_for_reader();
  const std::uint64_t reads = source->reads();
  CHECK(is_cancelled());
  CHECK(source->reads() == reads);
  hurried.max_milliseconds = 20;
  CHECK(same_mesh(dataset->extract(hurried), there)); // what is in memory does not take its turn
  CHECK(source->reads() == reads);
  gate.open();
  reader.join();
  source->set({});
  if (is_limited)
    CHECK(dataset->extract({}).limited_by == LimitedBy::kMemory);
  else
    CHECK(same_mesh(dataset->extract({}), s.answers[0]));
}

TEST_CASE("a source, or a report of progress, that asks its own dataset gets an error and does not wait for itself") {
  const LoadingSample& s = sample();
  const file::Reader reader(file::over_memory(s.bytes));
  std::uint64_t decoded_bytes = 0;
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b)
    decoded_bytes += reader.decoded_bytes(b);
  for (const bool limited : {false, true}) {
    INFO("limited " << limited);
    OpenOptions options;
    if (limited) options.memory_limit = decoded_bytes / 2;
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source, options);
    int refused = 0;
    std::uint64_t reads = 0;
    const auto asks_again = [&] {
      try {
        (void)dataset->extract({});
      } catch (const Error& error) {
        refused += error.code() == ErrorCode::kBadArgument ? 1 : 0;
        throw;
      }
    };
    source->set([&](std::uint64_t, std::uint64_t) {
      asks_again();
      return false;
    });
    const Extraction lacking = dataset->extract({});
    CHECK(refused > 0);
    CHECK_FALSE(lacking.complete);
    CHECK((limited || lacking.failures.at(0).message.find("from within") != std::string::npos));
    source->set([](std::uint64_t, std::uint64_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
      return false;
    });
    refused = 0;
    const auto progress = [&](const Progress&) {
      if (source->reads() > reads) asks_again();
      return true;
    };
    reads = source->reads();
    CHECK_THROWS_AS(dataset->extract({}, progress), Error);
    CHECK(refused == 1);
    CHECK(dataset->extract({}).complete == !limited);
  }
}

TEST_CASE("the last reference to a dataset may go within a read by its own thread") {
  const LoadingSample& s = sample();
  for (const bool has_session : {false, true}) {
    INFO("session " << has_session);
    std::promise<void> gone;
    std::shared_ptr<FailingSource> source(new FailingSource(s.bytes), [&](FailingSource* ended) {
      delete ended;
      gone.set_value();
    });
    OpenOptions options;
    options.background = true;
    auto dataset = Dataset::open(source, options);
    std::optional<Session> session;
    if (has_session) session.emplace(dataset);
    Gate gate;
    source->set([&](std::uint64_t, std::uint64_t) {
      gate.pass();
      session.reset();
      dataset.reset();
      return false;
    });
    source.reset();
    (void)dataset->extract({});
    gate.open();
    CHECK(gone.get_future().wait_for(std::chrono::seconds(60)) == std::future_status::ready);
  }
}

TEST_CASE("a source that waits for its dataset, read in the background, is refused") {
  const LoadingSample& s = sample();
  const auto source = std::make_shared<test::FailingSource>(s.bytes);
  OpenOptions options;
  options.background = true;
  const auto dataset = Dataset::open(source, options);
  std::atomic<int> refused = 0;
  source->set([&](std::uint64_t, std::uint64_t) {
    try {
      dataset->wait_until_loaded();
    } catch (const Error& error) {
      refused += error.code() == ErrorCode::kBadArgument ? 1 : 0;
    }
    return false;
  });
  (void)dataset->extract({});
  dataset->wait_until_loaded();
  CHECK(refused > 0);
  CHECK(dataset->extract({}).complete);
}

TEST_CASE("loading that is cancelled leaves the blocks that were decoded, closed and sound") {
  const LoadingSample& s = sample();
  std::set<std::ptrdiff_t> counts;
  for (int most = 1; most < 6; ++most) {
    Hierarchy hierarchy(file::over_memory(s.bytes));
    int asked = 0;
    const ProgressCallback progress = [&](const Progress&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(6)); // so that it is asked the next time, too
      return ++asked <= most;
    };
    BlockSet all(s.blocks.size(), 1);
    try {
      Cancellation cancellation(progress);
      hierarchy.loader().load(all, &cancellation);
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kCancelled);
      CHECK(asked == most + 1);
    }
    const BlockSet loaded = hierarchy.content().block_loaded;
    counts.insert(std::count(loaded.begin(), loaded.end(), 1));
    BlockSet closed = loaded;
    hierarchy.close(closed);
    CHECK(closed == loaded);
    const bool is_whole = closed == BlockSet(s.blocks.size(), 1);
    if (!is_whole) CHECK(hierarchy.content().refinement.validate().empty()); // packed once it is
    all.assign(s.blocks.size(), 1);
    hierarchy.loader().load(all);
    CHECK(hierarchy.loader().holds(BlockSet(s.blocks.size(), 1)));
  }
  CHECK(counts.size() >= 3); // none, some, all
}

TEST_CASE("an update of a session that is cancelled has changed nothing, and the next one goes on") {
  const LoadingSample& s = long_sample();
  const bool is_limited = GENERATE(false, true);
  CAPTURE(is_limited);
  OpenOptions options;
  if (is_limited) options.memory_limit = s.decoded_bytes * 3 / 4;
  int cancelled = 0, read_before = 0, restarted = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const auto dataset = Dataset::open_memory(s.bytes, options);
    const auto whole = Dataset::open_memory(s.bytes);
    Session session(dataset);
    SlotCopy copy;
    RandomRequests requests(dataset->info(), 211 + seed);
    copy.follow(session, session.update(error_request(1)));
    for (int i = 0; i < 8; ++i) {
      CAPTURE(seed, i);
      const Extraction before = session.extraction();
      const Request request = requests.next();
      int asked = 0;
      const auto cancels = [&](const Progress&) {
        std::this_thread::sleep_for(std::chrono::milliseconds(6)); // so that it is asked the next time, too
        return ++asked <= i % 4;
      };
      try {
        copy.follow(session, session.update(request, cancels));
      } catch (const Error& error) {
        REQUIRE(error.code() == ErrorCode::kCancelled);
        REQUIRE(asked == i % 4 + 1);
        ++cancelled;
        if (asked > 1) ++read_before;
        REQUIRE(copy.difference(session) == "");
        const Extraction after = session.extraction();
        REQUIRE(same_mesh(after, before));
        REQUIRE(after.limited_by == before.limited_by);
        REQUIRE(after.made_by == before.made_by); // it is of the request before
        REQUIRE(after.in_focus.size() == before.in_focus.size());
        REQUIRE(after.at_values.size() == before.at_values.size());
        REQUIRE(after.in_view.has_value() == before.in_view.has_value());
      }
      if (i % 3 == 0) continue; // another one comes before it is met
      const SessionUpdate& update = session.update(request);
      copy.follow(session, update);
      if (update.renumbered) ++restarted;
      REQUIRE(copy.difference(session) == "");
      if (update.complete) REQUIRE(difference(session, update, whole->extract(request)) == "");
    }
  }
  CHECK(cancelled > 20);
  CHECK(read_before > 5);
  if (!is_limited) CHECK(restarted < 4); // where hardly any slots were used any more
}

TEST_CASE("progress is told now and then, however many blocks there are") {
  const LoadingSample& s = sample();
  for (const Request& asked : s.requests) {
    Request request = asked;
    request.max_milliseconds = 1e6;
    int calls = 0;
    const auto begin = std::chrono::steady_clock::now();
    const Extraction extraction = Dataset::open_memory(s.bytes)->extract(request, [&](const Progress&) {
      ++calls;
      return true;
    });
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    CHECK(extraction.complete);
    CHECK(calls >= 1);
    CHECK(calls <= 1 + 300 * seconds);
  }
}

TEST_CASE("origins tell errors, levels and generations") {
  const LoadingSample& s = sample();
  const auto dataset = Dataset::open_memory(s.bytes);
  Request request = error_request(0.1);
  const std::size_t fields = s.stream.fields.size();
  std::map<VertexId, std::size_t> brought; // by vertex of the original
  for (std::size_t i = 0; i < s.stream.removed.size(); ++i)
    brought[s.stream.removed[i]] = i;
  request.origins = true;
  const Extraction answer = dataset->extract(request);
  std::vector<double> values(answer.made_by.size());
  for (std::size_t f = 0; f <= fields; ++f) {
    dataset->origin_values(answer.made_by, f < fields ? OriginValue::kFieldError : OriginValue::kDomainError, f,
                           values);
    double most = 0;
    for (std::size_t t = 0; t < values.size(); ++t) {
      const RecordId r = answer.made_by[t];
      most = std::max(most, values[t]);
      if (r.is_none()) {
        CHECK(values[t] == 0);
        continue;
      }
      const std::size_t i = brought.at(s.to_original[s.base_vertices + r.index()]);
      const double exact = f < fields ? s.stream.field_error[i * fields + f] : s.stream.domain_error[i];
      CHECK(values[t] >= exact);
      CHECK(values[t] <= exact * 1.05 + 1e-9);
    }
    if (f < fields) CHECK(most == answer.field_error[f]);
  }
  const std::vector<std::size_t> places = places_in_budgets(s.stream);
  std::vector<double> generations(values.size());
  dataset->origin_values(answer.made_by, OriginValue::kLevel, 0, values);
  dataset->origin_values(answer.made_by, OriginValue::kGeneration, 0, generations);
  for (std::size_t t = 0; t < values.size(); ++t) {
    const RecordId r = answer.made_by[t];
    CHECK((values[t] == 0) == r.is_none());
    if (r.is_none()) continue;
    const std::size_t place = places.at(brought.at(s.to_original[s.base_vertices + r.index()]));
    const double share =
        static_cast<double>(s.base_vertices + place + 1) / static_cast<double>(dataset->info().vertices);
    CHECK(share <= std::pow(2.0, 1 - values[t]));
    CHECK(share >= std::pow(2.0, -values[t]));
    CHECK(generations[t] >= 0);
  }
  CHECK(*std::max_element(generations.begin(), generations.end()) > 1);
  const auto fresh = Dataset::open_memory(s.bytes);
  const std::vector<RecordId> last{RecordId{static_cast<std::uint32_t>(fresh->info().records - 1)}};
  std::vector<double> one(1);
  fresh->origin_values(last, OriginValue::kGeneration, 0, one);
  CHECK(std::isnan(one[0]));
  CHECK_THROWS_AS(fresh->origin_values(last, OriginValue::kFieldError, fields, one), Error);
  CHECK_THROWS_AS(fresh->origin_values(last, OriginValue::kLevel, 0, values), Error);
  const std::vector<RecordId> none_such{RecordId{static_cast<std::uint32_t>(fresh->info().records)}};
  CHECK_THROWS_AS(fresh->origin_values(none_such, OriginValue::kLevel, 0, one), Error);
}
