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
  CHECK(verdict([](RecordStream& s) { s.fine.pop_back(); }) != "");
  CHECK(verdict([](RecordStream& s) { s.field_error.pop_back(); }) != "");
  CHECK(verdict([](RecordStream& s) { s.fine_begin[3] = s.fine_begin[4] + 1; }) != "");
  CHECK(verdict([](RecordStream& s) { s.fine_begin[3] = ~0ULL; }) != "");
  CHECK(verdict([](RecordStream& s) { std::swap(s.removed[0], s.target[0]); }) != "");
  CHECK(verdict([](RecordStream& s) { s.removed[0] = kDummyVertex; }) != "");
  CHECK(verdict([](RecordStream& s) { s.target[0] = s.removed[0]; }) != "");
  CHECK(verdict([](RecordStream& s) { s.removed[1] = s.removed[0]; }) != "");
  CHECK(verdict([](RecordStream& s) { s.fine[0] = VersionId{}; }) != "");
  CHECK(verdict([](RecordStream& s) { s.fine[1] = s.fine[0]; }) != "");
  CHECK(verdict([](RecordStream& s) { ++s.modified_count[0]; }) != "");
  CHECK(verdict([](RecordStream& s) { s.coarse_begin[2] = VersionId{}; }) != "");
  CHECK(verdict([](RecordStream& s) { s.versions[0][0] = s.versions[0][1]; }) != "");
  CHECK(verdict([](RecordStream& s) { std::swap(s.versions.back()[0], s.versions.back()[1]); }) != "");
  CHECK(verdict([](RecordStream& s) { s.versions.push_back(s.versions[0]); }) != "");
  CHECK(verdict([](RecordStream& s) { --s.original_tet_count; }) != "");
  CHECK(verdict([](RecordStream& s) { s.round.assign(s.size(), 0); }) != "");
  CHECK(verdict([](RecordStream& s) { s.round.front() = 1000; }) != "");
  CHECK(verdict([](RecordStream& s) { s.field_error[0] = NAN; }) != "");
  CHECK(verdict([](RecordStream& s) { s.domain_error[0] = -1; }) != "");
  CHECK(verdict([](RecordStream& s) { s.fields[0].range = INFINITY; }) != "");
  CHECK(verdict([](RecordStream& s) { s.also_needs.push_back(1); }) != "");
  CHECK(verdict([](RecordStream& s) { s.volume = -1; }) != "");
  CHECK(verdict([](RecordStream& s) { s.squared_error.assign(s.field_error.size(), 0); }) != ""); // but no volume
  CHECK(verdict([](RecordStream& s) { s.also_needs_begin.pop_back(); }) != "");
}

TEST_CASE("record stream: squared errors of all records, or none") {
  const auto with = [](std::size_t missing, double value) {
    return [=](RecordStream& s) {
      s.volume = 1;
      s.squared_error.assign(s.field_error.size() - missing, value);
    };
  };
  CHECK(verdict(with(0, -1)) == "");
  CHECK(verdict(with(1, 1)) != "");
  CHECK(verdict(with(0, NAN)) != "");
  RecordStream stream = good();
  CHECK_FALSE(stream.has_squared_errors());
  stream.volume = 1;
  CHECK_FALSE(stream.has_squared_errors());
  with(0, 1)(stream);
  CHECK(stream.has_squared_errors());
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
