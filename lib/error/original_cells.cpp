#include "error/original_cells.hpp"

#include "error/double_double.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/predicates.hpp"
#include "mesh/vec3.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ptet {
using namespace vec;
namespace {

/// A tet of no more height, as a part of the diagonal of its body, is thin. A version, which is no larger, sees what is
/// within 1e-10 of its height from its plane as on it; one of a much larger body that the tet's own lies in may see
/// more.
constexpr double kThinTet = 1e-9;
/// Tets behind thin ones, in all lists together: so many, or so many times the tets. Where a body is 1e9 times as large
/// as its tets, as with a vertex that is far off, every tet is near every vertex.
constexpr std::size_t kMostBehind = std::size_t{1} << 25, kMostBehindPerTet = 64;

double least_height(const std::array<Point, 4>& x, double volume) {
  double area = 0;
  for (std::size_t k = 0; k < 4; ++k)
    area = std::max(area, norm(cross(x[(k + 1) % 4] - x[k], x[(k + 2) % 4] - x[k])) / 2);
  return 3 * volume / area;
}

} // namespace

OriginalCells::OriginalCells(const PreparedMesh& mesh, ChannelView fields)
    : prepared(mesh), channels(fields), on_boundary(mesh.used_vertex_count) {
  describe_fields();
  make_cells();
  find_thin();
  find_boundary();
  make_stars();
  find_behind_thin();
  std::vector<std::uint32_t>().swap(body_of_);
}

void OriginalCells::describe_fields() {
  const std::size_t count = channels.channels;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t field = channels.field_of[i];
    ends_field.push_back(i + 1 == count || channels.field_of[i + 1] != field ? 1 : 0);
    if (ends_field[i] != 0)
      scale_sq.push_back(channels.scale.empty() ? 1 : channels.scale[field] * channels.scale[field]);
  }
  scalars = std::find(ends_field.begin(), ends_field.end(), 0) == ends_field.end();
}

void OriginalCells::make_cells() {
  const std::vector<Tet>& tets = prepared.mesh.tets;
  cells.reserve(tets.size());
  for (const Tet& tet : tets) {
    Cell& cell = cells.emplace_back();
    for (std::size_t k = 0; k < 4; ++k)
      cell.v[k] = tet[k].index();
    cell.volume = volume_of(cell.v);
    if (!cell.is_flat()) continue;
    for (const std::uint32_t v : cell.v)
      on_boundary[v] = 1;
  }
}

void OriginalCells::find_thin() {
  DisjointSets<std::uint32_t> bodies(on_boundary.size());
  for (const Cell& cell : cells)
    for (std::size_t k = 1; k < 4; ++k)
      bodies.join(cell.v[0], cell.v[k]);
  std::vector<BoundingBox> boxes;
  body_of_.resize(on_boundary.size());
  for (std::uint32_t v = 0; v < body_of_.size(); ++v) {
    const std::uint32_t root = bodies.root(v); // no greater than v
    if (root == v) {
      body_of_[v] = static_cast<std::uint32_t>(boxes.size());
      boxes.emplace_back();
    } else {
      body_of_[v] = body_of_[root];
    }
    boxes[body_of_[v]].add(point(v));
  }
  for (const BoundingBox& box : boxes)
    thin_height_.push_back(kThinTet * norm(box.high - box.low));
  for (std::uint32_t t = 0; t < cells.size(); ++t) {
    const Cell& cell = cells[t];
    const double height = thin_height(t);
    const std::array<Point, 4> x{point(cell.v[0]), point(cell.v[1]), point(cell.v[2]), point(cell.v[3])};
    const BoundingBox around = box_of(x);
    const Vec3 sides = around.high - around.low;
    // No face has a larger area than half of that square.
    if (cell.is_flat() || 6 * cell.volume > height * dot(sides, sides) || least_height(x, cell.volume) > height)
      continue;
    thin.resize(cells.size(), 0);
    thin[t] = 1;
    for (const std::uint32_t v : cell.v)
      on_boundary[v] = 1;
  }
}

void OriginalCells::find_boundary() {
  const std::vector<Tet>& tets = prepared.mesh.tets;
  const FaceTable faces = build_face_table(tets, prepared.used_vertex_count);
  std::vector<BoundingBox> boxes;
  for (std::uint32_t t = 0; t < tets.size(); ++t) {
    Cell& cell = cells[t];
    for (std::uint32_t k = 0; k < 4; ++k) {
      const HalfFace h = 4 * t + k;
      cell.neighbor[k] = faces.is_boundary(h) ? kOutside : faces.mate[h] / 4;
      if (!faces.is_boundary(h) && is_thin(t) == is_thin(cell.neighbor[k])) continue;
      const Face face = face_of(tets, h);
      boxes.push_back(box_of<3>({point(face[0].index()), point(face[1].index()), point(face[2].index())}));
      boundary_faces.push_back(h);
      for (const VertexId v : face)
        on_boundary[v.index()] = 1;
    }
  }
  boundary_tree.emplace(boxes);
}

void OriginalCells::make_stars() {
  std::vector<std::uint32_t> next(prepared.used_vertex_count + 1);
  for (const Cell& cell : cells)
    for (const std::uint32_t v : cell.v)
      ++next[v + 1];
  for (std::size_t v = 1; v < next.size(); ++v)
    next[v] += next[v - 1];
  star_begin = next;
  star.resize(4 * cells.size());
  for (std::uint32_t t = 0; t < cells.size(); ++t)
    for (const std::uint32_t v : cells[t].v)
      star[next[v]++] = t;
  for (std::uint32_t v = 0; v < prepared.used_vertex_count; ++v)
    if (star_begin[v + 1] - star_begin[v] > kLargeStar) {
      large_stars.push_back(v);
      cones.push_back(cones_of(v));
    }
}

// From the star of a vertex on across faces, as long as tets touch its place: what lies between the vertex and those
// that fill the space around its place is thin there. Vertices in one place share what is found.
void OriginalCells::find_behind_thin() {
  for (std::uint32_t t = 0; t < cells.size(); ++t)
    if (is_thin(t)) thin_vertices_.insert(thin_vertices_.end(), cells[t].v.begin(), cells[t].v.end());
  std::sort(thin_vertices_.begin(), thin_vertices_.end());
  thin_vertices_.erase(std::unique(thin_vertices_.begin(), thin_vertices_.end()), thin_vertices_.end());
  if (thin_vertices_.empty()) return;
  constexpr std::uint32_t kNoList = 0xffffffffU;
  list_of_.assign(thin_vertices_.size(), kNoList);
  std::vector<std::uint32_t> seen(cells.size(), kNoList), open; // by tet: the last list that it was looked at for
  for (std::size_t i = 0; i < thin_vertices_.size(); ++i) {
    if (list_of_[i] != kNoList) continue;
    const auto list = static_cast<std::uint32_t>(behind_begin_.size() - 1);
    const Point& place = point(thin_vertices_[i]);
    open.clear();
    const auto look_at = [&](std::uint32_t t) {
      if (std::exchange(seen[t], list) != list) open.push_back(t);
    };
    const auto look_around = [&](std::size_t thin_vertex) {
      list_of_[thin_vertex] = list;
      const std::uint32_t v = thin_vertices_[thin_vertex];
      std::for_each(star.begin() + star_begin[v], star.begin() + star_begin[v + 1], look_at);
    };
    look_around(i);
    for (std::size_t next = 0; next < open.size(); ++next) {
      const Cell& cell = cells[open[next]];
      if (!cell.is_flat()) behind_.push_back(open[next]);
      if (behind_.size() > std::max(kMostBehind, kMostBehindPerTet * cells.size()))
        throw Error(
            ErrorCode::kLimit,
            "a body of this mesh is more than 1e9 times as large as many of its tets, too much for errors to be "
            "measured exactly (is a vertex far from all others?); by method QN it can be built");
      for (const std::uint32_t v : cell.v) {
        if (point(v) != place) continue;
        const std::size_t other = place_among_thin(v);
        if (other < thin_vertices_.size() && list_of_[other] == kNoList) look_around(other);
      }
      for (const std::uint32_t other : cell.neighbor)
        if (other != kOutside && is_near(other, place)) look_at(other);
    }
    std::sort(behind_.begin() + behind_begin_.back(), behind_.end());
    behind_begin_.push_back(behind_.size());
  }
}

/// Whether the box of a tet has the place in it, or as near to it as some thin tets on top of each other are high.
bool OriginalCells::is_near(std::uint32_t t, const Point& place) const {
  constexpr double kThinTetsBetween = 64;
  const auto& v = cells[t].v;
  BoundingBox box = box_of<4>({point(v[0]), point(v[1]), point(v[2]), point(v[3])});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] -= kThinTetsBetween * thin_height(t);
    box.high[axis] += kThinTetsBetween * thin_height(t);
  }
  return box.contains(place);
}

/// Index into thin_vertices_; their number for others.
std::size_t OriginalCells::place_among_thin(std::uint32_t v) const {
  const auto found = std::lower_bound(thin_vertices_.begin(), thin_vertices_.end(), v);
  return found != thin_vertices_.end() && *found == v ? static_cast<std::size_t>(found - thin_vertices_.begin())
                                                      : thin_vertices_.size();
}

std::span<const std::uint32_t> OriginalCells::behind_thin(std::uint32_t v) const {
  const std::size_t i = place_among_thin(v);
  if (i == thin_vertices_.size()) return {};
  const std::uint32_t list = list_of_[i];
  return {behind_.data() + behind_begin_[list], behind_.data() + behind_begin_[list + std::size_t{1}]};
}

double OriginalCells::volume_of(const std::array<std::uint32_t, 4>& tet) const {
  const Point& o = point(tet[0]);
  const Vec3 e1 = point(tet[1]) - o, e2 = point(tet[2]) - o, e3 = point(tet[3]) - o;
  const double det = std::abs(dot(e1, cross(e2, e3)));
  if (det > kFlatShape * (norm(e1) * norm(e2) * norm(e3))) return det / 6;
  if (orientation(o, point(tet[1]), point(tet[2]), point(tet[3])) == 0) return 0;
  const FineVec3 f1 = fine_difference(point(tet[1]), o), f2 = fine_difference(point(tet[2]), o),
                 f3 = fine_difference(point(tet[3]), o);
  return std::max(std::abs(dot(f1, cross(f2, f3)).rounded()) / 6, std::numeric_limits<double>::min());
}

StarCones::Triangle OriginalCells::opposite(const std::array<std::uint32_t, 4>& tet, std::uint32_t v) const {
  StarCones::Triangle triangle{};
  std::size_t count = 0;
  for (const std::uint32_t corner : tet)
    if (corner != v) triangle[count++] = point(corner);
  return triangle;
}

StarCones OriginalCells::cones_of(std::uint32_t v) const {
  std::vector<StarCones::Triangle> faces;
  for (std::uint32_t i = star_begin[v]; i != star_begin[v + 1]; ++i)
    faces.push_back(opposite(cells[star[i]].v, v));
  return {point(v), faces};
}

} // namespace ptet
