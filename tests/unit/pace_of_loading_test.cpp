#include "lod/pace_of_loading.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

using namespace ptet;

TEST_CASE("pace of loading: one thing first, however much it is") {
  const PaceOfLoading pace;
  for (const bool is_first : {true, false}) {
    const LoadingLimit limit = pace.limit(1, is_first);
    CHECK(limit.allows(0, 1e6));
    CHECK_FALSE(limit.allows(1, 1));
  }
}

TEST_CASE("pace of loading: more and more where there is time") {
  PaceOfLoading pace;
  pace.note(100, 0.001);
  CHECK(pace.limit(1, false).allows(0, 5000)); // one thing more, as there is time for it
  CHECK(pace.limit(1, false).allows(350, 50));
  CHECK_FALSE(pace.limit(1, false).allows(350, 51));
  pace.note(60, 0.0006); // a little between
  CHECK(pace.limit(1, false).allows(350, 50));
}

TEST_CASE("pace of loading: what was quick is not taken for what is much") {
  PaceOfLoading pace;
  pace.note(33, 0.001); // a block of one record
  const LoadingLimit limit = pace.limit(0.016, false);
  CHECK(limit.allows(0, 33));
  CHECK(limit.allows(0, 33 * 16));
  CHECK_FALSE(limit.allows(0, 33 * 16 + 1));
}

TEST_CASE("pace of loading: nothing more when the time is up, but one thing the first time") {
  PaceOfLoading pace;
  pace.note(33, 0.01);
  CHECK_FALSE(pace.limit(0, false).allows(0, 1));
  CHECK_FALSE(pace.limit(-1, false).allows(0, 1));
  CHECK(pace.limit(0, false).allows(0, 0)); // what is there
  CHECK(pace.limit(-1, true).allows(0, 1e6));
}

TEST_CASE("pace of loading: where none could be had there is one thing first, and no more without time") {
  const PaceOfLoading pace;
  CHECK(pace.limit(-1, true).allows(0, 1e6));
  CHECK(pace.limit(1, false).allows(0, 1e6));
  CHECK_FALSE(pace.limit(-1, false).allows(0, 1));
}

TEST_CASE("pace of loading: where every answer takes its time more is loaded at once") {
  const auto calls = [](const auto& late) { // for 300 things of 100, with 8 ms a call and 50 ms an answer
    PaceOfLoading pace;
    double done = 0, work = 100;
    int count = 0;
    while (done < 30000) {
      done += work;
      pace.note(work, 0.05 + 1e-6 * work + late(count++));
      CHECK_FALSE(pace.limit(-0.05, false).allows(0, 100)); // but only the first time
      work = std::max(100 * std::floor(pace.limit(0.008, true).together / 100), 100.0);
    }
    return count;
  };
  CHECK(calls([](int) { return 0.0; }) < 12);
  for (int one = 0; one < 10; ++one) {
    INFO("late: " << one);
    CHECK(calls([&](int i) { return i == one ? 0.1 : 0.0; }) < 30);
    CHECK(calls([&](int i) { return i <= one ? -0.05 : 0.0; }) < 30); // quick at first
  }
}

TEST_CASE("pace of loading: where the time goes with the work more is tried now and then") {
  PaceOfLoading pace;
  double work = 100;
  int passed = 0;
  for (int i = 0; i < 1000; ++i) {
    pace.note(work, 1e-4 * work);
    work = std::max(100 * std::floor(pace.limit(0.008, true).together / 100), 100.0);
    CHECK(work <= 200);
    passed += work > 100 ? 1 : 0;
  }
  CHECK(passed <= 12);
}

TEST_CASE("part to load: blocks come with what they need, while there is time") {
  std::vector<file::BlockInfo> blocks(4);
  for (file::BlockInfo& block : blocks)
    block.record_count = 68; // a work of 100
  blocks[2].needs = {0};
  blocks[3].needs = {1};
  const BlockNeeds needs(blocks);
  const BlockSet loaded{1, 0, 0, 0}, none(4, 0);
  const LoadingLimit limit{250, 250};

  PartToLoad part(needs, loaded, none);
  CHECK(part.add(2, none, &limit) == std::vector<std::uint32_t>{2, 0});
  CHECK(part.work() == 100); // block 0 takes none
  CHECK(part.add(0, none, &limit) == std::vector<std::uint32_t>{});
  CHECK_FALSE(part.add(3, none, &limit)); // two blocks more, and there is time for one
  CHECK(part.blocks() == BlockSet{1, 0, 1, 0});
  CHECK(part.add(3, BlockSet{0, 1, 0, 0}, &limit) == std::vector<std::uint32_t>{});
  CHECK(part.add(3, none, nullptr) == std::vector<std::uint32_t>{3, 1});
  CHECK(part.work() == 300);
}

TEST_CASE("part to load: what was there at the start stays when the time is up") {
  std::vector<file::BlockInfo> blocks(4);
  const BlockNeeds needs(blocks);
  const BlockSet loaded{1, 0, 0, 0}, none(4, 0);
  PartToLoad part(needs, loaded, BlockSet{0, 1, 0, 0});
  CHECK(part.add(0, none, nullptr));
  CHECK(part.add(2, none, nullptr));
  part.keep_loaded();
  CHECK(part.blocks() == BlockSet{1, 1, 0, 0});
  CHECK(part.work() == 0);
}
