#include "lod/pace_of_loading.hpp"

#include <catch2/catch.hpp>

using namespace ptet;

TEST_CASE("pace of loading: one thing first, however much it is") {
  const PaceOfLoading pace;
  CHECK(pace.has_time_for(0, 1e6));
  CHECK_FALSE(pace.has_time_for(1, 1));
}

TEST_CASE("pace of loading: more and more where there is time") {
  PaceOfLoading pace;
  pace.note(100, 0.001, 1);
  CHECK(pace.has_time_for(0, 5000)); // one thing more, as there is time for it
  CHECK(pace.has_time_for(350, 50));
  CHECK_FALSE(pace.has_time_for(350, 51));
  pace.note(33, 0.001, 1); // a little between
  CHECK(pace.has_time_for(350, 50));
}

TEST_CASE("pace of loading: what was quick is not taken for what is much") {
  PaceOfLoading pace;
  pace.note(33, 0.001, 0.016); // a block of one record
  CHECK(pace.has_time_for(0, 33));
  CHECK(pace.has_time_for(0, 33 * 16));
  CHECK_FALSE(pace.has_time_for(0, 33 * 16 + 1));
}

TEST_CASE("pace of loading: nothing more when the time is up") {
  PaceOfLoading pace;
  pace.note(33, 0.01, 0);
  CHECK_FALSE(pace.has_time_for(0, 1));
  pace.note(33, 0, -1);
  CHECK_FALSE(pace.has_time_for(0, 1));
  CHECK(pace.has_time_for(0, 0)); // what is there
}

TEST_CASE("part to load: blocks come with what they need, while there is time") {
  std::vector<file::BlockInfo> blocks(4);
  for (file::BlockInfo& block : blocks)
    block.record_count = 68; // a work of 100
  blocks[2].needs = {0};
  blocks[3].needs = {1};
  const BlockNeeds needs(blocks);
  const BlockSet loaded{1, 0, 0, 0}, none(4, 0);
  PaceOfLoading pace;
  pace.note(100, 1, 2.5);

  PartToLoad part(needs, loaded, none);
  CHECK(part.add(2, none, &pace) == std::vector<std::uint32_t>{2, 0});
  CHECK(part.work() == 100); // block 0 takes none
  CHECK(part.add(0, none, &pace) == std::vector<std::uint32_t>{});
  CHECK_FALSE(part.add(3, none, &pace)); // two blocks more, and there is time for one
  CHECK(part.blocks() == BlockSet{1, 0, 1, 0});
  CHECK(part.add(3, BlockSet{0, 1, 0, 0}, &pace) == std::vector<std::uint32_t>{});
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
