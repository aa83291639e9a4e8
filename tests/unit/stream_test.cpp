#include "record/stream.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

const RecordStream& good() {
  static const RecordStream stream = test::simplify_naively(test::grid({{3, 3, 2}, {}, 2, 4}));
  return stream;
}

// What validate() says of the stream once `spoil` has been at it.
template <class Spoil>
std::string verdict(Spoil&& spoil) {
  RecordStream stream = good();
  spoil(stream);
  return stream.validate();
}

} // namespace

TEST_CASE("record stream: what the simplifier makes is valid") {
  REQUIRE(good().size() > 10);
  CHECK(good().validate() == "");
  CHECK(RecordStream{}.validate() == "");
}

TEST_CASE("record stream: every spoiled one is found out") {
  CHECK(verdict([](RecordStream& s) { s.target.pop_back(); }) != "");
  CHECK(verdict([](RecordStream& s) { s.stars.pop_back(); }) != "");
  CHECK(verdict([](RecordStream& s) { s.field_error.pop_back(); }) != "");
  CHECK(verdict([](RecordStream& s) { s.star_begin[3] = s.star_begin[4] + 1; }) != "");
  CHECK(verdict([](RecordStream& s) { s.star_begin[3] = ~0ULL; }) != "");
  CHECK(verdict([](RecordStream& s) { std::swap(s.removed[0], s.target[0]); }) != "");
  CHECK(verdict([](RecordStream& s) { s.removed[0] = kDummyVertex; }) != "");
  CHECK(verdict([](RecordStream& s) { s.target[0] = s.removed[0]; }) != "");
  CHECK(verdict([](RecordStream& s) { s.removed[1] = s.removed[0]; }) != "");
  CHECK(verdict([](RecordStream& s) { s.stars[0] = ~0U; }) != "");
  CHECK(verdict([](RecordStream& s) { s.stars[1] = s.stars[0]; }) != "");
  CHECK(verdict([](RecordStream& s) { ++s.modified_count[0]; }) != "");
  CHECK(verdict([](RecordStream& s) { s.slots[0][0] = s.slots[0][1]; }) != "");
  CHECK(verdict([](RecordStream& s) { s.slots.push_back(s.slots[0]); }) != "");
  CHECK(verdict([](RecordStream& s) { std::swap(s.slots[s.stars[0]], s.slots[s.stars.back()]); }) != "");
  CHECK(verdict([](RecordStream& s) { --s.original_tet_count; }) != "");
  CHECK(verdict([](RecordStream& s) { s.round.assign(s.size(), 0); }) != "");
  CHECK(verdict([](RecordStream& s) { s.round.front() = 1000; }) != "");
  CHECK(verdict([](RecordStream& s) { s.field_error[0] = NAN; }) != "");
  CHECK(verdict([](RecordStream& s) { s.domain_error[0] = -1; }) != "");
  CHECK(verdict([](RecordStream& s) { s.fields[0].range = INFINITY; }) != "");
  CHECK(verdict([](RecordStream& s) { s.also_needs.push_back(1); }) != "");
  CHECK(verdict([](RecordStream& s) { s.volume = -1; }) != "");
  CHECK(verdict([](RecordStream& s) { s.squared_error.assign(s.field_error.size(), 0); }) != ""); // but no volumes
  CHECK(verdict([](RecordStream& s) { s.also_needs_begin.pop_back(); }) != "");
}

TEST_CASE("record stream: each table has its length, each number its range, and the verdict says which") {
  struct Way {
    const char* says;
    void (*spoil)(RecordStream&);
  };
  const char* const length = "differ in length";
  const char* const no_error = "errors is negative or not a finite number";
  const Way ways[] = {
      {length, [](RecordStream& s) { s.round.pop_back(); }},
      {length, [](RecordStream& s) { s.modified_count.pop_back(); }},
      {length, [](RecordStream& s) { s.domain_error.pop_back(); }},
      {length, [](RecordStream& s) { s.star_begin.pop_back(); }},
      {length, [](RecordStream& s) { s.outside_error.assign(1, 0); }},
      {"offsets of the stars do not span", [](RecordStream& s) { s.star_begin.front() = 1; }},
      {"offsets of the other records needed do not", [](RecordStream& s) { s.also_needs_begin.front() = 1; }},
      {"not as many slots as original", [](RecordStream& s) { s.slots.resize(s.original_tet_count); }},
      {"volume is no finite number", [](RecordStream& s) { s.volume = INFINITY; }},
      {"diagonal is no length", [](RecordStream& s) { s.diagonal = -1; }},
      {"diagonal is no length", [](RecordStream& s) { s.diagonal = INFINITY; }},
      {"range of array", [](RecordStream& s) { s.fields[0].range = -1; }},
      {"does not have four vertices", [](RecordStream& s) { s.slots[1][2] = VertexId{}; }},
      {"does not have four vertices", [](RecordStream& s) { s.slots[1][0] = VertexId{}; }},
      {"a tet among the ghosts", [](RecordStream& s) { s.slots[0][3] = kDummyVertex; }},
      {"not two vertices of the mesh", [](RecordStream& s) { s.target[0] = kDummyVertex; }},
      {"was removed before", [](RecordStream& s) { s.target[1] = s.removed[0]; }},
      {"offsets of its star decrease", [](RecordStream& s) { s.star_begin[1] = s.stars.size() + 1; }},
      {"a slot that is not there", [](RecordStream& s) { s.stars[0] = static_cast<std::uint32_t>(s.slots.size()); }},
      {"a slot that was deleted", [](RecordStream& s) { s.stars[s.star_begin[1]] = s.deleted(0).front(); }},
      {"taken in its own round", [](RecordStream& s) { s.stars[s.star_begin[1]] = s.modified(0).front(); }},
      {"do not lead to what the slots hold", [](RecordStream& s) { ++s.modified_count[0]; }},
      {"modifies nothing", [](RecordStream& s) { s.modified_count[0] = 0; }},
      {"not one that it modifies", [](RecordStream& s) { std::swap(s.stars.front(), s.stars[s.star_begin[1] - 1]); }},
      {no_error, [](RecordStream& s) { s.domain_error[2] = INFINITY; }},
      {no_error, [](RecordStream& s) { s.outside_error.assign(s.field_error.size(), -1); }},
      {"other records it needs decrease", [](RecordStream& s) { s.also_needs_begin[1] = 1; }},
  };
  for (const Way& way : ways) {
    const std::string said = verdict(way.spoil);
    INFO(way.says << "; said: " << said);
    CHECK(said.find(way.says) != std::string::npos);
  }
}

TEST_CASE("record stream: squared errors of all records, or none") {
  const auto with = [](std::size_t missing, double value) {
    return [=](RecordStream& s) {
      s.volume = 1;
      s.squared_error.assign(s.field_error.size() - missing, value);
      s.uncovered_volume.assign(s.size(), value);
    };
  };
  const auto with_uncovered = [&](std::size_t missing, double value) {
    return [=](RecordStream& s) {
      with(0, 1)(s);
      s.uncovered_volume.assign(s.size() - missing, value);
    };
  };
  CHECK(verdict(with(0, -1)) == "");
  CHECK(verdict(with(1, 1)) != "");
  CHECK(verdict(with(0, NAN)) != "");
  CHECK(verdict(with_uncovered(0, -1)) == "");
  CHECK(verdict(with_uncovered(1, 1)) != "");
  CHECK(verdict(with_uncovered(0, INFINITY)) != "");
  RecordStream stream = good();
  CHECK_FALSE(stream.has_squared_errors());
  stream.volume = 1;
  CHECK_FALSE(stream.has_squared_errors());
  with(0, 1)(stream);
  CHECK(stream.has_squared_errors());
  stream.uncovered_volume.clear();
  CHECK_FALSE(stream.has_squared_errors());
}

TEST_CASE("record stream: other records needed are later ones, ascending") {
  const auto needed_by_record_2 = [](std::vector<std::uint32_t> others) {
    return [others](RecordStream& s) {
      s.also_needs = others;
      std::fill(s.also_needs_begin.begin() + 3, s.also_needs_begin.end(), others.size());
    };
  };
  CHECK(verdict(needed_by_record_2({3, 5})) == "");
  CHECK(verdict(needed_by_record_2({5, 3})) != "");
  CHECK(verdict(needed_by_record_2({5, 5})) != "");
  CHECK(verdict(needed_by_record_2({2})) != "");
  CHECK(verdict(needed_by_record_2({static_cast<std::uint32_t>(good().size())})) != "");
}
