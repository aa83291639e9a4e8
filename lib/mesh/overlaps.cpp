#include "mesh/overlaps.hpp"

#include "mesh/box_tree.hpp"
#include "mesh/by_parts.hpp"
#include "mesh/closest_point.hpp"
#include "mesh/face_plane.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

namespace ptet {
namespace {

using Corners = std::array<Point, 3>;

/// Whether the segment from p to q surely goes through the inside of the triangle: +1 from its inner side to its outer
/// side, -1 the other way; 0 when it surely does not, nothing when that is too close to tell.
std::optional<int> passing(const Point& p, const Point& q, const Corners& t) {
  const int from = sure_orientation(t[0], t[1], t[2], p);
  const int to = sure_orientation(t[0], t[1], t[2], q);
  if (from != 0 && from == to) return 0;
  std::array<int, 3> side{};
  for (std::size_t i = 0; i < 3; ++i)
    side[i] = sure_orientation(p, q, t[i], t[(i + 1) % 3]);
  const bool any_positive = std::find(side.begin(), side.end(), 1) != side.end();
  const bool any_negative = std::find(side.begin(), side.end(), -1) != side.end();
  if (any_positive && any_negative) return 0;
  if (from == 0 || to == 0 || std::find(side.begin(), side.end(), 0) != side.end()) return std::nullopt;
  return to;
}

/// Whether corners surely lie on both sides of the plane: what crosses the inside of its face has such.
bool surely_straddle(const Corners& corners, const FacePlane& plane) {
  bool before = false, behind = false;
  for (const Point& p : corners) {
    const int side = plane.sure_side(p);
    before |= side > 0;
    behind |= side < 0;
  }
  return before && behind;
}

/// Which way round p the points a and b follow one another, seen from the positive end of the axis; 0 when that is too
/// close to tell. Source of the bound: Shewchuk's orient2d, stage A, as in mesh/predicates.hpp.
int sure_turn(const Point& p, const Point& a, const Point& b, std::size_t axis) {
  const std::size_t x = (axis + 1) % 3, y = (axis + 2) % 3;
  const double one = (a[x] - p[x]) * (b[y] - p[y]), other = (a[y] - p[y]) * (b[x] - p[x]);
  const double bound = 0x1p-51 * (std::abs(one) + std::abs(other)) + 1e-300;
  if (one - other > bound) return 1;
  return one - other < -bound ? -1 : 0;
}

/// `passing` for the ray from p along the axis.
std::optional<int> ray_passing(const Point& p, const Corners& t, std::size_t axis) {
  const std::array<int, 3> turn = {sure_turn(p, t[0], t[1], axis), sure_turn(p, t[1], t[2], axis),
                                   sure_turn(p, t[2], t[0], axis)};
  const auto [least, greatest] = std::minmax({turn[0], turn[1], turn[2]});
  if (least < 0 && greatest > 0) return 0;
  if (t[0][axis] < p[axis] && t[1][axis] < p[axis] && t[2][axis] < p[axis]) return 0;
  if (least != greatest || least == 0) return std::nullopt;
  const int from = sure_orientation(t[0], t[1], t[2], p); // far out, the ray is on the side that the normal leans to
  if (from == 0) return std::nullopt;
  return from == least ? 0 : least;
}

class Finder {
public:
  Finder(std::span<const Point> points, std::span<const Tet> tets, const BoundarySurface& boundary)
      : points_(points), tets_(tets), boundary_(boundary), tree_(boxes_of(points, boundary.faces)),
        axis_(shortest_axis(tree_.nodes()[0].box)) {}

  [[nodiscard]] Overlaps run(double rounding, const std::function<void()>& look) const {
    Overlaps found;
    for_all(boundary_.faces.size(), found.crossing, look,
            [&](std::uint32_t f, auto& crossing) { find_crossing(f, crossing); });
    std::sort(found.crossing.begin(), found.crossing.end());
    for_all(boundary_.faces.size(), found.within, look, [&](std::uint32_t f, auto& within) {
      if (covering(f) > 1) within.push_back(boundary_.half_faces[f] / 4);
    });
    found.within.erase(std::unique(found.within.begin(), found.within.end()), found.within.end()); // by several faces
    const std::vector<VertexId> vertices = boundary_vertices_besides(found.crossing);
    for_all(vertices.size(), found.hanging, look, [&](std::uint32_t i, auto& hanging) {
      if (hangs(vertices[i], rounding)) hanging.push_back(vertices[i]);
    });
    return found;
  }

private:
  /// How far behind a face is looked, as a part of the height of its tet.
  static constexpr double kBehind = .01;
  /// A tenth of a second of work where the boxes of thousands meet one another.
  static constexpr std::size_t kBetweenLooks = 1024;
  static constexpr std::size_t kTogether = 64;
  static constexpr double kAwayFromCorners = 256; ///< times what rounding may move a point
  static constexpr double kAgainst = 0.999;       ///< cosine of the angle between a face and one that it lies against

  /// Calls `visit(i, what it finds)` for 0 .. count - 1, in parallel; `found` gets it all in their order.
  template <class What, class Visit>
  void for_all(std::size_t count, std::vector<What>& found, const std::function<void()>& look, Visit&& visit) const {
    for (std::size_t begin = 0; begin < count; begin += kBetweenLooks) {
      look();
      const auto visit_run = [&](std::vector<What>& part, std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i)
          visit(static_cast<std::uint32_t>(i), part);
      };
      const std::size_t end = std::min(begin + kBetweenLooks, count);
      for (const std::vector<What>& part : by_parts<std::vector<What>>(begin, end, kTogether, visit_run))
        append(found, part);
    }
  }

  static std::vector<BoundingBox> boxes_of(std::span<const Point> points, const std::vector<Face>& faces) {
    std::vector<BoundingBox> boxes;
    boxes.reserve(faces.size());
    for (const Face& face : faces)
      boxes.push_back(box_of<3>({points[face[0].index()], points[face[1].index()], points[face[2].index()]}));
    return boxes;
  }
  static std::size_t shortest_axis(const BoundingBox& box) {
    const auto extent = [&](std::size_t axis) { return box.high[axis] - box.low[axis]; };
    return std::min<std::size_t>({0, 1, 2}, [&](std::size_t a, std::size_t b) { return extent(a) < extent(b); });
  }
  [[nodiscard]] Corners corners(std::uint32_t face) const {
    const Face& f = boundary_.faces[face];
    return {points_[f[0].index()], points_[f[1].index()], points_[f[2].index()]};
  }

  void find_crossing(std::uint32_t f, std::vector<std::array<HalfFace, 2>>& found) const {
    const Corners s = corners(f);
    const FacePlane plane(boundary_.faces[f], points_);
    tree_.each_meeting(box_of(s), f + 1, [&](std::uint32_t other) {
      if (share_vertex(boundary_.faces[f], boundary_.faces[other])) return;
      const Corners t = corners(other);
      // Most faces that only touch, as those of tets with points of their own do, end here.
      if (!surely_straddle(t, plane) || !surely_straddle(s, FacePlane(boundary_.faces[other], points_))) return;
      bool cross = false;
      for (std::size_t i = 0; i < 3 && !cross; ++i)
        cross = passing(s[i], s[(i + 1) % 3], t).value_or(0) != 0 || passing(t[i], t[(i + 1) % 3], s).value_or(0) != 0;
      if (!cross) return;
      found.push_back({boundary_.half_faces[f], boundary_.half_faces[other]}); // ascending
    });
  }

  /// Those of no face that crosses another, which comes near to some of its corners by chance.
  [[nodiscard]] std::vector<VertexId>
  boundary_vertices_besides(const std::vector<std::array<HalfFace, 2>>& crossing) const {
    std::vector<VertexId> vertices, left_out;
    vertices.reserve(3 * boundary_.faces.size());
    for (const Face& face : boundary_.faces)
      vertices.insert(vertices.end(), face.begin(), face.end());
    for (const auto& pair : crossing)
      for (const HalfFace h : pair)
        for (const VertexId v : face_of(tets_, h))
          left_out.push_back(v);
    for (std::vector<VertexId>* const ids : {&vertices, &left_out}) {
      std::sort(ids->begin(), ids->end());
      ids->erase(std::unique(ids->begin(), ids->end()), ids->end());
    }
    std::vector<VertexId> besides;
    std::set_difference(vertices.begin(), vertices.end(), left_out.begin(), left_out.end(),
                        std::back_inserter(besides));
    return besides;
  }

  /// Whether a vertex lies on a face, and one of its own faces lies against that. A vertex at a corner's place hangs on
  /// no face there: it is a body's that has points of its own.
  [[nodiscard]] bool hangs(VertexId v, double relative_rounding) const {
    using namespace vec;
    const Point& p = points_[v.index()];
    const double rounding = relative_rounding * std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
    BoundingBox near{p, p};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      near.low[axis] -= rounding;
      near.high[axis] += rounding;
    }
    const double away_sq = std::pow(kAwayFromCorners * rounding, 2);
    const auto is_on = [&](const Corners& corner) {
      return std::all_of(corner.begin(), corner.end(), [&](const Point& c) { return dot(p - c, p - c) > away_sq; }) &&
             closest_on_triangle(p, corner[0], corner[1], corner[2]).distance_sq <= rounding * rounding;
    };
    std::vector<std::uint32_t> own, under;
    tree_.each_meeting(near, [&](std::uint32_t f) {
      const Face& face = boundary_.faces[f];
      if (std::find(face.begin(), face.end(), v) != face.end())
        own.push_back(f);
      else if (is_on(corners(f)))
        under.push_back(f);
    });
    const auto normal_of = [&](std::uint32_t f) {
      const Corners corner = corners(f);
      return direction_of(cross(corner[1] - corner[0], corner[2] - corner[0])).value_or(Vec3{});
    };
    return std::any_of(under.begin(), under.end(), [&](std::uint32_t f) {
      const Vec3 n = normal_of(f);
      return std::any_of(own.begin(), own.end(), [&](std::uint32_t g) { return dot(n, normal_of(g)) < -kAgainst; });
    });
  }

  /// How many tets hold a point right behind the middle of the boundary face, or 1 where that is too close to tell.
  [[nodiscard]] int covering(std::uint32_t face) const {
    const Corners corner = corners(face);
    const HalfFace h = boundary_.half_faces[face];
    const Point& apex = points_[apex_of(tets_, h).index()];
    // From the centroid, or beside it when the ray comes upon an edge.
    for (const auto& weight : {std::array{.34, .33, .33}, std::array{.38, .33, .29}, std::array{.28, .32, .4}}) {
      Point p{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        p[axis] =
            (1 - kBehind) * (weight[0] * corner[0][axis] + weight[1] * corner[1][axis] + weight[2] * corner[2][axis]) +
            kBehind * apex[axis];
      if (!holds(h / 4, p)) return 1;
      if (const std::optional<int> count = leaving(p)) return *count;
    }
    return 1;
  }
  [[nodiscard]] bool holds(std::uint32_t t, const Point& p) const {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const Face face = face_of(tets_, 4 * t + k);
      if (sure_orientation(points_[face[0].index()], points_[face[1].index()], points_[face[2].index()], p) != -1)
        return false;
    }
    return true;
  }

  /// How often a ray leaves the mesh, less how often it enters it.
  [[nodiscard]] std::optional<int> leaving(const Point& p) const {
    BoundingBox ray{p, p};
    ray.high[axis_] = tree_.nodes()[0].box.high[axis_];
    int count = 0;
    bool sure = true;
    tree_.each_meeting(ray, [&](std::uint32_t face) {
      if (!sure) return;
      const std::optional<int> passed = ray_passing(p, corners(face), axis_);
      sure = sure && passed.has_value();
      count += passed.value_or(0);
    });
    return sure ? std::optional(count) : std::nullopt;
  }

  std::span<const Point> points_;
  std::span<const Tet> tets_;
  const BoundarySurface& boundary_;
  BoxTree tree_;
  std::size_t axis_; ///< of the rays: along it the mesh is shortest, and the fewest faces lie in a row
};

} // namespace

Overlaps find_overlaps(std::span<const Point> points, std::span<const Tet> tets, const BoundarySurface& boundary,
                       double rounding, const std::function<void()>& look) {
  return boundary.faces.empty() ? Overlaps{} : Finder(points, tets, boundary).run(rounding, look);
}

} // namespace ptet
