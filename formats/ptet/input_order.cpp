#include "formats/ptet/input_order.hpp"

#include "formats/ptet/planes.hpp"

#include <algorithm>
#include <numeric>

namespace ptet::file {
namespace {

using Permutation = std::array<std::uint8_t, 4>;
constexpr std::size_t kPermutations = 24;

const std::array<Permutation, kPermutations>& permutations() {
  static const auto kSorted = [] {
    std::array<Permutation, kPermutations> sorted{};
    Permutation next{0, 1, 2, 3};
    for (Permutation& permutation : sorted) {
      permutation = next;
      std::next_permutation(next.begin(), next.end());
    }
    return sorted;
  }();
  return kSorted;
}

std::uint8_t number_of_corners(const Tet& given, const Tet& ascending) {
  Permutation order{};
  for (std::size_t i = 0; i < 4; ++i)
    order[i] =
        static_cast<std::uint8_t>(std::lower_bound(ascending.begin(), ascending.end(), given[i]) - ascending.begin());
  const auto& all = permutations();
  return static_cast<std::uint8_t>(std::lower_bound(all.begin(), all.end(), order) - all.begin());
}

/// Each number less the one before.
void put_ids(ByteWriter& out, const std::vector<std::uint32_t>& ids) {
  std::vector<std::uint64_t> steps(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i)
    steps[i] = ids[i] - (i == 0 ? 0 : ids[i - 1]);
  put_planes(out, steps, 4);
}

std::vector<std::uint32_t> parse_ids(ByteReader& in, std::uint32_t count, const char* name) {
  const Planes steps(in, count, 4, name);
  std::vector<std::uint32_t> ids(count);
  std::vector<char> is_there(count);
  std::uint32_t id = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    id += static_cast<std::uint32_t>(steps.at(i));
    if (id >= count || is_there[id] != 0) in.fail(std::string(name) + " are not those of the input, each once");
    is_there[id] = 1;
    ids[i] = id;
  }
  return ids;
}

} // namespace

std::vector<std::uint32_t> places_by_corners(std::span<const Tet> ascending, std::size_t vertex_count) {
  std::vector<std::uint32_t> begin(vertex_count + 1), places(ascending.size());
  for (const Tet& tet : ascending)
    ++begin[tet[0].index() + std::size_t{1}];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::uint32_t t = 0; t < ascending.size(); ++t)
    places[next[ascending[t][0].index()]++] = t;
  for (std::size_t v = 0; v < vertex_count; ++v)
    std::sort(places.begin() + begin[v], places.begin() + begin[v + 1],
              [&](std::uint32_t a, std::uint32_t b) { return ascending[a] < ascending[b]; });
  return places;
}

Tet corners_in_order(const Tet& ascending, std::uint8_t corners) {
  Tet tet;
  for (std::size_t i = 0; i < 4; ++i)
    tet[i] = ascending[permutations()[corners][i]];
  return tet;
}

InputOrder input_order(const GivenIds& given, std::span<const VertexId> file_vertex) {
  InputOrder order;
  order.vertex.resize(file_vertex.size());
  for (std::size_t v = 0; v < file_vertex.size(); ++v)
    order.vertex[file_vertex[v].index()] = given.vertex[v].index();
  std::vector<Tet> ascending = given.tets;
  for (Tet& tet : ascending)
    std::sort(tet.begin(), tet.end());
  order.tet = places_by_corners(ascending, file_vertex.size());
  order.corners.reserve(order.tet.size());
  for (const std::uint32_t t : order.tet)
    order.corners.push_back(number_of_corners(given.tets[t], ascending[t]));
  return order;
}

InputOrder parse_input_order(ByteReader& in, std::uint32_t vertex_count, std::uint32_t tet_count) {
  InputOrder order;
  order.vertex = parse_ids(in, vertex_count, "vertices");
  order.tet = parse_ids(in, tet_count, "tets");
  order.corners.reserve(tet_count);
  for (const std::byte corners : in.get_bytes(tet_count, "corners")) {
    order.corners.push_back(static_cast<std::uint8_t>(corners));
    if (order.corners.back() >= kPermutations) in.fail("an order of corners is out of range");
  }
  in.finish();
  return order;
}

void put_input_order(ByteWriter& out, const InputOrder& order) {
  put_ids(out, order.vertex);
  put_ids(out, order.tet);
  for (const std::uint8_t corners : order.corners)
    out.put(corners);
}

std::uint64_t input_order_bytes(std::uint64_t vertex_count, std::uint64_t tet_count) {
  return 4 * vertex_count + 5 * tet_count;
}

} // namespace ptet::file
