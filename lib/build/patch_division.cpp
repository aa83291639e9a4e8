#include "build/patch_division.hpp"

#include "mesh/closest_point.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ptet::build {
using namespace vec;
namespace {

/// A bound so much above the lower one is as good.
constexpr double kTight = 1.03;
/// Of the base triangle's size: parts that differ by less are the same.
constexpr double kSame = 1e-13;
/// Of the distance that is rounding: corners so near to a cut lie on it, and parts so near to a target are not cut.
/// What a target is given beyond its edges grows behind sharp corners and from one division to the next, so these are
/// small.
constexpr double kOnPlane = 0.001;
constexpr double kNothing = 0.01;
/// Of sums of areas, in units of (u, v).
constexpr double kAreaRounding = 1e-16;

using Corner = Part::Corner;

double turn(const Corner& a, const Corner& b, const Corner& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}
double length(const Corner& a, const Corner& b) {
  return std::hypot(b[0] - a[0], b[1] - a[1]);
}

/// The convex hull of both, if it holds hardly more than they do.
bool convex_union(const Part& a, const Part& b, Part& both) {
  std::array<Corner, 2 * kMaxPartCorners> points;
  auto end = std::copy_n(a.corner.begin(), a.count, points.begin());
  end = std::copy_n(b.corner.begin(), b.count, end);
  std::sort(points.begin(), end);
  const auto count = static_cast<std::size_t>(end - points.begin());
  // Andrew's monotone chain, without corners that hardly stand out.
  std::array<Corner, 2 * kMaxPartCorners + 2> hull;
  std::size_t size = 0;
  const auto add = [&](const Corner& p, std::size_t least) {
    while (size >= least && turn(hull[size - 2], hull[size - 1], p) <= kSame * length(hull[size - 2], p))
      --size;
    hull[size++] = p;
  };
  for (std::size_t i = 0; i < count; ++i)
    add(points[i], 2);
  const std::size_t upper = size + 1;
  for (std::size_t i = count - 1; i-- > 0;)
    add(points[i], upper);
  --size;
  if (size < 3 || size > kMaxPartCorners) return false;
  both.count = static_cast<std::uint32_t>(size);
  std::copy_n(hull.begin(), size, both.corner.begin());
  // Where the hull goes from one to the other it may leave both by twice the area too much over the length.
  const auto has = [](const Part& part, const Corner& p) {
    const auto last = part.corner.begin() + part.count;
    return std::find(part.corner.begin(), last, p) != last;
  };
  double shortest = 1;
  for (std::size_t i = 0; i < size; ++i) {
    const Corner& from = hull[i];
    const Corner& to = hull[(i + 1) % size];
    if ((has(a, from) && has(a, to)) || (has(b, from) && has(b, to))) continue;
    shortest = std::min(shortest, std::max(kSame, length(from, to)));
  }
  return both.area() <= a.area() + b.area() + 0.5 * kSame * shortest + kAreaRounding;
}

Vec3 unit(const Vec3& a) {
  const double n = norm(a);
  return n > 0 ? (1 / n) * a : a;
}
Vec3 normal_of(const PatchTriangle& t) {
  return unit(cross(t.x[1] - t.x[0], t.x[2] - t.x[0]));
}

} // namespace

bool Part::is_whole() const {
  return count == 3 && corner[0] == Corner{0, 0} && corner[1] == Corner{1, 0} && corner[2] == Corner{0, 1};
}

double Part::area() const {
  double twice = 0;
  for (std::size_t i = 2; i < count; ++i)
    twice += turn(corner[0], corner[i - 1], corner[i]);
  return twice / 2;
}

void merge_parts(std::vector<Part>& parts) {
  Part both;
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t j = 0; j < parts.size(); ++j)
      if (i != j && convex_union(parts[i], parts[j], both)) {
        parts[std::min(i, j)] = both;
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(std::max(i, j)));
        i = std::min(i, j);
        j = static_cast<std::size_t>(-1); // what the larger one can be merged with is to be seen again
      }
}

void PatchDivision::begin(std::span<const PatchTriangle> targets) {
  targets_ = targets;
  distances_.clear();
  nearest_.clear();
  lower_bound_ = 0;
}

std::uint32_t PatchDivision::add_point(const Point& p) {
  double least = std::numeric_limits<double>::infinity();
  std::uint32_t best = 0;
  for (std::uint32_t t = 0; t < targets_.size(); ++t) {
    const PatchTriangle& target = targets_[t];
    const double d =
        std::sqrt(closest_on_triangle(p, target.x[0], target.x[1], target.x[2]).distance_sq) + target.offset;
    distances_.push_back(d);
    if (d < least) {
      least = d;
      best = t;
    }
  }
  lower_bound_ = std::max(lower_bound_, least);
  nearest_.push_back(best);
  return static_cast<std::uint32_t>(nearest_.size() - 1);
}

Point PatchDivision::at(const Corner& c) const {
  return base_[0] + c[0] * (base_[1] - base_[0]) + c[1] * (base_[2] - base_[0]);
}

std::uint32_t PatchDivision::nearest(std::uint32_t row) const {
  return nearest_[row];
}

double PatchDivision::distance(const std::array<Point, 3>& base, const Part& part, std::uint32_t target) const {
  const PatchTriangle& t = targets_[target];
  double worst_sq = 0;
  for (std::size_t i = 0; i < part.count; ++i) {
    const Corner& c = part.corner[i];
    const Point p = base[0] + c[0] * (base[1] - base[0]) + c[1] * (base[2] - base[0]);
    worst_sq = std::max(worst_sq, closest_on_triangle(p, t.x[0], t.x[1], t.x[2]).distance_sq);
  }
  return std::sqrt(worst_sq) + t.offset;
}

double PatchDivision::divide(const std::array<Point, 3>& base, const Part& part, std::span<const std::uint32_t> rows,
                             double enough, std::size_t most_parts, std::vector<Placed>& placed) {
  base_ = base;
  double worst = 0;
  Polygon first{part, {}};
  std::copy_n(rows.begin(), part.count, first.row.begin());
  stack_.assign(1, first);
  std::size_t made = 1;
  while (!stack_.empty()) {
    const Polygon polygon = stack_.back();
    stack_.pop_back();
    // The target with the least largest distance, and the corner where that is.
    double least = std::numeric_limits<double>::infinity();
    std::uint32_t best = 0;
    std::uint32_t worst_corner = 0;
    const auto largest = [&](std::uint32_t t) {
      double most = -1;
      std::uint32_t corner = 0;
      for (std::uint32_t i = 0; i < polygon.part.count && most < least; ++i)
        if (const double d = value(polygon.row[i], t); d > most) {
          most = d;
          corner = i;
        }
      if (most < least) {
        least = most;
        best = t;
        worst_corner = corner;
      }
    };
    // The nearest ones of the corners first: they are likely to cut the search through the others short.
    for (std::uint32_t i = 0; i < polygon.part.count; ++i)
      largest(nearest(polygon.row[i]));
    for (std::uint32_t t = 0; t < targets_.size(); ++t)
      largest(t);
    const std::uint32_t other = nearest(polygon.row[worst_corner]);
    if (least <= std::max({enough, kTight * lower_bound_, kNothing * rounding_}) || made >= most_parts ||
        other == best) {
      placed.push_back({polygon.part, best});
      worst = std::max(worst, least);
      continue;
    }
    Polygon a;
    Polygon b;
    cut(polygon, best, other, worst_corner, a, b);
    stack_.push_back(a);
    stack_.push_back(b);
    ++made;
  }
  return worst;
}

void PatchDivision::cut(const Polygon& whole, std::uint32_t f, std::uint32_t g, std::uint32_t worst, Polygon& a,
                        Polygon& b) {
  if (whole.part.count == kMaxPartCorners) return cut_in_half(whole, a, b);
  const PatchTriangle& from = targets_[f];
  const PatchTriangle& to = targets_[g];
  const Vec3 normal = normal_of(from);
  const Point far = at(whole.part.corner[worst]);
  // The edge of f that lies towards g: the common one, else the one that the far corner is furthest outside of.
  std::size_t edge = 3;
  double most = 0;
  const auto holds = [](const PatchTriangle& t, Vertex v) { return std::find(t.v.begin(), t.v.end(), v) != t.v.end(); };
  Vec3 mean = normal;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (holds(to, from.v[i]) && holds(to, from.v[j])) {
      edge = i;
      mean = normal + normal_of(to);
      break;
    }
    const double outside = dot(far - from.x[i], unit(cross(from.x[j] - from.x[i], normal)));
    if (outside > most) {
      most = outside;
      edge = i;
    }
  }
  if (edge < 3) {
    const Vec3 across = cross(from.x[(edge + 1) % 3] - from.x[edge], mean);
    if (cut_along_plane(whole, from.x[edge], unit(across), a, b)) return;
  }
  Signs nearer{};
  for (std::size_t i = 0; i < whole.part.count; ++i)
    nearer[i] = value(whole.row[i], f) - value(whole.row[i], g);
  if (cut_where_signs_change(whole, nearer, kOnPlane * rounding_, a, b)) return;
  cut_in_half(whole, a, b);
}

bool PatchDivision::cut_along_plane(const Polygon& whole, const Point& origin, const Point& normal, Polygon& a,
                                    Polygon& b) {
  Signs side{};
  for (std::size_t i = 0; i < whole.part.count; ++i)
    side[i] = dot(at(whole.part.corner[i]) - origin, normal);
  return cut_where_signs_change(whole, side, kOnPlane * rounding_, a, b);
}

bool PatchDivision::cut_where_signs_change(const Polygon& whole, const Signs& signs, double tolerance, Polygon& a,
                                           Polygon& b) {
  const std::size_t n = whole.part.count;
  const auto sign = [&](std::size_t i) { return (signs[i] > tolerance ? 1 : 0) - (signs[i] < -tolerance ? 1 : 0); };
  // Both signs, each in one run of corners with at most one zero on each side.
  std::size_t changes = 0;
  int before = 0;
  for (std::size_t i = 0; i < 2 * n; ++i) {
    const int s = sign(i % n);
    if (s == 0) continue;
    if (i >= n && before != 0 && s != before) ++changes;
    before = s;
  }
  if (changes != 2) return false;
  a.part.count = b.part.count = 0;
  const auto add = [](Polygon& to, const Corner& corner, std::uint32_t row) {
    if (to.part.count < kMaxPartCorners) {
      to.part.corner[to.part.count] = corner;
      to.row[to.part.count] = row;
    }
    ++to.part.count;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    const Corner& here = whole.part.corner[i];
    const Corner& next = whole.part.corner[j];
    if (sign(i) >= 0) add(a, here, whole.row[i]);
    if (sign(i) <= 0) add(b, here, whole.row[i]);
    if (sign(i) * sign(j) >= 0) continue;
    const double t = signs[i] / (signs[i] - signs[j]);
    const Corner corner = {here[0] + t * (next[0] - here[0]), here[1] + t * (next[1] - here[1])};
    const std::uint32_t row = add_point(at(corner));
    add(a, corner, row);
    add(b, corner, row);
  }
  const auto proper = [](const Polygon& p) { return p.part.count >= 3 && p.part.count <= kMaxPartCorners; };
  return proper(a) && proper(b);
}

void PatchDivision::cut_in_half(const Polygon& whole, Polygon& a, Polygon& b) {
  const std::size_t n = whole.part.count;
  std::size_t longest = 0;
  double most = -1;
  for (std::size_t i = 0; i < n; ++i) {
    const Point side = at(whole.part.corner[(i + 1) % n]) - at(whole.part.corner[i]);
    if (dot(side, side) > most) {
      most = dot(side, side);
      longest = i;
    }
  }
  const Corner& from = whole.part.corner[longest];
  const Corner& to = whole.part.corner[(longest + 1) % n];
  const Corner middle = {0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])};
  const std::uint32_t row = add_point(at(middle));
  const std::size_t opposite = longest + 1 + (n - 1) / 2;
  const auto fill = [&](Polygon& half, std::size_t first, std::size_t last) {
    half.part.count = 0;
    const auto add = [&](const Corner& corner, std::uint32_t corner_row) {
      half.part.corner[half.part.count] = corner;
      half.row[half.part.count++] = corner_row;
    };
    add(middle, row);
    for (std::size_t i = first; i <= last; ++i)
      add(whole.part.corner[i % n], whole.row[i % n]);
  };
  fill(a, longest + 1, opposite);
  fill(b, opposite, longest + n);
}

} // namespace ptet::build
