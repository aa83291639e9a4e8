#include "ptet/weld.hpp"

#include "mesh/rows.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <vector>

namespace ptet {
namespace {

bool is_whole(const TetMesh& mesh) {
  const std::size_t count = mesh.vertex_count();
  if (count > kDummyVertex.index()) return false;
  const auto has_rows = [&](const PointArray& array) {
    return array.row_bytes() > 0 && array.bytes.size() == count * array.row_bytes();
  };
  return has_rows(mesh.positions) && std::all_of(mesh.point_arrays.begin(), mesh.point_arrays.end(), has_rows) &&
         std::all_of(mesh.tets.begin(), mesh.tets.end(), [&](const Tet& tet) {
           return std::all_of(tet.begin(), tet.end(), [&](VertexId v) { return v.index() < count; });
         });
}

/// The rows of two vertices, as bytes: negative, 0 or positive.
int compare_rows(const PointArray& array, std::uint32_t a, std::uint32_t b) {
  const std::size_t bytes = array.row_bytes();
  return std::memcmp(array.bytes.data() + a * bytes, array.bytes.data() + b * bytes, bytes);
}
int compare(const TetMesh& mesh, std::uint32_t a, std::uint32_t b) {
  int order = compare_rows(mesh.positions, a, b);
  for (std::size_t i = 0; order == 0 && i < mesh.point_arrays.size(); ++i)
    order = compare_rows(mesh.point_arrays[i], a, b);
  return order;
}

/// By vertex: the first one like it.
std::vector<std::uint32_t> find_firsts(const TetMesh& mesh) {
  std::vector<std::uint32_t> sorted(mesh.vertex_count());
  std::iota(sorted.begin(), sorted.end(), 0U);
  std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
    const int order = compare(mesh, a, b);
    return order != 0 ? order < 0 : a < b;
  });
  std::vector<std::uint32_t> first(sorted.size());
  for (std::size_t i = 0; i < sorted.size(); ++i)
    first[sorted[i]] = i > 0 && compare(mesh, sorted[i - 1], sorted[i]) == 0 ? first[sorted[i - 1]] : sorted[i];
  return first;
}

/// Points of which a tet has two stay apart, with all that are like them.
void keep_tets(const TetMesh& mesh, std::vector<std::uint32_t>& first) {
  std::vector<char> is_apart(first.size());
  for (const Tet& tet : mesh.tets)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        if (tet[i] != tet[j] && first[tet[i].index()] == first[tet[j].index()]) is_apart[first[tet[i].index()]] = 1;
  for (std::uint32_t v = 0; v < first.size(); ++v)
    if (is_apart[first[v]] != 0) first[v] = v; // the first of them comes first, so none is looked up after that
}

} // namespace

std::string welding_note(std::uint64_t points) {
  return std::to_string(points) + (points == 1 ? " point was" : " points were") +
         " welded with others of the same place and values";
}

std::uint64_t weld_points(TetMesh& mesh) {
  if (!is_whole(mesh)) return 0;
  std::vector<std::uint32_t> first = find_firsts(mesh);
  keep_tets(mesh, first);
  std::vector<VertexId> kept;
  std::vector<std::uint32_t> renumbered(first.size());
  for (std::uint32_t v = 0; v < first.size(); ++v) {
    renumbered[v] = first[v] == v ? static_cast<std::uint32_t>(kept.size()) : renumbered[first[v]];
    if (first[v] == v) kept.emplace_back(v);
  }
  const std::uint64_t gone = first.size() - kept.size();
  if (gone == 0) return 0;
  mesh.positions = gather(mesh.positions, kept);
  for (PointArray& array : mesh.point_arrays)
    array = gather(array, kept);
  for (Tet& tet : mesh.tets)
    for (VertexId& v : tet)
      v = VertexId{renumbered[v.index()]};
  return gone;
}

} // namespace ptet
