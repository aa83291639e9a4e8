#include "ptet/weld.hpp"

#include "mesh/near_points.hpp"
#include "mesh/number_text.hpp"
#include "mesh/rows.hpp"
#include "mesh/topology.hpp"
#include "mesh/vec3.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>
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

/// The largest distance that is one of rounding, and not of shape, as a part of the diagonal.
constexpr double kFarthest = 1e-3;

/// Where the points are that may be welded over a distance: the vertices of boundary faces. Inside of a mesh none lies
/// so near to another but by what it is made of.
std::vector<std::uint32_t> boundary_vertices(const TetMesh& mesh) {
  std::vector<Tet> tets;
  tets.reserve(mesh.tets.size());
  for (const Tet& tet : mesh.tets) {
    Tet sorted = tet;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) tets.push_back(tet);
  }
  const FaceTable faces = build_face_table(tets, mesh.vertex_count());
  std::vector<char> is_at_boundary(mesh.vertex_count());
  for (HalfFace h = 0; h < faces.mate.size(); ++h) {
    if (faces.is_interior(h)) continue;
    for (const VertexId v : face_of(tets, h))
      is_at_boundary[v.index()] = 1;
  }
  std::vector<std::uint32_t> found;
  for (std::uint32_t v = 0; v < is_at_boundary.size(); ++v) {
    const Point p = mesh.position(VertexId{v});
    if (is_at_boundary[v] != 0 && std::all_of(p.begin(), p.end(), [](double x) { return std::isfinite(x); }))
      found.push_back(v);
  }
  return found;
}

/// By vertex: the one that it becomes. Taken in the order of their ids, each becomes the nearest of those that stayed
/// within the distance and with values as near; none such, and it stays. So no chain of points becomes one.
class NearFirsts {
public:
  NearFirsts(const TetMesh& mesh, double distance, double share) : mesh_(mesh), distance_(distance) {
    largest_difference_.reserve(mesh.point_arrays.size());
    for (const PointArray& array : mesh.point_arrays)
      largest_difference_.push_back(is_floating(array.type) ? share * largest_range(array) : 0);
  }

  [[nodiscard]] std::vector<std::uint32_t> find() const {
    std::vector<std::uint32_t> first(mesh_.vertex_count());
    std::iota(first.begin(), first.end(), 0U);
    const std::vector<std::uint32_t> vertices = boundary_vertices(mesh_);
    std::vector<Point> points;
    points.reserve(vertices.size());
    for (const std::uint32_t v : vertices)
      points.push_back(mesh_.position(VertexId{v}));
    const NearPoints all(std::move(points));
    for (std::uint32_t i = 0; i < all.size(); ++i) {
      const std::uint32_t v = vertices[i];
      double nearest = distance_;
      all.each_before(i, distance_, [&](std::uint32_t j, double distance) {
        const std::uint32_t other = vertices[j];
        if (first[other] != other) return;
        const bool is_nearer = distance < nearest || (distance == nearest && (first[v] == v || other < first[v]));
        if (!is_nearer || !has_values_of(v, other)) return;
        nearest = distance;
        first[v] = other;
      });
    }
    return first;
  }

private:
  /// Of finite values, over all components.
  static double largest_range(const PointArray& array) {
    double range = 0;
    for (std::uint32_t c = 0; c < array.components; ++c) {
      double least = std::numeric_limits<double>::infinity(), greatest = -least;
      for (std::size_t row = 0; row < array.bytes.size() / array.row_bytes(); ++row) {
        const double x = array.value(row, c);
        if (!std::isfinite(x)) continue;
        least = std::min(least, x);
        greatest = std::max(greatest, x);
      }
      range = std::max(range, greatest - least);
    }
    return range;
  }
  [[nodiscard]] bool has_values_of(std::uint32_t a, std::uint32_t b) const {
    for (std::size_t i = 0; i < mesh_.point_arrays.size(); ++i) {
      const PointArray& array = mesh_.point_arrays[i];
      if (compare_rows(array, a, b) == 0) continue;
      if (!is_floating(array.type)) return false;
      for (std::uint32_t c = 0; c < array.components; ++c) {
        const double x = array.value(a, c), y = array.value(b, c);
        if (!(x == y || (std::isnan(x) && std::isnan(y)) || std::abs(x - y) <= largest_difference_[i])) return false;
      }
    }
    return true;
  }

  static bool is_floating(ScalarType type) { return type == ScalarType::kFloat32 || type == ScalarType::kFloat64; }

  const TetMesh& mesh_;
  double distance_;
  std::vector<double> largest_difference_; ///< by point array
};

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

/// Lets each vertex be the first of its like; returns how many went.
std::uint64_t merge(TetMesh& mesh, std::vector<std::uint32_t> first) {
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

/// Of the box of the tets' finite corners.
double diagonal_of(const TetMesh& mesh) {
  using namespace vec;
  BoundingBox box;
  for (const Tet& tet : mesh.tets)
    for (const VertexId v : tet) {
      const Point p = mesh.position(v);
      if (std::all_of(p.begin(), p.end(), [](double x) { return std::isfinite(x); })) box.add(p);
    }
  return box.low[0] <= box.high[0] ? norm(box.high - box.low) : 0;
}

} // namespace

std::string welding_note(std::uint64_t points, const Bound& within) {
  return std::to_string(points) + (points == 1 ? " point was" : " points were") + " welded with others of " +
         (within.value > 0 ? "nearly " : "") + "the same place and values";
}

std::uint64_t weld_points(TetMesh& mesh, const Bound& within) {
  if (!is_whole(mesh)) return 0;
  const double diagonal = within.value != 0 && mesh.positions.components == 3 ? diagonal_of(mesh) : 0;
  const double distance = within.absolute(diagonal);
  if (diagonal > 0 && !(distance >= 0 && distance <= kFarthest * diagonal))
    throw Error(ErrorCode::kBadArgument, "points " + number_text(distance) +
                                             " apart are not so by rounding: they are welded within a thousandth of "
                                             "the diagonal at most, which is " +
                                             number_text(kFarthest * diagonal));
  std::uint64_t gone = merge(mesh, find_firsts(mesh));
  if (diagonal > 0 && std::isfinite(distance))
    gone += merge(mesh, NearFirsts(mesh, distance, distance / diagonal).find());
  return gone;
}

} // namespace ptet
