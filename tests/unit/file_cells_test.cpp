#include "formats/ptet/cells.hpp"
#include "formats/ptet/ordering.hpp"
#include "record/budget_rank.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

struct Sample {
  TetMesh mesh = test::grid({{24, 4, 4}, {}, 2, 3});
  RecordStream records = test::simplify_naively(mesh);
  StreamParents parents{records};
};

std::vector<std::uint32_t> generations(const Sample& sample) {
  std::vector<std::uint32_t> generation(sample.records.size());
  for (std::size_t i = generation.size(); i-- > 0;)
    for_each_parent(sample.records, sample.parents, i,
                    [&](std::uint32_t parent) { generation[i] = std::max(generation[i], generation[parent] + 1); });
  return generation;
}

} // namespace

TEST_CASE("cells: each record is in one, which depends on none behind it") {
  const Sample sample;
  for (const std::size_t most : {20U, 100U, 100000U}) {
    const file::CellTree tree =
        file::divide_into_cells(sample.mesh, sample.records, sample.parents, generations(sample), most);
    const auto& cells = tree.cells;
    std::vector<std::size_t> home(sample.records.size(), cells.size());
    std::size_t records = 0;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      CHECK(std::is_sorted(cells[c].begin(), cells[c].end()));
      for (const std::uint32_t record : cells[c])
        home.at(record) = c;
      records += cells[c].size();
    }
    CHECK(records == sample.records.size());
    CHECK(std::count(home.begin(), home.end(), cells.size()) == 0);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < sample.records.size(); ++i)
      for_each_parent(sample.records, sample.parents, i,
                      [&](std::uint32_t parent) { wrong += home[parent] > home[i] ? 1 : 0; });
    CHECK(wrong == 0);
    if (most == 100000) CHECK(cells.size() == 1);
  }
}

TEST_CASE("cells: those of few records are taken together") {
  const Sample sample;
  const file::CellTree tree =
      file::divide_into_cells(sample.mesh, sample.records, sample.parents, generations(sample), 20);
  REQUIRE(tree.cells.size() > 8);
  std::vector<std::size_t> sizes, ones(tree.cells.size(), 1);
  for (const auto& cell : tree.cells)
    sizes.push_back(cell.size());
  for (const std::vector<std::size_t>& count : {sizes, ones})
    for (const std::size_t most : {0U, 1U, 3U, 50U, 100000U}) {
      std::uint32_t next = 0;
      for (const file::CellTree::Node& part : tree.parts(count, most)) {
        CHECK(part.begin == next);
        REQUIRE(part.end > part.begin);
        next = part.end;
        std::size_t sum = 0;
        for (std::uint32_t c = part.begin; c < part.end; ++c)
          sum += count[c];
        CHECK((sum <= most || part.end == part.begin + 1));
      }
      CHECK(next == tree.cells.size()); // every cell is in one part
    }
  CHECK(tree.parts(ones, tree.cells.size()).size() == 1);
  CHECK(tree.parts(ones, 1).size() == tree.cells.size());
  const std::size_t some = tree.parts(ones, 3).size();
  CHECK((some > 1 && some < tree.cells.size()));
}

TEST_CASE("cells: a separator is found where there is little to separate") {
  // A thin bridge between a large block and a small one: halves would have their separator in the large block.
  const TetMesh mesh =
      test::grid({{24, 6, 6}, [](int x, int y, int z) { return x < 14 || x > 17 || (y == 2 && z == 2); }, 2, 3});
  const RecordStream records = test::simplify_naively(mesh);
  const StreamParents parents(records);
  std::vector<std::uint32_t> generation(records.size());
  for (std::size_t i = generation.size(); i-- > 0;)
    for_each_parent(records, parents, i,
                    [&](std::uint32_t parent) { generation[i] = std::max(generation[i], generation[parent] + 1); });
  const file::CellTree tree = file::divide_into_cells(mesh, records, parents, generation, records.size() - 1);
  REQUIRE(tree.cells.size() == 3);
  std::array<double, 3> least{}, greatest{};
  for (std::size_t c = 0; c < 3; ++c) {
    least[c] = 1e9;
    for (const std::uint32_t r : tree.cells[c]) {
      least[c] = std::min(least[c], mesh.position(records.removed[r])[0]);
      greatest[c] = std::max(greatest[c], mesh.position(records.removed[r])[0]);
    }
  }
  CHECK(greatest[1] < 16 * 19);
  CHECK(least[2] > 16 * 13);
}

TEST_CASE("cells: the finest block of a long mesh needs but a part of it") {
  const Sample sample;
  const file::FileOrder order =
      file::order_file(sample.mesh, sample.records, sample.parents, budget_rank(sample.records, sample.parents), 8);
  std::vector<std::uint32_t> block_of(sample.records.size());
  for (std::uint32_t b = 0; b < order.blocks.size(); ++b) {
    CHECK(order.blocks[b].record_count <= 8);
    for (std::uint32_t i = 0; i < order.blocks[b].record_count; ++i)
      block_of.at(order.stream_record.at(order.blocks[b].first_record + i)) = b;
  }
  // On average over all blocks, with all they need.
  double needed = 0;
  for (std::uint32_t b = 0; b < order.blocks.size(); ++b) {
    std::vector<char> in(order.blocks.size(), 0);
    std::vector<std::uint32_t> open{b};
    in[b] = 1;
    while (!open.empty()) {
      const auto block = order.blocks[open.back()];
      open.pop_back();
      for (std::uint32_t i = 0; i < block.record_count; ++i)
        for_each_parent(sample.records, sample.parents, order.stream_record[block.first_record + i],
                        [&](std::uint32_t parent) {
                          if (std::exchange(in[block_of[parent]], 1) == 0) open.push_back(block_of[parent]);
                        });
    }
    needed += static_cast<double>(std::count(in.begin(), in.end(), 1));
  }
  CHECK(needed / static_cast<double>(order.blocks.size()) < 0.35 * static_cast<double>(order.blocks.size()));
}
