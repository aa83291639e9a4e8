// Streams of a plain simplifier played backwards, in many orders.
#include "formats/ptet/version_table.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/replay.hpp"

#include <algorithm>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

std::vector<Tet> original_versions(const RecordStream& stream) {
  std::vector<Tet> tets;
  for (const Tet& tet : stream.original())
    tets.push_back(test::sorted_keeping_orientation(tet));
  std::sort(tets.begin(), tets.end());
  return tets;
}

// Applies all records in a random order that respects `parents`.
void apply_in_random_order(test::Replay& replay, const RecordStream& stream,
                           const std::vector<std::vector<RecordId>>& parents, std::mt19937& random) {
  while (replay.refinement.applied_count() < stream.size()) {
    std::vector<RecordId> ready;
    for (std::uint32_t r = 0; r < stream.size(); ++r)
      if (!replay.refinement.applied(RecordId{r}) &&
          std::all_of(parents[r].begin(), parents[r].end(), [&](RecordId p) { return replay.refinement.applied(p); }))
        ready.push_back(RecordId{r});
    test::apply(replay, stream, ready[random() % ready.size()]);
  }
}

} // namespace

TEST_CASE("all records give back the original, its boundary too, and parents are as in the stream") {
  for (const auto& [name, mesh] : test::sample_meshes(11)) {
    INFO(name);
    const RecordStream stream = test::simplify_naively(mesh);
    REQUIRE(stream.validate() == "");
    REQUIRE(stream.size() > mesh.vertex_count() / 4);
    test::Replay replay = test::start_replay(mesh, stream);
    const auto parents = test::parents_in_stream(stream);
    for (std::uint32_t r = 0; r < stream.size(); ++r) {
      test::apply(replay, stream, RecordId{r});
      REQUIRE(replay.refinement.validate() == "");
      const auto found = replay.refinement.parents(RecordId{r});
      CHECK(std::vector<RecordId>(found.begin(), found.end()) == parents[r]);
    }
    CHECK(test::present(replay) == original_versions(stream));
  }
}

TEST_CASE("versions are the same, name by name, whatever the order of the records") {
  std::mt19937 random(5);
  const TetMesh mesh = test::grid({{4, 4, 2}, [](int x, int y, int) { return x != 1 || y != 1; }, 2, 3});
  const RecordStream stream = test::simplify_naively(mesh);
  const auto parents = test::parents_in_stream(stream);
  test::Replay one = test::start_replay(mesh, stream);
  for (std::uint32_t r = 0; r < stream.size(); ++r)
    test::apply(one, stream, RecordId{r});
  for (int round = 0; round < 5; ++round) {
    test::Replay other = test::start_replay(mesh, stream);
    apply_in_random_order(other, stream, parents, random);
    REQUIRE(other.refinement.validate() == "");
    const file::VersionTable one_table(one.refinement), other_table(other.refinement);
    for (std::uint32_t r = 0; r < stream.size(); ++r) {
      const RecordId record{r};
      REQUIRE(other.refinement.fine_count(record) == one.refinement.fine_count(record));
      CHECK(other.refinement.added_tet_count(record) == one.refinement.added_tet_count(record));
      CHECK(one.refinement.fine_tets(record) == other.refinement.fine_tets(record));
      for (std::uint32_t k = 0; k < one.refinement.fine_count(record); ++k) {
        CHECK(one_table.creator(one_table.number(record, k)) == other_table.creator(other_table.number(record, k)));
      }
    }
  }
}

TEST_CASE("random splits never break the refinement without saying so") {
  std::mt19937 random(17);
  const TetMesh mesh = test::grid({{3, 3, 3}, {}, 2, 9});
  int accepted = 0, refused = 0;
  for (int round = 0; round < 300; ++round) {
    const auto n = static_cast<std::uint32_t>(mesh.vertex_count());
    Refinement refinement(mesh.tets, n, 20);
    try {
      for (std::uint32_t r = 0; r < 20; ++r) {
        const auto seed = static_cast<std::uint32_t>(random() % refinement.place_count());
        const VertexId target = refinement.tet(seed)[random() % 4];
        const unsigned odds = 1 + random() % 6;
        refinement.split(RecordId{r}, target, std::span(&seed, 1),
                         [&](const GrowthFace&) { return random() % odds == 0; });
        REQUIRE(refinement.validate() == "");
        ++accepted;
      }
    } catch (const Error& error) {
      REQUIRE(error.code() == ErrorCode::kCorruptFile);
      ++refused;
    }
  }
  CHECK(accepted > 100);
  CHECK(refused > 100);
}
