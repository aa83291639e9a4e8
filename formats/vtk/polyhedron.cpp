#include "formats/vtk/polyhedron.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

namespace ptet::vtkio {
namespace {

/// In cubes of the numbers of corners of faces: some 30 milliseconds.
constexpr std::size_t kWorkBetweenLooks = std::size_t{1} << 25;

/// An edge as a face passes it.
struct Side {
  VertexId low, high;
  std::uint32_t face = 0;
  bool is_upward = false;
};

/// Two faces at an edge, both ways round.
struct Link {
  std::uint32_t face = 0, other = 0;
  bool is_alike = false; ///< they pass it in opposite directions, as faces of one orientation do
};

/// In the order of edges.
std::vector<Side> sides_of(const std::vector<Polygon>& faces) {
  std::vector<Side> sides;
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    for (std::size_t i = 0; i < faces[f].size(); ++i) {
      const VertexId from = faces[f][i], to = faces[f][(i + 1) % faces[f].size()];
      sides.push_back({std::min(from, to), std::max(from, to), f, from < to});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
  });
  return sides;
}

/// Calls `visit(first, end)` with the sides at each edge, as long as it returns true; returns whether it always did.
template <class Visit>
bool each_edge(const std::vector<Side>& sides, Visit&& visit) {
  for (std::size_t first = 0, end = 0; first < sides.size(); first = end) {
    while (end < sides.size() && sides[end].low == sides[first].low && sides[end].high == sides[first].high)
      ++end;
    if (!visit(first, end)) return false;
  }
  return true;
}

bool are_alike(const std::vector<Side>& sides) {
  return each_edge(sides, [&](std::size_t first, std::size_t end) {
    std::size_t upward = 0;
    for (std::size_t i = first; i < end; ++i)
      upward += sides[i].is_upward ? 1 : 0;
    return 2 * upward == end - first;
  });
}

/// Turns faces over until all are of one orientation, in or out. Returns false where they do not close.
bool turn_alike(std::vector<Polygon>& faces) {
  const std::vector<Side> sides = sides_of(faces);
  if (are_alike(sides)) return true;
  std::vector<Link> links;
  const bool is_closed = each_edge(sides, [&](std::size_t first, std::size_t end) {
    if (end - first != 2) return false;
    const Side &a = sides[first], &b = sides[first + 1];
    links.push_back({a.face, b.face, a.is_upward != b.is_upward});
    links.push_back({b.face, a.face, a.is_upward != b.is_upward});
    return true;
  });
  if (!is_closed) return false;
  std::sort(links.begin(), links.end(), [](const Link& a, const Link& b) { return a.face < b.face; });

  enum class Way : std::uint8_t { kUnknown, kKept, kTurned };
  std::vector<Way> ways(faces.size(), Way::kUnknown);
  std::vector<std::uint32_t> open;
  for (std::uint32_t start = 0; start < faces.size(); ++start) {
    if (ways[start] != Way::kUnknown) continue;
    ways[start] = Way::kKept;
    open.assign(1, start);
    while (!open.empty()) {
      const std::uint32_t face = open.back();
      open.pop_back();
      auto link = std::lower_bound(links.begin(), links.end(), face,
                                   [](const Link& l, std::uint32_t wanted) { return l.face < wanted; });
      for (; link != links.end() && link->face == face; ++link) {
        const Way way = (ways[face] == Way::kKept) == link->is_alike ? Way::kKept : Way::kTurned;
        if (ways[link->other] == Way::kUnknown) {
          ways[link->other] = way;
          open.push_back(link->other);
        } else if (ways[link->other] != way) {
          return false; // a surface of one side, as a Moebius strip
        }
      }
    }
  }
  for (std::uint32_t f = 0; f < faces.size(); ++f)
    if (ways[f] == Way::kTurned) std::reverse(faces[f].begin(), faces[f].end());
  return true;
}

/// Corners that repeat the one before, and faces without an area for it.
void drop_repeated(std::vector<Polygon>& faces) {
  for (Polygon& face : faces) {
    face.erase(std::unique(face.begin(), face.end()), face.end());
    while (face.size() > 1 && face.front() == face.back())
      face.pop_back();
  }
  std::erase_if(faces, [](const Polygon& face) { return face.size() < 3; });
}

/// Twice the area, along the normal, of a polygon that may be warped.
Vec3 area_vector(const Polygon& polygon, const TetMesh& mesh) {
  using namespace vec;
  const Point origin = mesh.position(polygon[0]);
  Vec3 sum{};
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    sum = sum + cross(mesh.position(polygon[i]) - origin, mesh.position(polygon[i + 1]) - origin);
  return sum;
}

/// A polygon so cut into triangles that the worst of these is as good as can be, its area beside its sides, and none is
/// flat where that can be.
class PolygonCutter {
public:
  explicit PolygonCutter(const TetMesh& mesh) : mesh_(mesh) {}

  void append_triangles(const Polygon& polygon, std::vector<Face>& triangles) {
    const bool is_turned = start_alike(polygon);
    const std::size_t n = corners_.size();
    const Vec3 normal = area_vector(corners_, mesh_);
    points_.clear();
    for (const VertexId v : corners_)
      points_.push_back(mesh_.position(v));
    best_.assign(n * n, {std::numeric_limits<double>::infinity(), 0});
    for (std::size_t length = 2; length < n; ++length) {
      for (std::size_t i = 0; i + length < n; ++i) {
        Cut& best = cut(i, i + length);
        best = {-std::numeric_limits<double>::infinity(), i + 1};
        for (std::size_t k = i + 1; k < i + length; ++k) {
          const double worst = std::min({shape(i, k, i + length, normal), cut(i, k).worst, cut(k, i + length).worst});
          if (worst > best.worst) best = {worst, k};
        }
      }
    }
    parts_.assign(1, {0, n - 1});
    while (!parts_.empty()) {
      const auto [first, last] = parts_.back();
      parts_.pop_back();
      if (last - first < 2) continue;
      const std::size_t k = cut(first, last).at;
      triangles.push_back(is_turned ? Face{corners_[first], corners_[last], corners_[k]}
                                    : Face{corners_[first], corners_[k], corners_[last]});
      parts_.emplace_back(first, k);
      parts_.emplace_back(k, last);
    }
  }

private:
  struct Cut {
    double worst = 0;
    std::size_t at = 0;
  };

  /// Puts the polygon in corners_, from its first corner by position on, towards that beside it which comes first: both
  /// cells at a face find the same. Returns whether that is the other way round.
  bool start_alike(const Polygon& polygon) {
    const auto is_before = [&](VertexId a, VertexId b) {
      return std::make_tuple(mesh_.position(a), a) < std::make_tuple(mesh_.position(b), b);
    };
    corners_ = polygon;
    std::rotate(corners_.begin(), std::min_element(corners_.begin(), corners_.end(), is_before), corners_.end());
    const bool is_turned = is_before(corners_.back(), corners_[1]);
    if (is_turned) std::reverse(corners_.begin() + 1, corners_.end());
    return is_turned;
  }

  Cut& cut(std::size_t first, std::size_t last) { return best_[first * corners_.size() + last]; }

  [[nodiscard]] double shape(std::size_t a, std::size_t b, std::size_t c, const Vec3& normal) const {
    using namespace vec;
    const Vec3 ab = points_[b] - points_[a], ac = points_[c] - points_[a], bc = points_[c] - points_[b];
    const double squares = dot(ab, ab) + dot(ac, ac) + dot(bc, bc);
    return squares > 0 ? dot(cross(ab, ac), normal) / squares : 0;
  }

  const TetMesh& mesh_;
  Polygon corners_;
  std::vector<Point> points_;
  std::vector<Cut> best_; ///< by the first and the last corner of a part of the polygon
  std::vector<std::pair<std::size_t, std::size_t>> parts_;
};

/// Ascending.
std::vector<VertexId> points_of(const std::vector<Polygon>& faces) {
  std::vector<VertexId> points;
  for (const Polygon& face : faces)
    points.insert(points.end(), face.begin(), face.end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// Six times the volume, by the sign of which the faces look out or in.
double signed_volume(const std::vector<Polygon>& faces, const TetMesh& mesh) {
  using namespace vec;
  const Point origin = mesh.position(faces[0][0]);
  double volume = 0;
  for (const Polygon& face : faces)
    volume += dot(area_vector(face, mesh), mesh.position(face[0]) - origin);
  return volume;
}

} // namespace

bool split_polyhedron(std::vector<Polygon>& faces, const TetMesh& positions, const std::function<void()>& look,
                      SplitPolyhedron& to) {
  drop_repeated(faces);
  if (faces.empty() || !turn_alike(faces)) return false;
  if (signed_volume(faces, positions) < 0)
    for (Polygon& face : faces)
      std::reverse(face.begin(), face.end());

  to.surface.triangles.clear();
  to.surface.quadrilaterals.clear();
  PolygonCutter cutter(positions);
  std::size_t work = 0;
  for (const Polygon& face : faces) {
    const std::size_t n = face.size();
    if (n == 3)
      to.surface.triangles.push_back({face[0], face[1], face[2]});
    else if (n == 4)
      to.surface.quadrilaterals.push_back({face[0], face[1], face[2], face[3]});
    else
      cutter.append_triangles(face, to.surface.triangles);
    work += n * n * n;
    if (work > kWorkBetweenLooks) {
      look();
      work = 0;
    }
  }
  std::erase_if(to.surface.triangles, [](const Face& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  // Corners that repeat are not beside one another any more: both of its triangles have one twice.
  std::erase_if(to.surface.quadrilaterals, [](const auto& q) { return q[0] == q[2] || q[1] == q[3]; });

  to.middle = seeing_middle(points_of(faces), to.surface, positions, look);
  return true;
}

} // namespace ptet::vtkio
