// Files with damaged blocks, and sources that fail: every answer must be a closed cut, conforming, with errors that are
// true, and say what it lacks; so must the mesh of a session, and what it says of its tets.
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"
#include "support/file_parts.hpp"
#include "support/loading_sample.hpp"
#include "support/mesh_checks.hpp"
#include "support/session_checks.hpp"

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

using Bytes = std::vector<std::byte>;

} // namespace

TEST_CASE("a damaged block makes answers coarser that depend on it, and is told") {
  const LoadingSample& s = sample();
  REQUIRE(s.blocks.size() >= 6);
  std::size_t incomplete = 0, complete = 0;
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b) {
    Bytes damaged = s.bytes;
    flip(damaged, 8 * s.blocks[b].offset + 77 % (8 * s.blocks[b].stored_bytes));
    const auto dataset = Dataset::open_memory(damaged);
    const auto left = left_without({b});
    for (std::size_t i = 0; i < s.requests.size(); ++i) {
      INFO("block " << b << ", request " << i);
      const Extraction extraction = dataset->extract(s.requests[i]);
      check_answer_without(i, extraction, left);
      if (extraction.complete) {
        CHECK(extraction.failures.empty());
        CHECK(same_mesh(extraction, s.answers[i]));
        ++complete;
      } else {
        REQUIRE(extraction.failures.size() == 1);
        CHECK(extraction.failures[0].block == b);
        CHECK(extraction.failures[0].byte_offset == s.blocks[b].offset);
        CHECK(extraction.failures[0].code == ErrorCode::kCorruptFile);
        CHECK(extraction.failures[0].message.find("hash") != std::string::npos);
        CHECK(extraction.limited_by == LimitedBy::kUnreadable);
        CHECK(extraction.mesh.tets.size() <= s.answers[i].mesh.tets.size());
        ++incomplete;
      }
      // The order of requests is no matter.
      CHECK(same_mesh(extraction, Dataset::open_memory(damaged)->extract(s.requests[i])));
    }
    CHECK_FALSE(dataset->extract({}).complete);
  }
  CHECK(incomplete > s.blocks.size());
  CHECK(complete > 0);
}

TEST_CASE("a block that is wrong under a right hash is found, or decodes to sound records") {
  const LoadingSample& s = sample();
  std::mt19937_64 random(9);
  std::size_t found = 0;
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b) {
    for (int bit = 0; bit < 4; ++bit) {
      FileParts parts(s.bytes);
      const auto rows = parts.rows();
      flip(parts.of(file::SectionKind::kBlocks), 8 * rows[b].info.offset + random() % (8 * rows[b].info.stored_bytes));
      parts.mend_blocks();
      const auto dataset = Dataset::open_memory(parts.join());
      for (std::size_t i = 0; i < s.requests.size(); ++i) {
        INFO("block " << b << ", request " << i);
        const Extraction extraction = dataset->extract(s.requests[i]);
        const MeshFacts facts = examine(extraction.mesh);
        CHECK(facts.repeated_tets + facts.crowded_faces == 0);
        CHECK(facts.components == s.facts.components);
        if (extraction.complete) continue;
        ++found;
        REQUIRE_FALSE(extraction.failures.empty());
        // What is wrong may be noticed in a block that builds on it. Nothing of either is in the answer.
        std::set<std::uint32_t> lost;
        for (const BlockFailure& failure : extraction.failures)
          lost.insert(failure.block);
        if (lost.count(b) != 0) check_answer_without(i, extraction, left_without(lost));
      }
    }
  }
  CHECK(found > 100);
}

TEST_CASE("every read fails in turn: opening is refused, answers are coarser, and trying again helps") {
  const LoadingSample& s = sample();
  std::size_t opened = 0;
  for (std::uint64_t failing = 1;; ++failing) {
    std::uint64_t count = 0;
    const auto source = std::make_shared<FailingSource>(
        s.bytes, [&count, failing](std::uint64_t, std::uint64_t) { return ++count == failing; });
    std::shared_ptr<const Dataset> dataset;
    try {
      dataset = Dataset::open(source);
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kIo);
      CHECK(std::string(error.what()).find("the line is dead") != std::string::npos);
      continue;
    }
    ++opened;
    for (std::size_t i = 0; i < s.requests.size(); ++i)
      check_sound(dataset->extract(s.requests[i]));
    for (std::size_t i = 0; i < s.requests.size(); ++i) {
      const Extraction again = dataset->extract(s.requests[i]);
      CHECK(again.complete);
      CHECK(same_mesh(again, s.answers[i]));
    }
    if (count < failing) break; // it never came to that read
  }
  CHECK(opened > 1);
}

TEST_CASE("of a source that is down nothing is asked twice for one request, nor what needs what was not had") {
  const LoadingSample& s = sample();
  for (const Request& request : s.requests) {
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source);
    std::map<std::pair<std::uint64_t, std::uint64_t>, int> asked;
    source->set([&asked](std::uint64_t offset, std::uint64_t count) { return ++asked[{offset, count}] > 0; });
    const auto check_asked = [&] {
      for (const auto& [range, times] : asked) {
        CHECK(times == 1);
        const auto block = std::find_if(s.blocks.begin(), s.blocks.end(), [&, at = range](const file::BlockInfo& b) {
          return b.offset == at.first && b.stored_bytes == at.second;
        });
        if (block != s.blocks.end()) CHECK(block->needs.empty());
      }
      asked.clear();
    };
    const Extraction extraction = dataset->extract(request);
    check_asked();
    for (const BlockFailure& failure : extraction.failures)
      CHECK(s.blocks[failure.block].needs.empty());
    Session session(dataset);
    CHECK(session.update(request).complete == extraction.complete);
    check_asked();
  }
}

TEST_CASE("a block that was garbled on its way is read once more, and one that is wrong again is given up") {
  const LoadingSample& s = sample();
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b) {
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source);
    source->garble(s.blocks[b].offset + s.blocks[b].stored_bytes / 2, 1);
    const Extraction whole = dataset->extract({});
    CHECK(whole.complete);
    CHECK(same_mesh(whole, s.answers[0]));

    const auto wrong_source = std::make_shared<FailingSource>(s.bytes);
    const auto wrong = Dataset::open(wrong_source);
    wrong_source->garble(s.blocks[b].offset, 2);
    for (int time = 0; time < 2; ++time) { // it is not tried again
      const Extraction extraction = wrong->extract({});
      CHECK_FALSE(extraction.complete);
      REQUIRE(extraction.failures.size() == 1);
      CHECK(extraction.failures[0].block == b);
      CHECK(extraction.failures[0].code == ErrorCode::kCorruptFile);
    }
  }
}

// With a time to keep blocks are read one after the other, with what they need: what failed once may be had the next
// time.
TEST_CASE("what is missing in the end is told, and nothing else") {
  const LoadingSample& s = sample();
  std::size_t complete = 0;
  for (std::uint64_t failing = 1, count = failing; count >= failing; ++failing) {
    count = 0;
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source);
    source->set([&count, failing](std::uint64_t, std::uint64_t) { return ++count == failing; });
    Request request = s.requests[failing % s.requests.size()];
    request.max_milliseconds = 1e6;
    const Extraction extraction = dataset->extract(request);
    CHECK(extraction.complete == extraction.failures.empty());
    if (!extraction.complete) continue;
    CHECK(same_mesh(extraction, s.answers[failing % s.requests.size()]));
    complete += count >= failing ? 1 : 0;
  }
  CHECK(complete > 0);
}

TEST_CASE("ranges that cannot be read cost what needs them, and no more") {
  const LoadingSample& s = sample();
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b) {
    const std::uint64_t bad = s.blocks[b].offset + s.blocks[b].stored_bytes / 2;
    const auto source = std::make_shared<FailingSource>(
        s.bytes, [bad](std::uint64_t offset, std::uint64_t count) { return offset <= bad && bad - offset < count; });
    OpenOptions options;
    options.max_gap = 1 << 16; // one request for all of them, then one for each
    const auto dataset = Dataset::open(source, options);
    for (std::size_t i = 0; i < s.requests.size(); ++i) {
      INFO("block " << b << ", request " << i);
      const Extraction extraction = dataset->extract(s.requests[i]);
      check_answer_without(i, extraction, left_without({b}));
      if (extraction.complete) continue;
      REQUIRE(extraction.failures.size() == 1);
      CHECK(extraction.failures[0].block == b);
      CHECK(extraction.failures[0].code == ErrorCode::kIo);
      CHECK(extraction.failures[0].byte_offset == s.blocks[b].offset);
    }
    source->set({});
    CHECK(same_mesh(dataset->extract({}), s.answers[0]));
  }
}

TEST_CASE("reads that fail at random") {
  const LoadingSample& s = sample();
  for (unsigned seed = 0; seed < 6; ++seed) {
    auto random = std::make_shared<std::mt19937>(seed);
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source);
    source->set([random](std::uint64_t, std::uint64_t) { return (*random)() % 3 == 0; });
    for (int round = 0; round < 4; ++round)
      for (std::size_t i = s.requests.size(); i-- > 0;) {
        const Extraction extraction = dataset->extract(s.requests[i]);
        check_sound(extraction);
        if (!extraction.failures.empty()) CHECK_FALSE(extraction.complete);
        if (extraction.complete) CHECK(same_mesh(extraction, s.answers[i]));
      }
    source->set({});
    for (std::size_t i = 0; i < s.requests.size(); ++i)
      CHECK(same_mesh(dataset->extract(s.requests[i]), s.answers[i]));
  }
}

TEST_CASE("few requests, and every byte counted") {
  const LoadingSample& s = sample();
  const auto source = std::make_shared<FailingSource>(s.bytes);
  const auto dataset = Dataset::open(source);
  CHECK(source->reads() <= 4);
  const Extraction full = dataset->extract({});
  CHECK(full.read_requests <= 5); // the blocks lie one behind the other
  CHECK(full.read_requests == source->reads());
  CHECK(full.bytes_read == source->bytes_given());
  CHECK(full.bytes_read == s.bytes.size());
  CHECK(dataset->extract({}).bytes_read == full.bytes_read);
}

TEST_CASE("a session over a damaged file has the meshes that extractions have") {
  const LoadingSample& s = sample();
  std::size_t incomplete = 0;
  for (std::uint32_t b = 0; b < s.blocks.size(); b += 2) {
    Bytes damaged = s.bytes;
    flip(damaged, 8 * s.blocks[b].offset + 77 % (8 * s.blocks[b].stored_bytes));
    const auto dataset = Dataset::open_memory(damaged);
    Session session(dataset);
    RandomRequests requests(dataset->info(), b, 3);
    for (int i = 0; i < 20; ++i) {
      INFO("block " << b << ", request " << i);
      const Request request = requests.next();
      const SessionUpdate& update = session.update(request);
      const Extraction answer = dataset->extract(request);
      CHECK(update.complete == answer.complete);
      CHECK(difference(session, update, answer) == (answer.complete ? "" : "it is not complete"));
      CHECK(same_mesh(session.extraction(), answer));
      CHECK(update.failures.size() == answer.failures.size());
      incomplete += answer.complete ? 0 : 1;
    }
  }
  CHECK(incomplete > s.blocks.size());
}

TEST_CASE("a block that turns out wrong under a session makes it start over") {
  const LoadingSample& s = sample();
  std::size_t damaged_files = 0;
  for (unsigned seed = 0; seed < 40 && damaged_files < 8; ++seed) {
    std::mt19937 random(seed);
    FileParts parts(s.bytes);
    Bytes& blocks = parts.of(file::SectionKind::kBlocks);
    flip(blocks, random() % (8 * blocks.size()));
    parts.mend_blocks();
    std::shared_ptr<const Dataset> dataset;
    try {
      dataset = Dataset::open_memory(parts.join());
    } catch (const Error&) {
      continue;
    }
    Session session(dataset);
    const SessionUpdate& coarse = session.update(error_request(0.3)); // before the damage is met, as a rule
    CHECK(coarse.tets > 0);
    for (const Request& request : {Request{}, error_request(0.02), error_request(0.3)}) {
      const SessionUpdate& update = session.update(request);
      const Extraction answer = dataset->extract(request);
      CHECK(difference(session, update, answer) == (answer.complete ? "" : "it is not complete"));
      damaged_files += answer.complete ? 0 : 1;
    }
  }
  CHECK(damaged_files > 4);
}

TEST_CASE("a session without time goes on to what can be read, and tells what cannot") {
  const LoadingSample& s = sample();
  const std::set<std::uint32_t> bad{static_cast<std::uint32_t>(s.blocks.size() / 2)};
  const auto source = std::make_shared<FailingSource>(s.bytes, [&](std::uint64_t offset, std::uint64_t count) {
    return std::any_of(bad.begin(), bad.end(), [&](std::uint32_t b) {
      return offset <= s.blocks[b].offset && s.blocks[b].offset - offset < count;
    });
  });
  const auto dataset = Dataset::open(source);
  Session session(dataset);
  Request request;
  request.max_milliseconds = 0;
  for (std::size_t round = 0; round < 100 * s.blocks.size(); ++round)
    if (session.update(request).limited_by != LimitedBy::kTime) break;
  const SessionUpdate& update = session.update(request);
  CHECK_FALSE(update.complete);
  CHECK(update.limited_by == LimitedBy::kUnreadable);
  CHECK(update.failures.size() == bad.size());
  const Extraction there = session.extraction();
  check_answer_without(0, there, left_without(bad));
  CHECK(there.mesh.tets == dataset->extract({}).mesh.tets);
  source->set({});
  for (std::size_t round = 0; round < 100 * s.blocks.size(); ++round)
    if (session.update(request).complete) break;
  CHECK(difference(session, session.update(request), s.answers[0]) == "");
}

TEST_CASE("a session with little time over a source that fails asks for a block once a call") {
  const LoadingSample& s = sample();
  const std::uint64_t bad = s.blocks[1].offset;
  std::uint64_t failed = 0;
  const auto source = std::make_shared<FailingSource>(s.bytes, [&](std::uint64_t offset, std::uint64_t count) {
    const bool fails = offset <= bad && bad - offset < count;
    failed += fails ? 1 : 0;
    return fails;
  });
  const auto dataset = Dataset::open(source);
  Session session(dataset);
  Request request;
  request.max_milliseconds = 1e6;
  failed = 0;
  const SessionUpdate& update = session.update(request);
  CHECK_FALSE(update.complete);
  CHECK(update.limited_by == LimitedBy::kUnreadable);
  REQUIRE(update.failures.size() == 1);
  CHECK(update.failures[0].block == 1);
  CHECK(failed <= 2); // with its neighbours, and alone
  CHECK(difference(session, update, dataset->extract({})) == "it is not complete");
  source->set({});
  CHECK(session.update(request).complete);
  CHECK(difference(session, session.update(request), s.answers[0]) == "");
}

TEST_CASE("a session knows what made its tets as far as blocks are there") {
  const LoadingSample& s = sample();
  for (unsigned seed = 0; seed < 4; ++seed) {
    // More and more of the file can be read: what was taken for an original tet turns out to be made.
    auto lost = std::make_shared<std::set<std::uint32_t>>();
    for (std::uint32_t b = 0; b < s.blocks.size(); ++b)
      lost->insert(b);
    const auto source = std::make_shared<FailingSource>(s.bytes, [&s, lost](std::uint64_t offset, std::uint64_t count) {
      return std::any_of(lost->begin(), lost->end(), [&](std::uint32_t b) {
        return offset < s.blocks[b].offset + s.blocks[b].stored_bytes && s.blocks[b].offset < offset + count;
      });
    });
    const auto dataset = Dataset::open(source);
    Session session(dataset);
    SlotCopy copy;
    std::mt19937 random(seed);
    RandomRequests requests(dataset->info(), seed, 10);
    std::size_t unknown = 0;
    for (int round = 0;; ++round) {
      Request request = requests.next();
      if (round % 2 == 0) { // what is read then is finer than what is split, and made tets that stay
        request = {};
        request.max_vertices = s.base_vertices + random() % (dataset->info().vertices / 3);
        request.origins = true;
      }
      const SessionUpdate& update = session.update(request);
      copy.follow(session, update);
      REQUIRE(copy.difference(session) == "");
      if (request.origins) {
        REQUIRE(difference(session, update, dataset->extract(request)) ==
                (update.complete ? "" : "it is not complete"));
        unknown += check_origins(session);
      }
      if (lost->empty()) {
        if (update.complete && request.origins) break;
        continue;
      }
      auto found = lost->begin();
      std::advance(found, random() % lost->size());
      lost->erase(found);
    }
    CHECK(unknown > 0);
    CHECK(check_origins(session) == 0);
  }
}
