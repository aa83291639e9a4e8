// The order in which a writer goes through all blocks.
#include "formats/ptet/reader.hpp"
#include "formats/ptet/record_runs.hpp"
#include "formats/ptet/writer.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"

#include <algorithm>
#include <numeric>

#include <catch2/catch.hpp>

using namespace ptet;

TEST_CASE("runs in groups: every record once, after all that it waits for, and none waits within its group", "[file]") {
  const TetMesh mesh = test::grid({{16, 16, 16}, {}, 2, 5});
  const auto bytes = file::encode(mesh, test::simplify_naively(mesh), {});
  file::Reader reader(file::over_memory(bytes));
  file::Content content = reader.read_base();
  std::vector<std::uint32_t> all(reader.header().block_count);
  std::iota(all.begin(), all.end(), 0U);
  reader.load(all, content);
  REQUIRE(all.size() > 5);

  std::vector<char> is_done(reader.header().record_count);
  std::size_t together = 0;
  const auto groups = file::groups_of_runs(content.generation, reader.blocks());
  for (const std::vector<file::Run>& group : groups) {
    REQUIRE_FALSE(group.empty());
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < group.size(); ++i) {
      const file::Run& run = group[i];
      REQUIRE(run.first_record <= run.last_record);
      wrong += i > 0 && group[i - 1].open_block >= run.open_block ? 1 : 0;
      const file::BlockInfo& block = reader.blocks()[run.open_block];
      wrong += run.first_record > block.first_record && is_done[run.first_record - 1] == 0 ? 1 : 0;
      for (std::uint32_t r = run.first_record; r <= run.last_record; ++r) {
        wrong += content.generation[r] != run.generation || is_done[r] != 0 ? 1 : 0;
        for (const RecordId parent : content.refinement.parents(RecordId{r}))
          wrong += is_done[parent.index()] == 0 ? 1 : 0;
      }
    }
    for (const file::Run& run : group)
      std::fill(is_done.begin() + run.first_record, is_done.begin() + run.last_record + 1, 1);
    REQUIRE(wrong == 0);
    together += group.size() > 1 ? 1 : 0;
  }
  CHECK(std::count(is_done.begin(), is_done.end(), 0) == 0);
  CHECK(2 * together > groups.size());
}
