#include "shown_mesh.hpp"

#include <cmath>
#include <utility>

namespace ptet::view {
namespace {

double length_of_row(const PointArray& array, std::size_t row) {
  if (array.components == 1) return array.value(row, 0);
  double sum = 0;
  for (std::uint32_t c = 0; c < array.components; ++c)
    sum += array.value(row, c) * array.value(row, c);
  return std::sqrt(sum);
}

Point point_of(const PointArray& positions, std::size_t row) {
  return {positions.value(row, 0), positions.value(row, 1), positions.value(row, 2)};
}

} // namespace

void ShownMesh::choose(std::size_t column, std::size_t field) {
  if (columns_[column].field == field) return;
  columns_[column] = {field, true, {}, {}};
}

void ShownMesh::set_row(Column& column, std::span<const PointArray> arrays, std::size_t row) {
  const double value = column.field < arrays.size() ? length_of_row(arrays[column.field], row) : 0;
  column.values[row] = value;
  if (std::isfinite(value))
    column.range.widen(value);
  else if (std::isnan(value))
    column.range.has_gaps = true;
}

void ShownMesh::follow(const Session& session, const SessionUpdate& update) {
  const std::span<const VertexId> vertices = session.vertex_in_file();
  positions_.resize(vertices.size());
  for (const std::uint32_t slot : update.changed_vertices)
    if (!vertices[slot].is_none()) positions_[slot] = placement_.drawn(point_of(session.positions(), slot));
  for (Column& column : columns_) {
    column.values.resize(vertices.size());
    if (std::exchange(column.is_stale, false)) {
      for (std::size_t slot = 0; slot < vertices.size(); ++slot)
        if (!vertices[slot].is_none()) set_row(column, session.point_arrays(), slot);
    } else {
      for (const std::uint32_t slot : update.changed_vertices)
        if (!vertices[slot].is_none()) set_row(column, session.point_arrays(), slot);
    }
  }
  tets_ = session.tets();
  faces_ = session.boundary_faces();
}

MeshRows ShownMesh::rows() const {
  return {positions_, columns_[0].values, tets_, faces_, {}};
}

} // namespace ptet::view
