#include "formats/vtk/polyhedron.hpp"

#include "mesh/scalar_dispatch.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>
#include <type_traits>

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

std::vector<VertexId> points_of(const std::vector<Polygon>& faces) {
  std::vector<VertexId> points;
  for (const Polygon& face : faces)
    points.insert(points.end(), face.begin(), face.end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

void weigh_alike(MeanPoint& mean) {
  mean.weights.assign(mean.points.size(), 1 / static_cast<double>(mean.points.size()));
}

/// The middle of the surface: where one end of a cell has many more points than the other their mean may be too near
/// it.
void weigh_by_area(SplitPolyhedron& split, const TetMesh& mesh) {
  using namespace vec;
  MeanPoint& mean = split.middle;
  std::vector<double> weights(mean.points.size(), 0);
  double whole = 0;
  const auto add = [&](VertexId a, VertexId b, VertexId c, double share) {
    const Point at = mesh.position(a);
    const double area = share * norm(cross(mesh.position(b) - at, mesh.position(c) - at));
    for (const VertexId v : {a, b, c}) {
      const auto of_point = std::lower_bound(mean.points.begin(), mean.points.end(), v) - mean.points.begin();
      weights[static_cast<std::size_t>(of_point)] += area;
      whole += area;
    }
  };
  for (const auto& [a, b, c] : split.triangles)
    add(a, b, c, 1);
  for (const auto& [a, b, c, d] : split.quadrilaterals) { // by both diagonals
    add(a, b, c, 0.5);
    add(a, c, d, 0.5);
    add(b, c, d, 0.5);
    add(b, d, a, 0.5);
  }
  if (!(whole > 0) || !std::isfinite(whole)) return;
  for (double& weight : weights)
    weight /= whole;
  mean.weights = std::move(weights);
}

/// a - b, exact where it is small.
template <class T>
double difference(T a, T b) {
  if constexpr (std::is_integral_v<T> && sizeof(T) == 8) {
    using Unsigned = std::make_unsigned_t<T>; // the difference may pass a T
    return a >= b ? static_cast<double>(static_cast<Unsigned>(a) - static_cast<Unsigned>(b))
                  : -static_cast<double>(static_cast<Unsigned>(b) - static_cast<Unsigned>(a));
  } else {
    return static_cast<double>(a) - static_cast<double>(b);
  }
}

/// first + difference, which lies between 0 and that of another value.
template <class T>
T moved_by(T first, double by) {
  if constexpr (std::is_integral_v<T>) {
    using Unsigned = std::make_unsigned_t<T>;
    const auto steps = static_cast<Unsigned>(std::abs(std::round(by)));
    return static_cast<T>(by < 0 ? static_cast<Unsigned>(first) - steps : static_cast<Unsigned>(first) + steps);
  } else {
    return static_cast<T>(static_cast<double>(first) + by);
  }
}

/// Of the rows of one component, from the first on: of equal numbers it is that number, in every bit of an integer.
template <class T>
T mean_of(const PointArray& array, std::uint32_t component, const MeanPoint& mean) {
  const auto value = [&](std::size_t i) {
    return load<T>(array.bytes.data() + mean.points[i].index() * array.row_bytes() + component * sizeof(T));
  };
  const T first = value(0);
  T least = first, greatest = first;
  double sum = 0;
  for (std::size_t i = 0; i < mean.points.size(); ++i) {
    least = std::min(least, value(i));
    greatest = std::max(greatest, value(i));
    sum += mean.weights[i] * difference(value(i), first);
  }
  if constexpr (std::is_floating_point_v<T>) {
    if (least == greatest) return first;
    if (!std::isfinite(sum)) { // infinities, or numbers too far apart
      double all = 0;
      for (std::size_t i = 0; i < mean.points.size(); ++i)
        if (mean.weights[i] > 0) all += mean.weights[i] * static_cast<double>(value(i));
      return static_cast<T>(all);
    }
  }
  if (sum >= difference(greatest, first)) return greatest;
  if (sum <= difference(least, first)) return least;
  return std::clamp(moved_by(first, sum), least, greatest);
}

Point position_of(const MeanPoint& mean, const PointArray& positions) {
  Point at{};
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    at[axis] = dispatch(positions.type,
                        [&](auto type) { return static_cast<double>(mean_of<decltype(type)>(positions, axis, mean)); });
  return at;
}

/// How many triangles the middle sees from behind, with those of a quadrilateral by both diagonals.
std::size_t count_turned(const SplitPolyhedron& split, const TetMesh& mesh) {
  const Point middle = position_of(split.middle, mesh.positions);
  const auto is_turned = [&](VertexId a, VertexId b, VertexId c) {
    return sure_orientation(middle, mesh.position(a), mesh.position(b), mesh.position(c)) < 0;
  };
  std::size_t turned = 0;
  for (const auto& [a, b, c] : split.triangles)
    turned += is_turned(a, b, c) ? 1 : 0;
  for (const auto& [a, b, c, d] : split.quadrilaterals)
    for (const auto& [p, q, r] : {Face{a, b, c}, Face{b, c, d}, Face{c, d, a}, Face{d, a, b}})
      turned += is_turned(p, q, r) ? 1 : 0;
  return turned;
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

  to.triangles.clear();
  to.quadrilaterals.clear();
  PolygonCutter cutter(positions);
  std::size_t work = 0;
  for (const Polygon& face : faces) {
    const std::size_t n = face.size();
    if (n == 3)
      to.triangles.push_back({face[0], face[1], face[2]});
    else if (n == 4)
      to.quadrilaterals.push_back({face[0], face[1], face[2], face[3]});
    else
      cutter.append_triangles(face, to.triangles);
    work += n * n * n;
    if (work > kWorkBetweenLooks) {
      look();
      work = 0;
    }
  }
  std::erase_if(to.triangles, [](const Face& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  // Corners that repeat are not beside one another any more: both of its triangles have one twice.
  std::erase_if(to.quadrilaterals, [](const auto& q) { return q[0] == q[2] || q[1] == q[3]; });

  to.middle.points = points_of(faces);
  weigh_alike(to.middle);
  if (const std::size_t turned = count_turned(to, positions); turned != 0) {
    const std::vector<double> alike = to.middle.weights;
    weigh_by_area(to, positions);
    if (count_turned(to, positions) >= turned) to.middle.weights = alike;
  }
  const Point middle = position_of(to.middle, positions.positions);
  to.is_turned = std::any_of(to.triangles.begin(), to.triangles.end(), [&](const Face& t) {
    return sure_orientation(middle, positions.position(t[0]), positions.position(t[1]), positions.position(t[2])) < 0;
  });
  return true;
}

void append_mean(PointArray& array, const MeanPoint& mean) {
  const std::size_t row = array.bytes.size();
  array.bytes.resize(row + array.row_bytes());
  for (std::uint32_t c = 0; c < array.components; ++c)
    dispatch(array.type, [&](auto type) {
      using T = decltype(type);
      store<T>(array.bytes.data() + row + c * sizeof(T), mean_of<T>(array, c, mean));
    });
}

} // namespace ptet::vtkio
