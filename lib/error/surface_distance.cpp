#include "error/surface_distance.hpp"

#include "mesh/closest_point.hpp"
#include "mesh/local_origin.hpp"
#include "mesh/vec3.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace ptet {
using namespace vec;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kNone = 0xffffffff;
/// A cut along a surface triangle's edges must settle at least this share of the area.
constexpr double kWorthCutting = 1.0 / 16;
/// How far beyond its edges a triangle settles, against the distance that is good enough.
constexpr double kOverhang = 0.1;
/// Distances this small against the coordinates are rounding.
constexpr double kRounding = 1e-13;

double to_triangle_sq(const Point& p, const Triangle& t) {
  return closest_on_triangle(p, t[0], t[1], t[2]).distance_sq;
}

double greatest_sq(std::span<const Point> points, const Triangle& t) {
  double greatest = 0;
  for (const Point& p : points)
    greatest = std::max(greatest, to_triangle_sq(p, t));
  return greatest;
}

Point centroid(const Triangle& t) {
  return (1.0 / 3) * (t[0] + t[1] + t[2]);
}

double length_sq(const Vec3& a) {
  return dot(a, a);
}

double largest_coordinate(const Triangle& t) {
  double largest = 0;
  for (const Point& p : t)
    for (const double x : p)
      largest = std::max(largest, std::abs(x));
  return largest;
}

Triangle less(const Triangle& t, const Point& origin) {
  return {t[0] - origin, t[1] - origin, t[2] - origin};
}

Point origin_of(const std::vector<Triangle>& triangles) {
  if (triangles.empty()) return {};
  BoundingBox box;
  for (const Triangle& t : triangles)
    for (const Point& p : t)
      box.add(p);
  return local_origin(box.low, box.high);
}

/// Throws Error(kLimit) when 32-bit ids cannot name the triangles.
std::vector<BoundingBox> boxes_of(const std::vector<Triangle>& triangles, const Point& origin) {
  if (triangles.size() >= kNone) throw Error(ErrorCode::kLimit, "a surface may have at most 2^32 - 2 triangles");
  std::vector<BoundingBox> boxes(triangles.size());
  std::transform(triangles.begin(), triangles.end(), boxes.begin(),
                 [&](const Triangle& t) { return box_of(less(t, origin)); });
  return boxes;
}

/// A triangle that was cut three times at most. Where rounding lets a cut cross every edge, there are 4, 6, then 9
/// corners.
struct FlatPolygon {
  static constexpr std::size_t kMostCorners = 9;
  std::array<Point, kMostCorners> corner;
  std::size_t size = 0;

  void add(const Point& p) { corner[size++] = p; }
  [[nodiscard]] std::span<const Point> corners() const { return {corner.data(), size}; }
};

/// Cuts along the plane { x : dot(normal, x - origin) = offset * norm(normal) }.
void split(const FlatPolygon& polygon, const Point& origin, const Vec3& normal, double offset, FlatPolygon& inside,
           FlatPolygon& outside) {
  inside.size = outside.size = 0;
  const double level = offset * norm(normal);
  for (std::size_t i = 0; i < polygon.size; ++i) {
    const Point& p = polygon.corner[i];
    const Point& q = polygon.corner[(i + 1) % polygon.size];
    const double at_p = dot(normal, p - origin) - level;
    const double at_q = dot(normal, q - origin) - level;
    if (at_p <= 0) inside.add(p);
    if (at_p >= 0) outside.add(p);
    if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0)) {
      const Point cut = p + at_p / (at_p - at_q) * (q - p);
      inside.add(cut);
      outside.add(cut);
    }
  }
}

/// Twice the area.
double area_of(const FlatPolygon& polygon) {
  Vec3 sum{};
  for (std::size_t i = 2; i < polygon.size; ++i)
    sum = sum + cross(polygon.corner[i - 1] - polygon.corner[0], polygon.corner[i] - polygon.corner[0]);
  return norm(sum);
}

double perimeter_of(const FlatPolygon& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size; ++i)
    sum += norm(polygon.corner[(i + 1) % polygon.size] - polygon.corner[i]);
  return sum;
}

/// Whether the whole is hardly more than a segment: its area says nothing then.
bool is_needle(const FlatPolygon& polygon) {
  const double perimeter = perimeter_of(polygon);
  return !(area_of(polygon) > 1e-6 * perimeter * perimeter);
}

/// Whether taking `part` away leaves much less of `whole`: by area, or by length where the whole is hardly more than a
/// segment.
bool is_worth_cutting(const FlatPolygon& part, const FlatPolygon& whole) {
  if (!is_needle(whole)) return area_of(part) > kWorthCutting * area_of(whole);
  return perimeter_of(part) > std::sqrt(kWorthCutting) * perimeter_of(whole);
}

/// Whether a needle was cut along its length, where it may go on being cut for ever.
bool is_most_of(const FlatPolygon& part, const FlatPolygon& whole) {
  constexpr double kMost = 0.9;
  return is_needle(whole) && perimeter_of(part) > kMost * perimeter_of(whole);
}

} // namespace

std::vector<Triangle> triangles_of(std::span<const Point> points, std::span<const Face> faces) {
  std::vector<Triangle> triangles;
  triangles.reserve(faces.size());
  for (const auto& [a, b, c] : faces)
    triangles.push_back({points[a.index()], points[b.index()], points[c.index()]});
  return triangles;
}

TriangleSurface::TriangleSurface(const std::vector<Triangle>& triangles)
    : origin_(origin_of(triangles)), tree_(boxes_of(triangles, origin_)), slot_of_(triangles.size()) {
  triangles_.reserve(triangles.size());
  for (std::uint32_t slot = 0; slot < triangles.size(); ++slot) {
    slot_of_[tree_.order()[slot]] = slot;
    triangles_.push_back(less(triangles[tree_.order()[slot]], origin_));
    extent_ = std::max(extent_, largest_coordinate(triangles_.back()));
  }
}

void TriangleSurface::search(const Point& p, double& best_sq, std::uint32_t& slot) const {
  const auto to_box_sq = [&](const BoundingBox& box) {
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double gap = std::max({box.low[axis] - p[axis], 0.0, p[axis] - box.high[axis]});
      sum += gap * gap;
    }
    return sum;
  };
  struct Pending {
    std::uint32_t node;
    double distance_sq;
  };
  std::array<Pending, 64> pending;
  std::size_t count = 0;
  const std::vector<BoxTree::Node>& nodes = tree_.nodes();
  if (!nodes.empty()) pending[count++] = {0, to_box_sq(nodes[0].box)};
  while (count > 0) {
    auto [id, box_sq] = pending[--count];
    while (box_sq < best_sq) {
      const BoxTree::Node& node = nodes[id];
      if (node.count > 0) {
        for (std::uint32_t s = node.first; s < node.first + node.count; ++s) {
          const double d_sq = to_triangle_sq(p, triangles_[s]);
          if (d_sq < best_sq) {
            best_sq = d_sq;
            slot = s;
          }
        }
        break;
      }
      Pending near{id + 1, to_box_sq(nodes[id + 1].box)};
      Pending far{node.first, to_box_sq(nodes[node.first].box)};
      if (far.distance_sq < near.distance_sq) std::swap(near, far);
      if (far.distance_sq < best_sq) pending[count++] = far;
      id = near.node;
      box_sq = near.distance_sq;
    }
  }
}

Triangle TriangleSurface::triangle(std::uint32_t index) const {
  const Triangle& t = triangles_[slot_of_[index]];
  return {t[0] + origin_, t[1] + origin_, t[2] + origin_};
}

double TriangleSurface::distance_sq(const Point& at, std::uint32_t* nearest) const {
  const Point p = at - origin_;
  double best_sq = kInfinity;
  std::uint32_t slot = nearest != nullptr && *nearest < slot_of_.size() ? slot_of_[*nearest] : kNone;
  if (slot != kNone) best_sq = to_triangle_sq(p, triangles_[slot]);
  search(p, best_sq, slot);
  if (nearest != nullptr && slot != kNone) *nearest = tree_.order()[slot];
  return best_sq;
}

/// One triangle and the pieces that it has been cut into, the one with the greatest bound on top of a heap.
class TriangleSurface::Subdivision {
public:
  Subdivision(const TriangleSurface& surface, const Triangle& triangle, double relative, double floor)
      : surface_(surface), whole_(triangle), factor_sq_((1 + relative) * (1 + relative)) {
    const double least = std::max(floor, kRounding * std::max(surface.extent_, largest_coordinate(triangle)));
    floor_sq_ = least * least;
  }

  [[nodiscard]] DistanceBounds run(std::size_t most_cuts) {
    std::uint32_t over_center = kNone;
    (void)look(centroid(whole_), over_center);
    const double upper_sq = greatest_sq(whole_, surface_.triangles_[over_center]);
    if (upper_sq <= enough_sq()) return bounds(upper_sq);
    Piece piece;
    std::uint32_t hint = over_center;
    for (std::size_t i = 0; i < 3; ++i) {
      piece.nearest[i] = hint;
      (void)look(whole_[i], piece.nearest[i]);
      hint = piece.nearest[i];
    }
    piece.corner = whole_;
    piece.settler = over_center;
    piece.upper_sq = upper_sq;
    push(piece);
    for (std::size_t cuts = 0; !pieces_.empty() && cuts < most_cuts; ++cuts) {
      std::pop_heap(pieces_.begin(), pieces_.end(), is_nearer);
      piece = pieces_.back();
      pieces_.pop_back();
      if (piece.upper_sq <= enough_sq()) return bounds(piece.upper_sq);
      refine(piece);
    }
    return bounds(pieces_.empty() ? 0 : pieces_.front().upper_sq);
  }

private:
  struct Piece {
    Triangle corner;
    std::array<std::uint32_t, 3> nearest; ///< by corner: the slot of a nearest triangle
    std::uint32_t settler;                ///< the slot of the triangle that gave the bound
    double upper_sq;
  };
  static bool is_nearer(const Piece& s, const Piece& t) { return s.upper_sq < t.upper_sq; }

  [[nodiscard]] double enough_sq() const { return std::max(lower_sq_ * factor_sq_, floor_sq_); }

  [[nodiscard]] DistanceBounds bounds(double open_upper_sq) const {
    const double upper_sq = std::max({open_upper_sq, settled_sq_, lower_sq_});
    return {std::sqrt(lower_sq_), std::sqrt(upper_sq)};
  }

  /// The distance at a point of the triangle, seeded with and leaving the slot of a nearest triangle.
  double look(const Point& p, std::uint32_t& slot) {
    double d_sq = slot == kNone ? kInfinity : to_triangle_sq(p, surface_.triangles_[slot]);
    surface_.search(p, d_sq, slot);
    lower_sq_ = std::max(lower_sq_, d_sq);
    return d_sq;
  }

  /// Lowers the bound of a piece to what `slot` says.
  void try_settler(Piece& piece, std::uint32_t slot) const {
    const double upper_sq = greatest_sq(piece.corner, surface_.triangles_[slot]);
    if (upper_sq >= piece.upper_sq) return;
    piece.upper_sq = upper_sq;
    piece.settler = slot;
  }

  /// Settles the piece or keeps it for later.
  void push(Piece& piece) {
    for (std::size_t i = 0; i < 3 && piece.upper_sq > enough_sq(); ++i)
      if (piece.nearest[i] != piece.settler) try_settler(piece, piece.nearest[i]);
    if (piece.upper_sq <= enough_sq()) {
      settled_sq_ = std::max(settled_sq_, piece.upper_sq);
      return;
    }
    pieces_.push_back(piece);
    std::push_heap(pieces_.begin(), pieces_.end(), is_nearer);
  }

  void refine(Piece& piece) {
    std::uint32_t over_center = piece.settler;
    (void)look(centroid(piece.corner), over_center);
    if (over_center != piece.settler) try_settler(piece, over_center);
    if (piece.upper_sq <= enough_sq()) {
      settled_sq_ = std::max(settled_sq_, piece.upper_sq);
      return;
    }
    if (!cut_along(piece, over_center)) bisect(piece);
  }

  void bisect(const Piece& piece) {
    std::size_t longest = 0;
    double longest_sq = -1;
    for (std::size_t i = 0; i < 3; ++i) {
      const double edge_sq = length_sq(piece.corner[(i + 1) % 3] - piece.corner[i]);
      if (edge_sq > longest_sq) {
        longest_sq = edge_sq;
        longest = i;
      }
    }
    const std::size_t next = (longest + 1) % 3;
    const Point middle = 0.5 * (piece.corner[longest] + piece.corner[next]);
    std::uint32_t nearest = piece.nearest[longest];
    (void)look(middle, nearest);
    for (const std::size_t replaced : {longest, next}) {
      Piece half = piece;
      half.corner[replaced] = middle;
      half.nearest[replaced] = nearest;
      half.upper_sq = greatest_sq(half.corner, surface_.triangles_[half.settler]);
      push(half);
    }
  }

  /// Cuts the piece along the planes through the edges of a surface triangle, upright on it, when the part over the
  /// triangle is settled by it and large enough to be worth it, and what is left is less than the piece; else false.
  bool cut_along(const Piece& piece, std::uint32_t slot) {
    const Triangle& over = surface_.triangles_[slot];
    const Vec3 normal = cross(over[1] - over[0], over[2] - over[0]);
    FlatPolygon whole, rest;
    for (const Point& p : piece.corner)
      whole.add(p);
    FlatPolygon inside = whole;
    std::array<FlatPolygon, 3> outside;
    // Cut a little outside the edges: else neighbouring triangles would leave slivers between them.
    const double offset = kOverhang * std::sqrt(enough_sq());
    for (std::size_t i = 0; i < 3; ++i) {
      split(inside, over[i], cross(over[(i + 1) % 3] - over[i], normal), offset, rest, outside[i]);
      inside = rest;
    }
    if (!is_worth_cutting(inside, whole)) return false;
    if (std::any_of(outside.begin(), outside.end(), [&](const FlatPolygon& part) { return is_most_of(part, whole); }))
      return false;
    const double inside_sq = greatest_sq(inside.corners(), over);
    if (inside_sq > enough_sq()) return false;
    settled_sq_ = std::max(settled_sq_, inside_sq);
    for (const FlatPolygon& polygon : outside)
      push_fan(polygon, slot);
    return true;
  }

  void push_fan(const FlatPolygon& polygon, std::uint32_t hint) {
    std::array<std::uint32_t, FlatPolygon::kMostCorners> nearest{};
    for (std::size_t i = 0; i < polygon.size; ++i) {
      nearest[i] = hint;
      (void)look(polygon.corner[i], nearest[i]);
    }
    for (std::size_t i = 2; i < polygon.size; ++i) {
      Piece piece{{polygon.corner[0], polygon.corner[i - 1], polygon.corner[i]},
                  {nearest[0], nearest[i - 1], nearest[i]},
                  hint,
                  0};
      piece.upper_sq = greatest_sq(piece.corner, surface_.triangles_[hint]);
      push(piece);
    }
  }

  const TriangleSurface& surface_;
  Triangle whole_;
  double factor_sq_;
  double floor_sq_ = 0;
  double lower_sq_ = 0;
  double settled_sq_ = 0; ///< the greatest bound of the pieces that need no more cutting
  std::vector<Piece> pieces_;
};

DistanceBounds TriangleSurface::farthest(const Triangle& triangle, double relative, double floor,
                                         std::size_t most_cuts) const {
  if (triangles_.empty()) return {kInfinity, kInfinity};
  return Subdivision(*this, less(triangle, origin_), relative, floor).run(most_cuts);
}

DistanceBounds one_sided_hausdorff(std::span<const Triangle> triangles, const TriangleSurface& surface, double relative,
                                   double floor, const ProgressCallback& progress) {
  constexpr std::size_t kBatch = 1 << 10;
  constexpr std::size_t kGrain = 64;
  DistanceBounds whole;
  std::vector<DistanceBounds> found;
  // What lies within the bound that earlier batches reached needs no look; batches are the same on any number of
  // threads, and spread over the surface so that the first one already finds much. It alone looks at all it has, which
  // is long where two sheets are equally near: so batches are small.
  const std::size_t batches = (triangles.size() + kBatch - 1) / kBatch;
  for (std::size_t batch = 0; batch < batches; ++batch) {
    if (progress && !progress({"measuring distances", batch * kBatch, triangles.size()}))
      throw Error(ErrorCode::kCancelled, "cancelled");
    const std::size_t count = (triangles.size() - batch + batches - 1) / batches;
    const double enough = std::max(floor, whole.lower * (1 + relative));
    found.assign(count, {});
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const auto& range) {
      for (std::size_t i = range.begin(); i != range.end(); ++i)
        found[i] = surface.farthest(triangles[batch + i * batches], relative, enough);
    });
    for (const DistanceBounds& bounds : found) {
      whole.lower = std::max(whole.lower, bounds.lower);
      whole.upper = std::max(whole.upper, bounds.upper);
    }
  }
  return whole;
}

} // namespace ptet
