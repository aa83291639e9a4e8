#include "lod/input_order.hpp"

#include "mesh/rows.hpp"

#include <algorithm>

namespace ptet {
namespace {

void order_vertices(Extraction& extraction, const file::InputOrder& order) {
  TetMesh& mesh = extraction.mesh;
  // By id in the input, the rows that are there.
  constexpr std::uint32_t kNotThere = VertexId::kNone;
  std::vector<std::uint32_t> row_of(order.vertex.size(), kNotThere);
  for (std::uint32_t row = 0; row < extraction.vertex_in_file.size(); ++row)
    row_of[order.vertex[extraction.vertex_in_file[row].index()]] = row;
  std::vector<VertexId> rows, new_row(extraction.vertex_in_file.size());
  rows.reserve(new_row.size());
  extraction.input_vertex.reserve(new_row.size());
  for (std::uint32_t id = 0; id < row_of.size(); ++id) {
    if (row_of[id] == kNotThere) continue;
    new_row[row_of[id]] = VertexId{static_cast<std::uint32_t>(rows.size())};
    rows.emplace_back(row_of[id]);
    extraction.input_vertex.push_back(id);
  }
  mesh.positions = gather(mesh.positions, rows);
  for (PointArray& array : mesh.point_arrays)
    array = gather(array, rows);
  std::vector<VertexId> in_file;
  in_file.reserve(rows.size());
  for (const VertexId row : rows)
    in_file.push_back(extraction.vertex_in_file[row.index()]);
  extraction.vertex_in_file = std::move(in_file);
  for (Tet& tet : mesh.tets)
    for (VertexId& v : tet)
      v = new_row[v.index()];
  for (auto& face : extraction.boundary_faces)
    for (VertexId& v : face)
      v = new_row[v.index()];
}

/// Vertices are named by their ids in the input already.
void order_tets(Extraction& extraction, const file::InputOrder& order) {
  std::vector<Tet> tets = std::move(extraction.mesh.tets);
  for (Tet& tet : tets)
    std::sort(tet.begin(), tet.end());
  const std::vector<std::uint32_t> places = file::places_by_corners(tets, order.vertex.size());
  std::vector<RecordId> made_by(extraction.made_by.size());
  extraction.mesh.tets.resize(tets.size());
  for (std::size_t place = 0; place < places.size(); ++place) {
    extraction.mesh.tets[order.tet[place]] = file::corners_in_order(tets[places[place]], order.corners[place]);
    if (!made_by.empty()) made_by[order.tet[place]] = extraction.made_by[places[place]];
  }
  extraction.made_by = std::move(made_by);
}

} // namespace

void put_in_input_order(Extraction& extraction, const file::InputOrder& order) {
  order_vertices(extraction, order);
  // All tets are original ones only where all splits are made, and then all vertices are there.
  if (extraction.mesh.tets.size() == order.tet.size() && extraction.mesh.vertex_count() == order.vertex.size())
    order_tets(extraction, order);
}

} // namespace ptet
