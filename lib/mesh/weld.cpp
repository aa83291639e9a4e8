#include "ptet/weld.hpp"

#include "mesh/box_tree.hpp"
#include "mesh/number_text.hpp"
#include "mesh/predicates.hpp"
#include "mesh/rows.hpp"
#include "mesh/topology.hpp"
#include "mesh/vec3.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include <boost/container_hash/hash.hpp>

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
/// No more points are looked at for one: where as many stay in one place, as a pile with values of their own does, they
/// are no seam.
constexpr std::size_t kMostNear = 1024;
/// Of vertices: a second of work at most, but where they stay in piles.
constexpr std::size_t kBetweenLooks = 0x10000;

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
    if (is_at_boundary[v] != 0 && is_finite(p)) found.push_back(v);
  }
  return found;
}

/// By vertex, for some of them: the tets that it is a corner of.
class Stars {
public:
  Stars(const TetMesh& mesh, const std::vector<std::uint32_t>& of) : mesh_(mesh), begin_(mesh.vertex_count() + 1) {
    std::vector<char> is_asked_for(mesh.vertex_count());
    for (const std::uint32_t v : of)
      is_asked_for[v] = 1;
    for (const Tet& tet : mesh.tets)
      for (const VertexId v : tet)
        begin_[v.index() + 1] += is_asked_for[v.index()] != 0 ? 1 : 0;
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    tets_.resize(begin_.back());
    std::vector<std::uint64_t> next(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t t = 0; t < mesh.tets.size(); ++t)
      for (const VertexId v : mesh.tets[t])
        if (is_asked_for[v.index()] != 0) tets_[next[v.index()]++] = t;
  }

  [[nodiscard]] std::span<const std::uint32_t> tets_at(std::uint32_t v) const {
    return std::span(tets_).subspan(begin_[v], begin_[v + 1] - begin_[v]);
  }
  /// Whether a tet has `v` and another corner that becomes `other`.
  [[nodiscard]] bool join(std::uint32_t v, std::uint32_t other, const std::vector<std::uint32_t>& first) const {
    const std::span<const std::uint32_t> tets = tets_at(v);
    return std::any_of(tets.begin(), tets.end(), [&](std::uint32_t t) {
      const Tet& tet = mesh_.tets[t];
      return std::any_of(tet.begin(), tet.end(),
                         [&](VertexId corner) { return corner.index() != v && first[corner.index()] == other; });
    });
  }

private:
  const TetMesh& mesh_;
  std::vector<std::uint64_t> begin_;
  std::vector<std::uint32_t> tets_;
};

/// Points by the cells of a grid.
class PointGrid {
public:
  /// `distance`: that each_near() looks for; `largest`: of all coordinates, so that cells have numbers.
  PointGrid(double distance, double largest) : size_(std::max(distance, 0x1p-48 * largest)) {}

  void add(std::uint32_t v, const Point& p) { cells_[cell_of(p)].push_back(v); }
  /// Calls `visit(v)` for each point in the cell of `p` and those around it, as long as it returns true.
  template <class Visit>
  void each_near(const Point& p, Visit&& visit) const {
    const Cell middle = cell_of(p);
    constexpr std::array<std::int64_t, 3> kSteps = {0, -1, 1}; // the middle first: the most likely one
    for (const std::int64_t x : kSteps)
      for (const std::int64_t y : kSteps)
        for (const std::int64_t z : kSteps) {
          const auto found = cells_.find({middle[0] + x, middle[1] + y, middle[2] + z});
          if (found == cells_.end()) continue;
          for (const std::uint32_t v : found->second)
            if (!visit(v)) return;
        }
  }

private:
  using Cell = std::array<std::int64_t, 3>;
  [[nodiscard]] Cell cell_of(const Point& p) const {
    Cell cell{};
    std::transform(p.begin(), p.end(), cell.begin(),
                   [&](double x) { return static_cast<std::int64_t>(std::floor(x / size_)); });
    return cell;
  }

  double size_;
  std::unordered_map<Cell, std::vector<std::uint32_t>, boost::hash<Cell>> cells_;
};

/// How far apart the values of an array may be that are one but for rounding.
class ValueTolerance {
public:
  ValueTolerance(const PointArray& array, const std::vector<char>& used, double share) : array_(&array) {
    if (array.type != ScalarType::kFloat32 && array.type != ScalarType::kFloat64) return;
    double range = 0, largest = 0;
    for (std::uint32_t c = 0; c < array.components; ++c) {
      double least = std::numeric_limits<double>::infinity(), greatest = -least;
      for (std::size_t row = 0; row < used.size(); ++row) {
        const double x = array.value(row, c);
        if (used[row] == 0 || !std::isfinite(x)) continue;
        least = std::min(least, x);
        greatest = std::max(greatest, x);
      }
      if (least > greatest) continue; // no number
      range = std::max(range, greatest - least);
      largest = std::max({largest, std::abs(least), std::abs(greatest)});
    }
    const double last_place = array.type == ScalarType::kFloat32 ? 0x1p-23 : 0x1p-52;
    most_ = std::max(std::isfinite(range) ? share * range : 0, last_place * largest);
  }

  [[nodiscard]] bool takes(std::uint32_t a, std::uint32_t b) const {
    if (compare_rows(*array_, a, b) == 0) return true;
    for (std::uint32_t c = 0; most_ && c < array_->components; ++c) {
      const double x = array_->value(a, c), y = array_->value(b, c);
      if (!(x == y || (std::isnan(x) && std::isnan(y)) || std::abs(x - y) <= *most_)) return false;
    }
    return most_.has_value();
  }

private:
  const PointArray* array_;
  std::optional<double> most_; ///< none: the rows must be equal
};

/// By vertex: the one that it becomes. Taken in the order of their ids, each becomes the nearest of those that stayed
/// within the distance and with values as near, and that no tet joins it to, as edges may be shorter; none such, and it
/// stays. So no chain of points becomes one, nor do two corners of a tet.
std::vector<std::uint32_t> find_near_firsts(const TetMesh& mesh, const std::vector<std::uint32_t>& vertices,
                                            const Stars& stars, double distance, double share,
                                            const std::function<void()>& look) {
  using namespace vec;
  std::vector<std::uint32_t> first(mesh.vertex_count());
  std::iota(first.begin(), first.end(), 0U);
  std::vector<char> used(mesh.vertex_count());
  for (const Tet& tet : mesh.tets)
    for (const VertexId v : tet)
      used[v.index()] = 1;
  std::vector<ValueTolerance> tolerances;
  tolerances.reserve(mesh.point_arrays.size());
  for (const PointArray& array : mesh.point_arrays)
    tolerances.emplace_back(array, used, share);
  look();
  double largest = 0;
  for (const std::uint32_t v : vertices)
    for (const double x : mesh.position(VertexId{v}))
      largest = std::max(largest, std::abs(x));
  PointGrid stayed(distance, largest);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (i % kBetweenLooks == 0) look();
    const std::uint32_t v = vertices[i];
    const Point p = mesh.position(VertexId{v});
    double nearest = distance;
    std::size_t left = kMostNear;
    stayed.each_near(p, [&](std::uint32_t other) {
      const double away = norm(p - mesh.position(VertexId{other}));
      const bool is_nearer = away < nearest || (away == nearest && (first[v] == v || other < first[v]));
      if (is_nearer &&
          std::all_of(tolerances.begin(), tolerances.end(),
                      [&](const ValueTolerance& tolerance) { return tolerance.takes(v, other); }) &&
          !stars.join(v, other, first)) {
        nearest = away;
        first[v] = other;
      }
      return --left > 0;
    });
    if (first[v] == v) stayed.add(v, p);
  }
  return first;
}

/// Whether a tet stays on its side, or flat; of one that has corners at no place there is nothing to keep.
bool keeps_orientation(const TetMesh& mesh, const Tet& tet, const std::vector<std::uint32_t>& first) {
  std::array<Point, 4> was, is;
  for (std::size_t i = 0; i < 4; ++i) {
    was[i] = mesh.position(tet[i]);
    is[i] = mesh.position(VertexId{first[tet[i].index()]});
    if (!is_finite(was[i])) return true;
  }
  return orientation(was[0], was[1], was[2], was[3]) == orientation(is[0], is[1], is[2], is[3]);
}

/// How far a vertex goes; negative: it stays.
double way_of(const TetMesh& mesh, VertexId v, const std::vector<std::uint32_t>& first) {
  using namespace vec;
  return first[v.index()] == v.index() ? -1 : norm(mesh.position(VertexId{first[v.index()]}) - mesh.position(v));
}

/// Where a tet would turn over or become flat, the corner that would go farthest stays where it is; and then the tets
/// around it are looked at.
void keep_orientations(const TetMesh& mesh, const Stars& stars, std::vector<std::uint32_t>& first,
                       const std::function<void()>& look) {
  const auto moves = [&](VertexId v) { return first[v.index()] != v.index(); };
  std::vector<std::uint32_t> open;
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t)
    if (std::any_of(mesh.tets[t].begin(), mesh.tets[t].end(), moves)) open.push_back(t);
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (i % kBetweenLooks == 0) look();
    const Tet& tet = mesh.tets[open[i]];
    if (std::none_of(tet.begin(), tet.end(), moves) || keeps_orientation(mesh, tet, first)) continue;
    const VertexId farthest = *std::max_element(tet.begin(), tet.end(), [&](VertexId a, VertexId b) {
      return way_of(mesh, a, first) < way_of(mesh, b, first);
    });
    first[farthest.index()] = farthest.index();
    const std::span<const std::uint32_t> around = stars.tets_at(farthest.index());
    open.insert(open.end(), around.begin(), around.end());
  }
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

/// Lets each vertex be the first of its like; returns how many went.
std::uint64_t merge(TetMesh& mesh, const std::vector<std::uint32_t>& first) {
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
      if (is_finite(p)) box.add(p);
    }
  return box.low[0] <= box.high[0] ? norm(box.high - box.low) : 0;
}

} // namespace

std::string welding_note(std::uint64_t points, const Bound& within) {
  return std::to_string(points) + (points == 1 ? " point was" : " points were") + " welded with others of " +
         (within.value > 0 ? "nearly " : "") + "the same place and values";
}

std::uint64_t weld_points(TetMesh& mesh, const Bound& within, const ProgressCallback& progress) {
  if (!is_whole(mesh)) return 0;
  const auto look = [&] {
    if (progress && !progress({"welding points", 0, 1})) throw Error(ErrorCode::kCancelled, "cancelled");
  };
  const double diagonal = within.value != 0 && mesh.positions.components == 3 ? diagonal_of(mesh) : 0;
  const double distance = within.absolute(diagonal);
  if (diagonal > 0 && !(distance >= 0 && distance <= kFarthest * diagonal))
    throw Error(ErrorCode::kBadArgument, "points " + number_text(distance) +
                                             " apart are not so by rounding: they are welded within a thousandth of "
                                             "the diagonal at most, which is " +
                                             number_text(kFarthest * diagonal));
  look();
  std::vector<std::uint32_t> first = find_firsts(mesh);
  keep_tets(mesh, first);
  look();
  std::uint64_t gone = merge(mesh, first);
  if (!(diagonal > 0 && distance > 0 && std::isfinite(distance))) return gone;
  // What is hardly apart first: where edges are shorter than the distance, that is what rounding has set apart. It is
  // inside of the mesh then, and goes no farther.
  for (const double part : {1e-6, 1e-3, 1.0}) {
    constexpr double kRounding = 0x1p-53;
    if (part < 1 && part * distance < kRounding * diagonal) continue;
    look();
    const std::vector<std::uint32_t> vertices = boundary_vertices(mesh);
    look();
    const Stars stars(mesh, vertices);
    first = find_near_firsts(mesh, vertices, stars, part * distance, part * distance / diagonal, look);
    keep_orientations(mesh, stars, first, look);
    gone += merge(mesh, first);
  }
  return gone;
}

} // namespace ptet
