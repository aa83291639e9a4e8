#include "formats/ptet/cells.hpp"
#include "formats/ptet/ordering.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"

#include <algorithm>
#include <utility>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

struct Sample {
  TetMesh mesh = test::grid({{24, 4, 4}, {}, 2, 3});
  RecordStream records = test::simplify_naively(mesh);
  std::vector<std::uint32_t> consumers = file::find_consumers(records);
};

std::vector<std::uint32_t> generations(const Sample& sample) {
  std::vector<std::uint32_t> generation(sample.records.size());
  for (std::size_t i = generation.size(); i-- > 0;)
    file::for_each_parent(sample.records, sample.consumers, i, [&](std::uint32_t parent) {
      generation[i] = std::max(generation[i], generation[parent] + 1);
    });
  return generation;
}

} // namespace

TEST_CASE("cells: each record is in one, which depends on none behind it") {
  const Sample sample;
  for (const std::size_t most : {20U, 100U, 100000U}) {
    const auto cells =
        file::divide_into_cells(sample.mesh, sample.records, sample.consumers, generations(sample), most);
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
      file::for_each_parent(sample.records, sample.consumers, i,
                            [&](std::uint32_t parent) { wrong += home[parent] > home[i] ? 1 : 0; });
    CHECK(wrong == 0);
    if (most == 100000) CHECK(cells.size() == 1);
  }
}

TEST_CASE("cells: the finest block of a long mesh needs but a part of it") {
  const Sample sample;
  const file::FileOrder order = file::order_file(sample.mesh, sample.records, sample.consumers, 8);
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
        file::for_each_parent(sample.records, sample.consumers, order.stream_record[block.first_record + i],
                              [&](std::uint32_t parent) {
                                if (std::exchange(in[block_of[parent]], 1) == 0) open.push_back(block_of[parent]);
                              });
    }
    needed += static_cast<double>(std::count(in.begin(), in.end(), 1));
  }
  CHECK(needed / static_cast<double>(order.blocks.size()) < 0.35 * static_cast<double>(order.blocks.size()));
}
