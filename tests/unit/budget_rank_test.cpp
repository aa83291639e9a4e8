#include "record/budget_rank.hpp"
#include "support/brute_force.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/stream_extras.hpp"

#include <algorithm>

#include <catch2/catch.hpp>

using namespace ptet;

TEST_CASE("budgets: without weights the last collapse is undone first", "[budget]") {
  const RecordStream stream = test::simplify_naively(test::grid({}));
  const std::vector<std::uint32_t> rank = budget_rank(stream, StreamParents(stream));
  REQUIRE(rank.size() == stream.size());
  for (std::size_t r = 0; r < rank.size(); ++r)
    CHECK(rank[r] == rank.size() - 1 - r);
}

TEST_CASE("budgets: records stand where the least of three orders has them, parents first", "[budget]") {
  for (const auto& [name, mesh] : test::sample_meshes(7)) {
    INFO(name);
    RecordStream stream = test::simplify_naively(mesh);
    test::add_random_dependencies(stream, 5);
    test::add_random_squared_errors(stream, 6);
    const auto check = [&] {
      const StreamParents parents(stream);
      const std::vector<std::uint32_t> rank = budget_rank(stream, parents);
      const std::vector<std::size_t> expected = test::places_in_budgets(stream);
      CHECK(std::equal(rank.begin(), rank.end(), expected.begin(), expected.end()));
      bool parents_first = true;
      for (std::size_t r = 0; r < rank.size(); ++r)
        for_each_parent(stream, parents, r, [&](std::uint32_t parent) { parents_first &= rank[parent] < rank[r]; });
      CHECK(parents_first);
      return rank;
    };
    test::add_budget_weights(stream);
    const auto by_all = check();
    stream.budget.mean = false;
    const auto by_maximum = check();
    stream.budget.maximum.clear();
    stream.budget.mean = true;
    const auto by_mean = check();
    CHECK(by_all != by_maximum);
    CHECK(by_all != by_mean);
    CHECK(by_maximum != by_mean);
  }
}

TEST_CASE("budgets: an error far above all others is the first to go, and one that weighs nothing is not", "[budget]") {
  RecordStream stream = test::simplify_naively(test::grid({}));
  test::add_budget_weights(stream);
  stream.budget.mean = false;
  const StreamParents parents(stream);
  // Of the first round, so that nothing depends on it.
  stream.field_error[0] = 1000 * stream.fields[0].scale();
  std::vector<std::uint32_t> rank = budget_rank(stream, parents);
  std::size_t needed = 0; // by it: all that must be undone before
  std::vector<char> is_needed(stream.size(), 0);
  is_needed[0] = 1;
  for (std::size_t r = 0; r < stream.size(); ++r)
    if (is_needed[r] != 0) {
      ++needed;
      for_each_parent(stream, parents, r, [&](std::uint32_t parent) { is_needed[parent] = 1; });
    }
  CHECK(rank[0] <= 2 * needed); // half its place counts
  stream.budget.maximum.assign(stream.fields.size(), 0);
  stream.budget.domain = 0;
  rank = budget_rank(stream, parents);
  CHECK(rank[0] == stream.size() - 1);
}
