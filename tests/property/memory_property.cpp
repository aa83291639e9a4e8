// Datasets that may hold only part of a file in memory: blocks are dropped and read again, or answers are coarser and
// say so.
#include "lod/hierarchy.hpp"
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"
#include "support/file_parts.hpp"
#include "support/loading_sample.hpp"
#include "support/session_checks.hpp"

#include <algorithm>
#include <thread>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

TEST_CASE("within a limit of memory blocks are dropped and read again, or answers are coarser") {
  const LoadingSample& s = long_sample();
  std::size_t complete = 0, incomplete = 0;
  for (const double share : {0.15, 0.4, 0.7, 0.95}) {
    OpenOptions options;
    options.memory_limit = static_cast<std::uint64_t>(share * static_cast<double>(s.decoded_bytes));
    const auto dataset = Dataset::open_memory(s.bytes, options);
    for (int round = 0; round < 2; ++round)
      for (std::size_t i = 0; i < s.requests.size(); ++i) {
        INFO("share " << share << ", request " << i);
        const Extraction answer = dataset->extract(s.requests[i]);
        check_sound(answer, s);
        CHECK(same_mesh(answer, Dataset::open_memory(s.bytes, options)->extract(s.requests[i])));
        if (answer.complete) {
          CHECK(same_mesh(answer, s.answers[i]));
          ++complete;
        } else {
          CHECK(answer.limited_by == LimitedBy::kMemory);
          CHECK(answer.failures.empty());
          ++incomplete;
        }
      }
    std::vector<std::vector<char>> right(4);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < right.size(); ++t)
      threads.emplace_back([&, t] {
        for (std::size_t i = 0; i < s.requests.size(); ++i) {
          const std::size_t which = (t + i) % s.requests.size();
          const Extraction answer = dataset->extract(s.requests[which]);
          right[t].push_back(answer.complete                           ? same_mesh(answer, s.answers[which]) ? 1 : 0
                             : answer.limited_by == LimitedBy::kMemory ? 1
                                                                       : 0);
        }
      });
    for (std::thread& thread : threads)
      thread.join();
    for (const auto& answers : right)
      CHECK(std::count(answers.begin(), answers.end(), 1) == static_cast<std::ptrdiff_t>(s.requests.size()));
  }
  CHECK(complete > 4);
  CHECK(incomplete > 4);
}

TEST_CASE("with as much memory as a file says that it takes nothing is left out") {
  const LoadingSample& s = long_sample();
  OpenOptions options;
  options.limits.max_bytes = Dataset::open_memory(s.bytes)->info().memory_for_all;
  CHECK(same_mesh(Dataset::open_memory(s.bytes, options)->extract({}), s.answers[0]));
  --options.limits.max_bytes;
  const Extraction answer = Dataset::open_memory(s.bytes, options)->extract({});
  CHECK(answer.limited_by == LimitedBy::kMemory);
  CHECK(answer.mesh.tets.size() < s.answers[0].mesh.tets.size());
}

TEST_CASE("pinned blocks stay where memory is short, under the same ids") {
  const LoadingSample& s = long_sample();
  OpenOptions options;
  options.memory_limit = s.decoded_bytes * 6 / 10;
  Hierarchy hierarchy(file::over_memory(s.bytes), options);
  Loader& loader = hierarchy.loader();
  BlockSet first(s.blocks.size(), 0), all(s.blocks.size(), 1);
  first[0] = 1;
  loader.close(first);
  loader.pin(first);
  {
    const Loader::Turn turn(loader);
    BlockSet wanted = first;
    loader.load(wanted);
    REQUIRE(wanted == first);
  }
  std::uint64_t dropped = 0;
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b) {
    const Loader::Turn turn(loader);
    BlockSet wanted(s.blocks.size(), 0);
    wanted[b] = 1;
    loader.close(wanted);
    loader.load(wanted);
    const auto lock = hierarchy.lock();
    CHECK(loader.holds(first));
    CHECK(loader.holds(wanted));
    CHECK(hierarchy.content().refinement.validate().empty());
    dropped = loader.revision();
  }
  BlockSet wanted = all;
  {
    const Loader::Turn turn(loader);
    loader.load(wanted);
  }
  CHECK(wanted != all);
  loader.unpin(first);
  // Nothing holds them any more once other blocks take all the room.
  const auto lock = hierarchy.lock();
  std::uint64_t bytes = 0;
  file::Reader reader(file::over_memory(s.bytes));
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b)
    if (hierarchy.content().block_loaded[b] != 0) bytes += reader.decoded_bytes(b);
  CHECK(bytes <= options.memory_limit);
  CHECK(dropped > 0); // room was made, and not only refused
  CHECK(loader.revision() >= dropped);
}

TEST_CASE("limits are kept before anything is allocated, and named") {
  const LoadingSample& s = long_sample();
  const auto refusal = [&](const std::function<void(Limits&)>& change) {
    OpenOptions options;
    change(options.limits);
    try {
      (void)Dataset::open_memory(s.bytes, options);
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kLimit);
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(refusal([&](Limits& limits) { limits.max_vertices = s.mesh.vertex_count(); }).empty());
  CHECK(refusal([&](Limits& limits) { limits.max_vertices = s.mesh.vertex_count() - 1; }).find("vertices") !=
        std::string::npos);
  CHECK(refusal([&](Limits& limits) { limits.max_tets = s.mesh.tets.size(); }).empty());
  CHECK(refusal([&](Limits& limits) { limits.max_tets = s.mesh.tets.size() - 1; }).find("tets") != std::string::npos);
  CHECK(refusal([](Limits& limits) { limits.max_bytes = 0; }).find("memory") != std::string::npos);
  // A header that promises too much is refused before the mesh is made.
  CHECK(refusal([&](Limits& limits) { limits.max_bytes = s.mesh.vertex_count() * 100; }).find("memory") !=
        std::string::npos);
  // Where the fixed part fits, blocks are let in one by one.
  file::Reader reader(file::over_memory(s.bytes));
  OpenOptions options;
  options.limits.max_bytes = reader.fixed_bytes() + s.decoded_bytes / 2;
  const Extraction answer = Dataset::open_memory(s.bytes, options)->extract({});
  CHECK(answer.limited_by == LimitedBy::kMemory);
  check_sound(answer, s);
}

TEST_CASE("before the first update a session has the base mesh, whatever was dropped since") {
  const LoadingSample& s = long_sample();
  for (const double share : {0.15, 0.4, 0.7, 0.95}) {
    OpenOptions options;
    options.memory_limit = static_cast<std::uint64_t>(share * static_cast<double>(s.decoded_bytes));
    const auto dataset = Dataset::open_memory(s.bytes, options);
    const Session session(dataset);
    const Extraction base = session.extraction();
    CHECK(base.mesh.tets.size() == dataset->info().base_tets);
    RandomRequests requests(dataset->info(), 41, 2);
    for (int i = 0; i < 40; ++i) {
      (void)dataset->extract(requests.next());
      CHECK(same_mesh(session.extraction(), base));
    }
  }
}

TEST_CASE("sessions live on where memory is short") {
  const LoadingSample& s = long_sample();
  std::size_t complete = 0, incomplete = 0;
  for (const double share : {0.4, 0.7, 0.95}) {
    OpenOptions options;
    options.memory_limit = static_cast<std::uint64_t>(share * static_cast<double>(s.decoded_bytes));
    const auto dataset = Dataset::open_memory(s.bytes, options);
    std::vector<Session> sessions;
    for (int k = 0; k < 2; ++k)
      sessions.emplace_back(dataset);
    for (std::size_t i = 0; i < 4 * s.requests.size(); ++i) {
      INFO("share " << share << ", request " << i);
      (void)dataset->extract(
          s.requests[(i * 5 + 2) % s.requests.size()]); // what it needs drives out what others do not
      const std::size_t which = i % s.requests.size();
      Session& session = sessions[(i / 3) % 2];
      const SessionUpdate& update = session.update(s.requests[which]);
      if (update.complete) {
        CHECK(difference(session, update, s.answers[which]) == "");
        ++complete;
      } else {
        CHECK(update.limited_by == LimitedBy::kMemory);
        check_sound(session.extraction(), s);
        ++incomplete;
      }
    }
  }
  CHECK(complete > 10);
  CHECK(incomplete > 4);
}

TEST_CASE("what is dropped where memory is short need not be read again at once") {
  const LoadingSample& s = long_sample();
  const auto source = std::make_shared<FailingSource>(s.bytes);
  OpenOptions options;
  options.memory_limit = s.decoded_bytes * 9 / 10;
  const auto dataset = Dataset::open(source, options);
  std::uint64_t stored = 0, answered = 0;
  for (const file::BlockInfo& block : s.blocks)
    stored += block.stored_bytes;
  const std::uint64_t opened = source->bytes_given();
  for (int round = 0; round < 6; ++round)
    for (const Request& request : s.requests)
      answered += dataset->extract(request).complete ? 1 : 0;
  CHECK(answered >= 6);
  CHECK(source->bytes_given() - opened <= stored);
}
