// Pieces of the original boundary: dividing and merging them, and who holds what while a height field is collapsed.
#include "build/boundary_pieces.hpp"
#include "support/brute_force.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <set>

#include <catch2/catch.hpp>

using namespace ptet;
using build::BoundaryPieces;
using build::Part;
using build::PatchDivision;
using build::PatchTriangle;
using build::Vertex;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Corners = std::array<Point, 3>;

Part part(const std::vector<Part::Corner>& corners) {
  Part made;
  made.count = static_cast<std::uint32_t>(corners.size());
  std::copy(corners.begin(), corners.end(), made.corner.begin());
  return made;
}

Point at(const Corners& base, const Part::Corner& c) {
  Point p{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    p[axis] = (1 - c[0] - c[1]) * base[0][axis] + c[0] * base[1][axis] + c[1] * base[2][axis];
  return p;
}

struct Divided {
  double error;
  std::vector<PatchDivision::Placed> placed;
};
Divided divide(const Corners& base, const std::vector<PatchTriangle>& targets, double enough = 0,
               std::size_t most_parts = 100) {
  PatchDivision division(1e-12);
  division.begin(targets);
  std::array<std::uint32_t, 3> rows{};
  for (std::size_t i = 0; i < 3; ++i)
    rows[i] = division.add_point(base[i]);
  Divided divided{};
  divided.error = division.divide(base, Part::whole(), rows, enough, most_parts, divided.placed);
  return divided;
}

double area(const Divided& divided) {
  double sum = 0;
  for (const auto& placed : divided.placed)
    sum += placed.part.area();
  return sum;
}

/// A height field over a square of n x n quads, its boundary fixed, collapsed by hand.
class HeightField {
public:
  HeightField(int n, double height, unsigned seed) : random_(seed), n_(n) {
    std::uniform_real_distribution<double> z(0, 1);
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x)
        points_.push_back(
            {x + 0.3 * z(random_) * (x % n != 0), y + 0.3 * z(random_) * (y % n != 0), height * z(random_)});
    const auto id = [&](int x, int y) { return static_cast<Vertex>(y * (n + 1) + x); };
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        original_.push_back({id(x, y), id(x + 1, y), id(x + 1, y + 1)});
        original_.push_back({id(x, y), id(x + 1, y + 1), id(x, y + 1)});
      }
    pieces_.emplace(points_, original_, 1.5 * n);
    division_.emplace(*pieces_);
    for (std::uint32_t f = 0; f < original_.size(); ++f) {
      pieces_->add(f, original_[f]);
      faces_[f] = original_[f];
    }
  }

  /// Tries to remove every inner vertex; returns the largest bound.
  double collapse_all() {
    double worst = 0;
    for (Vertex v = 0; v < points_.size(); ++v) {
      const auto x = static_cast<int>(v) % (n_ + 1), y = static_cast<int>(v) / (n_ + 1);
      if (x == 0 || y == 0 || x == n_ || y == n_) continue;
      std::vector<Vertex> around = neighbours(v);
      std::shuffle(around.begin(), around.end(), random_);
      for (const Vertex to : around)
        if (collapse(v, to, worst)) break;
    }
    return worst;
  }
  [[nodiscard]] std::size_t face_count() const { return faces_.size(); }

  /// By original triangle, in units of (u, v): how much of it is held.
  [[nodiscard]] std::map<std::array<Vertex, 3>, double> areas_held() const {
    std::map<std::array<Vertex, 3>, double> sum;
    for (const auto& [f, v] : faces_)
      for (const auto& held : pieces_->held(f))
        sum[held.triangle] += held.part.area();
    return sum;
  }
  [[nodiscard]] std::size_t pieces_held() const {
    std::size_t count = 0;
    for (const auto& [f, v] : faces_)
      count += pieces_->held(f).size();
    return count;
  }
  [[nodiscard]] std::size_t original_count() const { return original_.size(); }
  /// Largest distance of a corner of what a face holds to that face.
  [[nodiscard]] double farthest_held() const {
    double worst = 0;
    for (const auto& [f, v] : faces_)
      for (const auto& held : pieces_->held(f)) {
        const Corners base = corners(held.triangle);
        for (std::size_t i = 0; i < held.part.count; ++i)
          worst = std::max(worst, test::nearest_on_triangle(at(base, held.part.corner[i]), corners(v)).distance);
      }
    return worst;
  }

private:
  [[nodiscard]] Corners corners(const std::array<Vertex, 3>& t) const {
    return {points_[t[0]], points_[t[1]], points_[t[2]]};
  }
  [[nodiscard]] PatchTriangle patch(const std::array<Vertex, 3>& t) const { return {t, corners(t), 0}; }
  [[nodiscard]] std::vector<Vertex> neighbours(Vertex v) const {
    std::set<Vertex> found;
    for (const auto& [f, t] : faces_)
      if (std::find(t.begin(), t.end(), v) != t.end()) found.insert(t.begin(), t.end());
    found.erase(v);
    return {found.begin(), found.end()};
  }
  bool collapse(Vertex vs, Vertex vd, double& worst) {
    std::vector<std::uint32_t> fine, coarse;
    std::vector<PatchTriangle> fine_triangles, coarse_triangles;
    for (const auto& [f, t] : faces_) {
      if (std::find(t.begin(), t.end(), vs) == t.end()) continue;
      fine.push_back(f);
      fine_triangles.push_back(patch(t));
      if (std::find(t.begin(), t.end(), vd) != t.end()) continue;
      auto moved = t;
      std::replace(moved.begin(), moved.end(), vs, vd);
      const Corners c = corners(moved);
      const double turn = (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[1][1] - c[0][1]) * (c[2][0] - c[0][0]);
      if (turn < 0.1) return false; // slivers make much of rounding
      coarse.push_back(f);
      coarse_triangles.push_back(patch(moved));
    }
    const double least = division_->at_least(fine, coarse_triangles, kInfinity);
    const double bound = division_->hand_over(fine, fine_triangles, coarse_triangles, kInfinity);
    CHECK(least <= bound);
    CHECK(least >= division_->at_least(fine, coarse_triangles, least / 2));
    worst = std::max(worst, bound);
    pieces_->commit(fine, coarse, division_->handover());
    for (const std::uint32_t f : fine)
      faces_.erase(f);
    for (std::size_t i = 0; i < coarse.size(); ++i)
      faces_[coarse[i]] = coarse_triangles[i].v;
    return true;
  }

  std::mt19937 random_;
  int n_;
  std::vector<Point> points_;
  std::vector<std::array<Vertex, 3>> original_;
  std::map<std::uint32_t, std::array<Vertex, 3>> faces_;
  std::optional<BoundaryPieces> pieces_;
  std::optional<BoundaryPieces::Division> division_;
};

} // namespace

TEST_CASE("pieces: parts with a convex union are merged, no others", "[build][pieces]") {
  // The corner at (0, 1) cut off, and the rest in two.
  std::vector<Part> parts = {part({{0, 0.5}, {0.5, 0.5}, {0, 1}}), part({{0, 0}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}}),
                             part({{0.5, 0}, {1, 0}, {0.5, 0.5}})};
  std::vector<Part> all = parts;
  build::merge_parts(all);
  REQUIRE(all.size() == 1);
  CHECK(all[0].is_whole());
  // The two small triangles only touch.
  std::vector<Part> apart = {parts[0], parts[2]};
  build::merge_parts(apart);
  CHECK(apart.size() == 2);
  // The union of the first two is convex, whichever comes first.
  std::vector<Part> two = {parts[1], parts[0]};
  build::merge_parts(two);
  REQUIRE(two.size() == 1);
  CHECK(two[0].count == 4);
  CHECK(two[0].area() == Approx(0.375));
  // An L.
  std::vector<Part> l = {part({{0, 0}, {0.5, 0}, {0.5, 0.2}, {0, 0.2}}),
                         part({{0, 0.2}, {0.2, 0.2}, {0.2, 0.5}, {0, 0.5}})};
  build::merge_parts(l);
  CHECK(l.size() == 2);
}

TEST_CASE("pieces: a flat patch takes a flat piece exactly", "[build][pieces]") {
  // Four triangles around a vertex, and a triangle across all of them.
  const std::vector<Point> p = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {-2, 0, 0}, {0, -2, 0}};
  std::vector<PatchTriangle> targets;
  for (const auto& t : std::vector<std::array<Vertex, 3>>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}})
    targets.push_back({t, {p[t[0]], p[t[1]], p[t[2]]}, 0});
  const Corners base = {Point{-0.7, -0.4, 0}, Point{0.9, -0.3, 0}, Point{0.1, 0.8, 0}};
  const Divided divided = divide(base, targets);
  CHECK(divided.error < 1e-12);
  CHECK(area(divided) == Approx(0.5));
  std::set<std::uint32_t> used;
  for (const auto& placed : divided.placed) {
    used.insert(placed.target);
    for (std::size_t i = 0; i < placed.part.count; ++i)
      CHECK(test::nearest_on_triangle(at(base, placed.part.corner[i]), targets[placed.target].x).distance < 1e-12);
  }
  CHECK(used.size() == 4);
  // Not cut where that is not needed, or not allowed: then the least largest distance to a single target.
  CHECK(divide(base, targets, 2).placed.size() == 1);
  const Divided uncut = divide(base, targets, 0, 1);
  REQUIRE(uncut.placed.size() == 1);
  CHECK(uncut.error == Approx(0.8)); // from one of the two at the bottom to the tip
}

TEST_CASE("pieces: what is added to the distance to a target counts", "[build][pieces]") {
  const Corners base = {Point{0, 0, 0}, Point{1, 0, 0}, Point{0, 1, 0}};
  std::vector<PatchTriangle> targets = {{{0, 1, 2}, base, 0.5}};
  CHECK(divide(base, targets).error == Approx(0.5));
  // 0.2 above, with nothing added: better.
  targets.push_back({{3, 4, 5}, {Point{0, 0, 0.2}, Point{1, 0, 0.2}, Point{0, 1, 0.2}}, 0});
  const Divided divided = divide(base, targets);
  CHECK(divided.error == Approx(0.2));
  CHECK(divided.placed.at(0).target == 1);
}

TEST_CASE("pieces: any division covers, and the error found is that of the parts", "[build][pieces]") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto point = [&] { return Point{unit(random), unit(random), 0.3 * unit(random)}; };
  for (int i = 0; i < 200; ++i) {
    const Point apex = point();
    std::vector<PatchTriangle> targets;
    std::vector<Point> rim = {point()};
    for (Vertex k = 0; k < 5; ++k) {
      rim.push_back(point());
      targets.push_back({{0, k + 1, k + 2}, {apex, rim[k], rim[k + 1]}, 0});
    }
    const Corners base = {point(), point(), point()};
    const Divided divided = divide(base, targets, 0, 400);
    CHECK(area(divided) == Approx(0.5));
    double worst = 0;
    for (const auto& placed : divided.placed)
      for (std::size_t c = 0; c < placed.part.count; ++c)
        worst = std::max(worst,
                         test::nearest_on_triangle(at(base, placed.part.corner[c]), targets[placed.target].x).distance);
    CHECK(divided.error == Approx(worst));
    double sampled = 0;
    for (int u = 0; u <= 30; ++u)
      for (int v = 0; v <= 30 - u; ++v) {
        double nearest = kInfinity;
        for (const PatchTriangle& t : targets)
          nearest = std::min(nearest, test::nearest_on_triangle(at(base, {u / 30.0, v / 30.0}), t.x).distance);
        sampled = std::max(sampled, nearest);
      }
    CHECK(sampled <= divided.error * (1 + 1e-9));
    CHECK(divided.error <= 1.06 * sampled + 0.01);
  }
}

TEST_CASE("pieces: in a plane all is held at no distance, and merged again", "[build][pieces]") {
  HeightField field(12, 0, 7);
  CHECK(field.collapse_all() == 0);
  CHECK(field.face_count() < field.original_count() / 2);
  CHECK(field.farthest_held() < 1e-11);
  for (const auto& [triangle, held] : field.areas_held())
    CHECK(held == Approx(0.5));
  CHECK(field.areas_held().size() == field.original_count());
  // A triangle is cut by few edges: were parts not merged, there would be many more.
  CHECK(field.pieces_held() < 3 * field.original_count());
}

TEST_CASE("pieces: all of a height field is held all the time", "[build][pieces]") {
  HeightField field(10, 0.8, 8);
  const double bound = field.collapse_all();
  CHECK(field.face_count() < field.original_count() / 2);
  CHECK(field.farthest_held() <= bound);
  CHECK(field.areas_held().size() == field.original_count());
  for (const auto& [triangle, held] : field.areas_held())
    CHECK(held >= 0.5 - 1e-9);
}
