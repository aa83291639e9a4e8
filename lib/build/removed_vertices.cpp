#include "build/removed_vertices.hpp"

#include "error/closest_point.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace ptet::build {
using namespace vec;
namespace {

/// Barycentric coordinates above this count as inside: rounding at shared faces.
constexpr double kInside = -1e-10;
/// Errors below this fraction of the range are rounding.
constexpr double kRounding = 1e-13;

} // namespace

RemovedVertices::RemovedVertices(const std::vector<Point>& positions, const NormalizedFields& fields, double diagonal)
    : positions_(positions), fields_(fields), outside_distance_sq_(1e-20 * diagonal * diagonal),
      next_(positions.size(), kNone), errors_(fields.field_count()) {}

double RemovedVertices::least_barycentric(const Cell& cell, const Point& p, std::array<double, 4>& weight) {
  const Vec3 d = p - cell.x[0];
  weight[1] = dot(cell.row[0], d);
  weight[2] = dot(cell.row[1], d);
  weight[3] = dot(cell.row[2], d);
  weight[0] = 1 - weight[1] - weight[2] - weight[3];
  return std::min({weight[0], weight[1], weight[2], weight[3]});
}

void RemovedVertices::add_cell(const WorkingComplex& complex, SlotId slot, Vertex vs, Vertex vd) {
  const Slot& s = complex.slot(slot);
  if (complex.is_ghost(s)) return;
  Cell& cell = cells_.emplace_back();
  cell.slot = slot;
  for (std::size_t i = 0; i < 4; ++i) {
    cell.v[i] = s.v[i] == vs ? vd : s.v[i];
    cell.x[i] = positions_[cell.v[i]];
  }
  const Vec3 e1 = cell.x[1] - cell.x[0];
  const Vec3 e2 = cell.x[2] - cell.x[0];
  const Vec3 e3 = cell.x[3] - cell.x[0];
  const Vec3 n1 = cross(e2, e3);
  const double det = dot(e1, n1);
  cell.flat = !(det > 0) || !std::isfinite(1 / det);
  if (!cell.flat) cell.row = {(1 / det) * n1, (1 / det) * cross(e3, e1), (1 / det) * cross(e1, e2)};
}

void RemovedVertices::see_error(Vertex point, const Cell& cell, const std::array<double, 4>& weight) {
  const std::size_t channels = fields_.channel_count();
  const double* const f = fields_.at(point);
  std::array<const double*, 4> g{};
  for (std::size_t i = 0; i < 4; ++i)
    g[i] = fields_.at(cell.v[i]);
  double sum_sq = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    const double value = weight[0] * g[0][c] + weight[1] * g[1][c] + weight[2] * g[2][c] + weight[3] * g[3][c];
    sum_sq += (f[c] - value) * (f[c] - value);
    if (!fields_.ends_field(c)) continue;
    double& worst = errors_[fields_.field_of(c)];
    worst = std::max(worst, std::sqrt(sum_sq));
    sum_sq = 0;
  }
}

void RemovedVertices::hold(Vertex point) {
  const Point& p = positions_[point];
  std::array<double, 4> weight{};
  for (std::uint32_t c = 0; c < cells_.size(); ++c) {
    if (cells_[c].flat || !(least_barycentric(cells_[c], p, weight) >= kInside)) continue;
    held_.push_back({point, c});
    see_error(point, cells_[c], weight);
    return;
  }
  ClosestOnTet nearest{{}, std::numeric_limits<double>::infinity()};
  std::uint32_t cell = 0;
  for (std::uint32_t c = 0; c < cells_.size(); ++c) {
    const ClosestOnTet on = closest_on_tet_surface(p, cells_[c].x);
    if (!(on.distance_sq < nearest.distance_sq)) continue;
    nearest = on;
    cell = c;
  }
  held_.push_back({point, cell});
  see_error(point, cells_[cell], nearest.weight);
  if (nearest.distance_sq > outside_distance_sq_) newly_outside_.push_back(point);
}

void RemovedVertices::see_outside_points_now_covered() {
  // A point left outside by one tet may come to lie inside another one whose boundary moves over it later. It stays
  // held where it is, but its error belongs to this tet too, and to those that replace it.
  Point low = cells_[0].x[0];
  Point high = low;
  for (const Cell& cell : cells_)
    for (const Point& x : cell.x)
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], x[i]);
        high[i] = std::max(high[i], x[i]);
      }
  namespace bgi = boost::geometry::index;
  const boost::geometry::model::box<IndexPoint> box({low[0], low[1], low[2]}, {high[0], high[1], high[2]});
  std::array<double, 4> weight{};
  for (auto it = outside_.qbegin(bgi::intersects(box)); it != outside_.qend(); ++it)
    for (const Cell& cell : cells_)
      if (!cell.flat && least_barycentric(cell, positions_[it->second], weight) >= kInside)
        see_error(it->second, cell, weight);
}

void RemovedVertices::simulate(const WorkingComplex& complex, Vertex vs, Vertex vd, std::span<const SlotId> deleted,
                               std::span<const SlotId> modified) {
  cells_.clear();
  held_.clear();
  newly_outside_.clear();
  std::fill(errors_.begin(), errors_.end(), 0.0);
  for (const SlotId s : modified)
    add_cell(complex, s, vs, vd);
  if (cells_.empty()) return;
  hold(vs);
  for (const std::span<const SlotId> part : {deleted, modified})
    for (const SlotId s : part)
      for (std::uint32_t point = complex.slot(s).first_point; point != kNone; point = next_[point])
        hold(point);
  if (!outside_.empty()) see_outside_points_now_covered();
  for (double& error : errors_)
    if (error < kRounding) error = 0;
}

void RemovedVertices::commit(WorkingComplex& complex, std::span<const SlotId> deleted) {
  for (const SlotId s : deleted)
    complex.slot(s).first_point = kNone;
  for (const Cell& cell : cells_)
    complex.slot(cell.slot).first_point = kNone;
  for (const Held& held : held_) {
    std::uint32_t& first = complex.slot(cells_[held.cell].slot).first_point;
    next_[held.point] = first;
    first = held.point;
  }
  for (const Vertex point : newly_outside_)
    outside_.insert({IndexPoint(positions_[point][0], positions_[point][1], positions_[point][2]), point});
}

} // namespace ptet::build
