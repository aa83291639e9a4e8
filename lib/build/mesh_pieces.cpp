#include "build/mesh_pieces.hpp"

#include "mesh/rows.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

namespace ptet::build {
namespace {

constexpr std::uint32_t kNotInPiece = std::numeric_limits<std::uint32_t>::max();

} // namespace

MeshPieces::MeshPieces(const PreparedMesh& prepared, std::uint32_t count)
    : prepared_(prepared), piece_of_(prepared.used_vertex_count), boxes_(std::max(count, 1U)),
      vertex_count_(boxes_.size()) {
  std::vector<std::uint32_t> vertices(prepared.used_vertex_count);
  std::iota(vertices.begin(), vertices.end(), 0U);
  cut(vertices, 0, this->count());
}

/// Parts `vertices` into `count` pieces, from `first_piece` on.
void MeshPieces::cut(std::span<std::uint32_t> vertices, std::uint32_t first_piece, std::uint32_t count) {
  BoundingBox box;
  for (const std::uint32_t v : vertices)
    box.add(prepared_.points[v]);
  if (count == 1 || vertices.empty()) {
    boxes_[first_piece] = box;
    vertex_count_[first_piece] = static_cast<std::uint32_t>(vertices.size());
    for (const std::uint32_t v : vertices)
      piece_of_[v] = first_piece;
    return;
  }
  std::size_t axis = 0;
  for (std::size_t other = 1; other < 3; ++other)
    if (box.high[other] - box.low[other] > box.high[axis] - box.low[axis]) axis = other;
  const auto place = [&](std::uint32_t v) {
    const Point& p = prepared_.points[v];
    return std::make_tuple(p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]);
  };
  const std::uint32_t low_count = count / 2;
  const auto middle =
      vertices.begin() + static_cast<std::ptrdiff_t>(vertices.size() * std::uint64_t{low_count} / count);
  std::nth_element(vertices.begin(), middle, vertices.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  const auto pivot = place(*middle);
  const auto end_of_low = std::partition(vertices.begin(), middle, [&](std::uint32_t v) { return place(v) < pivot; });
  const auto low_size = static_cast<std::size_t>(end_of_low - vertices.begin());
  cut(vertices.first(low_size), first_piece, low_count);
  cut(vertices.subspan(low_size), first_piece + low_count, count - low_count);
}

MeshPiece MeshPieces::piece(std::uint32_t index, std::span<const std::uint32_t> arrays) const {
  MeshPiece piece;
  const BoundingBox& box = boxes_[index];
  const auto point = [&](VertexId v) { return prepared_.points[v.index()]; };
  const auto is_own = [&](VertexId v) { return piece_of_[v.index()] == index; };
  const std::vector<Tet>& tets = prepared_.mesh.tets;
  std::vector<std::uint32_t> id_in_piece(prepared_.used_vertex_count, kNotInPiece);
  for (std::uint32_t t = 0; t < tets.size(); ++t) {
    const Tet& tet = tets[t];
    if (!box.meets(box_of<4>({point(tet[0]), point(tet[1]), point(tet[2]), point(tet[3])}))) continue;
    piece.tet.push_back(t);
    for (const VertexId v : tet)
      id_in_piece[v.index()] = 0;
  }
  PreparedMesh& part = piece.prepared;
  for (std::uint32_t v = 0; v < id_in_piece.size(); ++v) {
    if (id_in_piece[v] == kNotInPiece) continue;
    id_in_piece[v] = static_cast<std::uint32_t>(part.original_vertex.size());
    part.original_vertex.emplace_back(v);
    part.points.push_back(prepared_.points[v]);
    part.frozen.push_back(prepared_.frozen[v] != 0 || piece_of_[v] != index ? 1 : 0);
  }
  const auto here = [&](VertexId v) { return VertexId{id_in_piece[v.index()]}; };
  part.mesh.tets.reserve(piece.tet.size());
  for (const std::uint32_t t : piece.tet) {
    const Tet& tet = tets[t];
    const Tet& in_piece = part.mesh.tets.emplace_back(Tet{here(tet[0]), here(tet[1]), here(tet[2]), here(tet[3])});
    if (std::all_of(tet.begin(), tet.end(), is_own)) continue;
    for (const VertexId v : in_piece)
      part.frozen[v.index()] = 1;
  }
  for (std::size_t f = 0; f < prepared_.boundary_faces.size(); ++f) {
    const Face& face = prepared_.boundary_faces[f];
    if (!box.meets(box_of<3>({point(face[0]), point(face[1]), point(face[2])}))) continue;
    part.boundary_faces.push_back({here(face[0]), here(face[1]), here(face[2])});
    if (!prepared_.crossing_curves.empty()) part.crossing_curves.push_back(prepared_.crossing_curves[f]);
  }
  part.used_vertex_count = static_cast<std::uint32_t>(part.original_vertex.size());
  part.mesh.positions = gather(prepared_.mesh.positions, part.original_vertex);
  for (const std::uint32_t array : arrays)
    part.mesh.point_arrays.push_back(gather(prepared_.mesh.point_arrays[array], part.original_vertex));
  piece.movable_count = static_cast<std::uint32_t>(std::count(part.frozen.begin(), part.frozen.end(), 0));
  return piece;
}

} // namespace ptet::build
