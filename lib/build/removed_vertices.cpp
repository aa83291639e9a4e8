#include "build/removed_vertices.hpp"

#include "build/collapse_geometry.hpp"
#include "error/tolerances.hpp"
#include "mesh/closest_point.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>

namespace ptet::build {
using namespace vec;
namespace bgi = boost::geometry::index;
namespace {

using IndexPoint = boost::geometry::model::point<double, 3, boost::geometry::cs::cartesian>;

/// What a distance to a cell is off by at most, as a fraction of that to its first corner, where the cell's rows are
/// told to kWellShaped.
constexpr double kFartherRounding = 1e-6;
constexpr double kWellShaped = 1e-8;

} // namespace

/// The points that lie outside, by place.
struct RemovedVertices::OutsideIndex {
  bgi::rtree<std::pair<IndexPoint, Vertex>, bgi::linear<16>> points;
};

RemovedVertices::RemovedVertices(const std::vector<Point>& positions, const NormalizedFields& fields, double diagonal,
                                 CoveredPoints covered)
    : positions_(positions), fields_(fields), outside_distance_sq_(1e-20 * diagonal * diagonal), covered_(covered),
      next_(positions.size(), kNone), holder_(positions.size(), kNone), is_outside_(positions.size()),
      outside_(std::make_unique<OutsideIndex>()) {}

RemovedVertices::~RemovedVertices() = default;

void RemovedVertices::hold_samples(WorkingComplex& complex, std::span<const Sample> samples,
                                   std::span<const Tet> tets) {
  samples_ = look_at(samples, tets, positions_, fields_);
  next_.resize(positions_.size() + samples_.points.size(), kNone);
  holder_.resize(next_.size(), kNone);
  is_outside_.resize(next_.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto point = static_cast<Vertex>(positions_.size() + i);
    const SlotId slot = samples[i].tet; // tets come first among the slots, in their order
    holder_[point] = slot;
    next_[point] = complex.slot(slot).first_point;
    complex.slot(slot).first_point = point;
  }
}

void RemovedVertices::weigh(std::vector<double> volumes) {
  volume_ = std::move(volumes);
  squared_.assign(volume_.size() * fields_.field_count(), 0.0);
}

double RemovedVertices::least_barycentric(const Cell& cell, const Point& p, std::array<double, 4>& weight) {
  const Vec3 d = p - cell.x[0];
  weight[1] = dot(cell.row[0], d);
  weight[2] = dot(cell.row[1], d);
  weight[3] = dot(cell.row[2], d);
  weight[0] = 1 - weight[1] - weight[2] - weight[3];
  return std::min({weight[0], weight[1], weight[2], weight[3]});
}

/// Whether the cell is farther from `p` than that, as the planes of its faces tell.
bool RemovedVertices::is_farther(const Cell& cell, const Point& p, double distance) {
  if (cell.flat || cell.shape > kWellShaped) return false;
  const Vec3 d = p - cell.x[0];
  const double beyond = distance + kFartherRounding * norm(d);
  const auto separates = [&](double weight, const Vec3& row) {
    return weight < 0 && weight * weight > beyond * beyond * dot(row, row);
  };
  const std::array<double, 3> weight{dot(cell.row[0], d), dot(cell.row[1], d), dot(cell.row[2], d)};
  return separates(weight[0], cell.row[0]) || separates(weight[1], cell.row[1]) || separates(weight[2], cell.row[2]) ||
         separates(1 - weight[0] - weight[1] - weight[2], cell.row[0] + cell.row[1] + cell.row[2]);
}

void RemovedVertices::add_cell(const WorkingComplex& complex, SlotId slot, Vertex vs, Vertex vd,
                               Simulation& simulation) const {
  const Slot& s = complex.slot(slot);
  if (complex.is_ghost(s)) return;
  Cell& cell = simulation.cells_.emplace_back();
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
  if (cell.flat) return;
  cell.shape = kShapeRounding * norm(e1) * norm(e2) * norm(e3) / det;
  cell.rounding = {cell.shape / norm(e1), cell.shape / norm(e2), cell.shape / norm(e3)};
  cell.row = {(1 / det) * n1, (1 / det) * cross(e3, e1), (1 / det) * cross(e1, e2)};
}

/// One a field.
void RemovedVertices::see_errors(Vertex point, const Cell& cell, const std::array<double, 4>& weight,
                                 std::vector<double>& errors) const {
  const std::size_t channels = fields_.channel_count();
  const double* const f = values(point);
  std::array<const double*, 4> g{};
  for (std::size_t i = 0; i < 4; ++i)
    g[i] = fields_.exact().at(cell.v[i]);
  const double length = norm(position(point) - cell.x[0]);
  std::array<double, 3> rounding{};
  for (std::size_t i = 0; i < 3; ++i)
    rounding[i] = kValueRounding * std::abs(weight[i + 1]) +
                  cell.rounding[i] * (length + std::abs(weight[i + 1]) * norm(cell.x[i + 1] - cell.x[0]));
  double sum_sq = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    const double own = f[c] - g[0][c]; // without a common offset
    double value = 0;
    double most = kValueRounding * std::abs(own);
    for (std::size_t i = 1; i < 4; ++i) {
      const double edge = g[i][c] - g[0][c];
      value += weight[i] * edge;
      most += rounding[i - 1] * std::abs(edge);
    }
    const double d = own - value;
    if (!(std::abs(d) <= most)) sum_sq += d * d;
    if (!fields_.ends_field(c)) continue;
    const std::size_t field = fields_.field_of(c);
    double error = std::sqrt(sum_sq) * fields_.exact().scale(field);
    if (std::isnan(error)) error = std::numeric_limits<double>::infinity();
    errors[field] = error;
    sum_sq = 0;
  }
}

void RemovedVertices::hold_in(Vertex point, std::uint32_t cell, const std::array<double, 4>& weight, bool is_outside,
                              Simulation& simulation) const {
  Cell& in = simulation.cells_[cell];
  simulation.held_.push_back({point, cell, is_outside});
  see_errors(point, in, weight, simulation.at_point_);
  std::vector<double>& errors = is_outside ? simulation.errors_outside_ : simulation.errors_inside_;
  for (std::size_t f = 0; f < errors.size(); ++f) {
    errors[f] = std::max(errors[f], simulation.at_point_[f]);
    if (!is_outside) in.worst = std::max(in.worst, simulation.at_point_[f]);
  }
  if (!volume_.empty()) see_squares(point, is_outside, simulation);
}

/// By the errors at the point that was last looked at.
void RemovedVertices::see_squares(Vertex point, bool is_outside, Simulation& simulation) const {
  const std::size_t fields = fields_.field_count();
  const bool counts = point < volume_.size(); // samples do not
  for (std::size_t f = 0; f < fields; ++f) {
    const double error = simulation.at_point_[f];
    const double squared = counts && !is_outside ? volume_[point] * error * error : 0;
    simulation.held_squared_.push_back(squared);
    if (counts) simulation.squared_growth_[f] += squared - squared_[point * fields + f];
  }
}

void RemovedVertices::hold(Vertex point, Simulation& simulation) const {
  const auto& cells = simulation.cells_;
  const Point& p = position(point);
  std::array<double, 4> weight{};
  std::uint32_t cell = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    if (cells[c].flat) continue;
    const double least = least_barycentric(cells[c], p, weight);
    if (least >= kInsideTet) {
      hold_in(point, c, weight, false, simulation);
      return;
    }
    if (least > most) {
      most = least;
      cell = c;
    }
  }
  // That one is likely to be the nearest, and most others lie beyond its distance.
  ClosestOnTet nearest = closest_on_tet_surface(p, cells[cell].x);
  double distance = std::sqrt(nearest.distance_sq);
  const std::uint32_t likely = cell;
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    if (c == likely || is_farther(cells[c], p, distance)) continue;
    const ClosestOnTet on = closest_on_tet_surface(p, cells[c].x);
    if (!(on.distance_sq < nearest.distance_sq || (on.distance_sq == nearest.distance_sq && c < cell))) continue;
    nearest = on;
    distance = std::sqrt(nearest.distance_sq);
    cell = c;
  }
  const bool is_outside = nearest.distance_sq > outside_distance_sq_;
  hold_in(point, cell, nearest.weight, is_outside, simulation);
}

void RemovedVertices::hold_outside_points_now_covered(std::span<const SlotId> deleted, Simulation& simulation) const {
  const auto& cells = simulation.cells_;
  // A point left outside, and held by a tet near by, may come to lie inside another one whose boundary moves over it.
  Point low = cells[0].x[0];
  Point high = low;
  for (const Cell& cell : cells)
    for (const Point& x : cell.x)
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], x[i]);
        high[i] = std::max(high[i], x[i]);
      }
  const boost::geometry::model::box<IndexPoint> box({low[0], low[1], low[2]}, {high[0], high[1], high[2]});
  const auto is_held_here = [&](Vertex point) {
    return std::any_of(cells.begin(), cells.end(), [&](const Cell& cell) { return cell.slot == holder_[point]; }) ||
           std::find(deleted.begin(), deleted.end(), holder_[point]) != deleted.end();
  };
  std::array<double, 4> weight{};
  for (auto it = outside_->points.qbegin(bgi::intersects(box)); it != outside_->points.qend(); ++it) {
    const Vertex point = it->second;
    if (is_held_here(point)) continue;
    for (std::uint32_t c = 0; c < cells.size(); ++c) {
      if (cells[c].flat || !(least_barycentric(cells[c], position(point), weight) >= kInsideTet)) continue;
      hold_in(point, c, weight, false, simulation);
      break;
    }
  }
}

void RemovedVertices::simulate(const WorkingComplex& complex, Vertex vs, Vertex vd, std::span<const SlotId> deleted,
                               std::span<const SlotId> modified, bool boundary_moves, Simulation& simulation) const {
  simulation.cells_.clear();
  simulation.held_.clear();
  simulation.held_squared_.clear();
  simulation.squared_growth_.assign(fields_.field_count(), 0.0);
  simulation.at_point_.resize(fields_.field_count());
  simulation.errors_inside_.assign(fields_.field_count(), 0.0);
  simulation.errors_outside_.assign(fields_.field_count(), 0.0);
  for (const SlotId s : modified)
    add_cell(complex, s, vs, vd, simulation);
  simulation.errors_.assign(fields_.field_count(), 0.0);
  if (simulation.cells_.empty()) return;
  hold(vs, simulation);
  for (const std::span<const SlotId> part : {deleted, modified})
    for (const SlotId s : part)
      for (std::uint32_t point = complex.slot(s).first_point; point != kNone; point = next_[point])
        hold(point, simulation);
  simulation.captured_begin_ = simulation.held_.size();
  if (boundary_moves && !outside_->points.empty()) hold_outside_points_now_covered(deleted, simulation);
  std::transform(simulation.errors_inside_.begin(), simulation.errors_inside_.end(), simulation.errors_outside_.begin(),
                 simulation.errors_.begin(), [](double inside, double outside) { return std::max(inside, outside); });
}

void RemovedVertices::let_go(WorkingComplex& complex, Vertex point) {
  std::uint32_t* link = &complex.slot(holder_[point]).first_point;
  while (*link != point)
    link = &next_[*link];
  *link = next_[point];
}

void RemovedVertices::commit(WorkingComplex& complex, std::span<const SlotId> deleted, const Simulation& simulation) {
  const auto& all = simulation.held_;
  for (std::size_t i = simulation.captured_begin_; i < all.size(); ++i)
    let_go(complex, all[i].point);
  for (const SlotId s : deleted)
    complex.slot(s).first_point = kNone;
  for (const Cell& cell : simulation.cells_)
    complex.slot(cell.slot).first_point = kNone;
  const std::size_t fields = fields_.field_count();
  for (std::size_t i = 0; i < all.size() && !volume_.empty(); ++i)
    if (all[i].point < volume_.size())
      std::copy_n(simulation.held_squared_.data() + i * fields, fields, squared_.data() + all[i].point * fields);
  for (const auto& held : all) {
    const SlotId slot = simulation.cells_[held.cell].slot;
    std::uint32_t& first = complex.slot(slot).first_point;
    next_[held.point] = first;
    first = held.point;
    holder_[held.point] = slot;
    if (covered_ == CoveredPoints::kStay || held.outside == (is_outside_[held.point] != 0)) continue;
    is_outside_[held.point] = held.outside ? 1 : 0;
    const Point& p = position(held.point);
    const std::pair<IndexPoint, Vertex> entry{IndexPoint(p[0], p[1], p[2]), held.point};
    if (held.outside)
      outside_->points.insert(entry);
    else
      outside_->points.remove(entry);
  }
}

} // namespace ptet::build
