#include "formats/ptet/ordering.hpp"

#include "formats/ptet/cells.hpp"
#include "mesh/morton.hpp"
#include "record/error_code.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace ptet::file {
namespace {

using Records = std::vector<std::uint32_t>;

/// How much larger each level is than the one before. A cut that ends within a level reads up to so many times the
/// records that it needs; with smaller steps a focus would be spread over more blocks.
constexpr double kLevelGrowth = 1.5;
/// Blocks in a cell, all levels together. With smaller cells a focus reads less, but blocks are more and shorter.
constexpr std::size_t kBlocksPerCell = 8;

/// By vertex: whether there is a tet that uses it, of the base or of any level.
std::vector<char> used_vertices(const RecordStream& records, std::size_t vertex_count) {
  std::vector<char> used(vertex_count);
  for (const VertexId v : records.removed)
    used[v.index()] = 1;
  for (const Tet& tet : records.slots) // a vertex that no record removed is still in one
    for (const VertexId v : tet)
      if (v != kDummyVertex) used[v.index()] = 1;
  return used;
}

/// Nothing but zeros where no vertex is used.
BoundingBox box_of_used(const PointArray& positions, const std::vector<char>& used) {
  BoundingBox box;
  bool any = false;
  for (std::uint32_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0) continue;
    box.add({positions.value(v, 0), positions.value(v, 1), positions.value(v, 2)});
    any = true;
  }
  return any ? box : BoundingBox{{}, {}};
}

void order_base(const RecordStream& records, const std::vector<std::uint64_t>& codes, const std::vector<char>& used,
                FileOrder& order) {
  std::vector<char> removed(codes.size());
  for (const VertexId v : records.removed)
    removed[v.index()] = 1;
  for (std::uint32_t v = 0; v < codes.size(); ++v) {
    if (removed[v] == 0) order.mesh_vertex.push_back(VertexId{v});
  }
  std::sort(order.mesh_vertex.begin(), order.mesh_vertex.end(), [&](VertexId a, VertexId b) {
    return std::tuple(used[a.index()] == 0, codes[a.index()], a) <
           std::tuple(used[b.index()] == 0, codes[b.index()], b);
  });
  order.base_vertex_count = static_cast<std::uint32_t>(order.mesh_vertex.size());
}

/// For each record the length of the longest chain of records, from one without parents to it, each a parent of the
/// next.
std::vector<std::uint32_t> generations_of(const RecordStream& records, const StreamParents& parents) {
  std::vector<std::uint32_t> generation(records.size());
  for (std::size_t i = records.size(); i-- > 0;) {
    for_each_parent(records, parents, i,
                    [&](std::uint32_t parent) { generation[i] = std::max(generation[i], generation[parent] + 1); });
  }
  return generation;
}

/// For each record the largest error code of it and of all that depend on it: cuts with smaller errors need it.
std::vector<ErrorCode16> needed_at(const RecordStream& records, const StreamParents& parents) {
  const std::size_t fields = records.fields.size();
  std::vector<ErrorCode16> code(records.size());
  const auto raise = [&](std::size_t record, double error, double scale) {
    if (error > 0 && scale > 0) code[record] = std::max(code[record], encode_error(error, scale));
  };
  for (std::size_t i = 0; i < records.size(); ++i) {
    for (std::size_t f = 0; f < fields; ++f)
      raise(i, records.largest_error(i, f), records.fields[f].range);
    raise(i, records.domain_error[i], records.diagonal);
    for_each_parent(records, parents, i, [&](std::uint32_t parent) { code[parent] = std::max(code[parent], code[i]); });
  }
  return code;
}

/// Records by the error at which they are needed, largest first; then coarse before fine.
std::vector<std::uint32_t> by_error(const RecordStream& records, const StreamParents& parents,
                                    const std::vector<std::uint32_t>& generation) {
  const auto code = needed_at(records, parents);
  std::vector<std::uint32_t> order(records.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(code[b], generation[a], a) < std::tuple(code[a], generation[b], b);
  });
  return order;
}

/// Two orders in one: each record stands by its rank in by_error() or for budgets, whichever is less. So a cut of n
/// records, by error or by a budget, finds them among the first 2n. A record's parents come before it in both orders,
/// and so they do here.
std::vector<std::uint32_t> coarse_to_fine(const RecordStream& records, const StreamParents& parents,
                                          const std::vector<std::uint32_t>& for_budgets,
                                          const std::vector<std::uint32_t>& generation) {
  std::vector<std::uint32_t> order = by_error(records, parents, generation);
  std::vector<std::uint32_t> rank(records.size());
  for (std::uint32_t i = 0; i < order.size(); ++i)
    rank[order[i]] = std::min(i, for_budgets[order[i]]);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(rank[a], b) < std::tuple(rank[b], a); // of two that share a rank the later collapse
  });
  return order;
}

/// Where the levels end in that order: each has kLevelGrowth times the vertices of the one before.
std::vector<std::size_t> level_ends(std::size_t record_count, std::size_t base_vertices) {
  std::vector<std::size_t> ends;
  double limit = static_cast<double>(std::max<std::size_t>(base_vertices, 2));
  while (ends.empty() || ends.back() < record_count) {
    limit *= kLevelGrowth;
    const auto end = static_cast<std::size_t>(limit) - std::min(base_vertices, static_cast<std::size_t>(limit));
    ends.push_back(std::min(end, record_count));
  }
  return ends;
}

/// The level of each record; returns how many levels there are.
std::size_t number_levels(const RecordStream& records, const StreamParents& parents,
                          const std::vector<std::uint32_t>& rank, const std::vector<std::uint32_t>& generation,
                          std::size_t base_vertices, std::vector<std::uint32_t>& level) {
  const auto by_rank = coarse_to_fine(records, parents, rank, generation);
  std::size_t begin = 0, levels = 0;
  for (const std::size_t end : level_ends(records.size(), base_vertices)) {
    for (; begin < end; ++begin)
      level[by_rank[begin]] = static_cast<std::uint32_t>(levels);
    ++levels;
  }
  return levels;
}

/// By level: its records, in parts that lie in one cell each, or in several that were divided from one another where
/// these have no more than `most_together`. Coarse levels have few records in most cells, and the table a row for each
/// block.
std::vector<std::vector<Records>> pieces_of_levels(const CellTree& tree, const std::vector<std::uint32_t>& level,
                                                   std::size_t levels, std::size_t most_together) {
  std::vector<std::vector<Records>> of_cell(levels, std::vector<Records>(tree.cells.size()));
  for (std::size_t c = 0; c < tree.cells.size(); ++c) {
    for (const std::uint32_t record : tree.cells[c])
      of_cell[level[record]][c].push_back(record);
  }
  std::vector<std::vector<Records>> pieces(levels);
  for (std::size_t l = 0; l < levels; ++l) {
    std::vector<std::size_t> count;
    for (const Records& records : of_cell[l])
      count.push_back(records.size());
    for (const CellTree::Node& part : tree.parts(count, most_together)) {
      Records& piece = pieces[l].emplace_back();
      for (std::uint32_t c = part.begin; c < part.end; ++c)
        piece.insert(piece.end(), of_cell[l][c].begin(), of_cell[l][c].end());
    }
  }
  return pieces;
}

} // namespace

std::vector<std::uint64_t> morton_codes(const PointArray& positions, const BoundingBox& box) {
  const auto& [least, greatest] = box;
  const std::size_t count = positions.size();
  const double size = std::max({greatest[0] - least[0], greatest[1] - least[1], greatest[2] - least[2]});
  std::vector<std::uint64_t> codes(count);
  for (std::size_t v = 0; v < count; ++v)
    codes[v] = morton_code({positions.value(v, 0), positions.value(v, 1), positions.value(v, 2)}, least, size);
  return codes;
}

FileOrder order_file(const TetMesh& mesh, const RecordStream& records, const StreamParents& parents,
                     const std::vector<std::uint32_t>& rank, std::uint32_t records_per_block) {
  FileOrder order;
  const std::vector<char> used = used_vertices(records, mesh.vertex_count());
  order.box = box_of_used(mesh.positions, used);
  const auto codes = morton_codes(mesh.positions, order.box);
  order_base(records, codes, used, order);
  const auto generation = generations_of(records, parents);
  const auto code_of = [&](std::uint32_t record) { return codes[records.removed[record].index()]; };

  std::vector<std::uint32_t> level(records.size());
  const std::size_t levels = number_levels(records, parents, rank, generation, order.base_vertex_count, level);
  const CellTree tree = divide_into_cells(mesh, records, parents, generation, kBlocksPerCell * records_per_block);
  std::vector<std::vector<Records>> pieces = pieces_of_levels(tree, level, levels, records_per_block / 2);
  for (auto& of_level : pieces) {
    for (auto& piece : of_level) {
      std::sort(piece.begin(), piece.end(),
                [&](std::uint32_t a, std::uint32_t b) { return std::pair(code_of(a), a) < std::pair(code_of(b), b); });
      // Blocks of one piece differ by one record at most.
      const std::size_t count = (piece.size() + records_per_block - 1) / records_per_block;
      for (std::size_t b = 0; b < count; ++b) {
        const auto first = piece.begin() + static_cast<std::ptrdiff_t>(piece.size() * b / count);
        const auto last = piece.begin() + static_cast<std::ptrdiff_t>(piece.size() * (b + 1) / count);
        std::sort(first, last, [&](std::uint32_t x, std::uint32_t y) {
          return std::tuple(generation[x], code_of(x), x) < std::tuple(generation[y], code_of(y), y);
        });
        order.blocks.push_back(
            {static_cast<std::uint32_t>(order.stream_record.size()), static_cast<std::uint32_t>(last - first)});
        order.stream_record.insert(order.stream_record.end(), first, last);
      }
    }
  }
  for (const std::uint32_t record : order.stream_record) {
    order.mesh_vertex.push_back(records.removed[record]);
    order.generation.push_back(generation[record]);
  }
  order.file_vertex.resize(order.mesh_vertex.size());
  for (std::uint32_t v = 0; v < order.mesh_vertex.size(); ++v)
    order.file_vertex[order.mesh_vertex[v].index()] = VertexId{v};
  return order;
}

} // namespace ptet::file
