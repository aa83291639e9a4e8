#include "lod/loader.hpp"

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
