// What the browser draws, tools/web/src/surfaces.hpp.
#include "ptet/session.hpp"
#include "support/meshes.hpp"
#include "tools/web/src/surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;
using namespace ptet::web;

namespace {

double determinant(const Point& a, const Point& b, const Point& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

Point less(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// A mesh as a session holds it, an unused slot of each kind in front.
struct Slots {
  explicit Slots(const TetMesh& mesh, const std::function<double(const Point&)>& colour) {
    const std::uint32_t none = Session::kUnused;
    tets.push_back({none, none, none, none});
    faces.push_back({none, none, none});
    points.push_back({1e9, 1e9, 1e9});
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      points.push_back(mesh.position(VertexId{v}));
    for (const Point& point : points)
      colours.push_back(colour(point));
    std::map<std::array<std::uint32_t, 3>, std::vector<std::array<std::uint32_t, 3>>> by_face;
    for (const Tet& tet : mesh.tets) {
      tets.push_back({tet[0].index() + 1, tet[1].index() + 1, tet[2].index() + 1, tet[3].index() + 1});
      const auto& t = tets.back();
      for (const std::array<std::uint32_t, 3>& face : {std::array{t[1], t[2], t[3]}, std::array{t[0], t[3], t[2]},
                                                       std::array{t[0], t[1], t[3]}, std::array{t[0], t[2], t[1]}}) {
        auto key = face;
        std::sort(key.begin(), key.end());
        by_face[key].push_back(face);
      }
    }
    for (const auto& [key, sides] : by_face)
      if (sides.size() == 1) faces.push_back(sides[0]);
  }
  [[nodiscard]] Scene scene() const { return {tets, faces, points, colours}; }
  [[nodiscard]] double volume(std::size_t tet) const {
    const auto& t = tets[tet];
    return determinant(less(points[t[1]], points[t[0]]), less(points[t[2]], points[t[0]]),
                       less(points[t[3]], points[t[0]])) /
           6;
  }

  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<std::array<std::uint32_t, 3>> faces;
  std::vector<Point> points;
  std::vector<double> colours;
};

Point corner(const Triangles& triangles, std::size_t triangle, std::size_t c) {
  const float* p = triangles.positions.data() + 9 * triangle + 3 * c;
  return {p[0], p[1], p[2]};
}

/// Of the space inside, if they close it and all look outwards.
double enclosed(const Triangles& triangles) {
  double volume = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    volume += determinant(corner(triangles, i, 0), corner(triangles, i, 1), corner(triangles, i, 2)) / 6;
  return volume;
}

/// Whether every edge is gone along as often one way as the other.
bool is_closed(const Triangles& triangles) {
  std::map<std::pair<Point, Point>, int> balance;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const Point a = corner(triangles, i, c), b = corner(triangles, i, (c + 1) % 3);
      a < b ? ++balance[{a, b}] : --balance[{b, a}];
    }
  return std::all_of(balance.begin(), balance.end(), [](const auto& edge) { return edge.second == 0; });
}

double area(const Triangles& triangles) {
  double sum = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Point u = less(corner(triangles, i, 1), corner(triangles, i, 0));
    const Point v = less(corner(triangles, i, 2), corner(triangles, i, 0));
    sum += 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  }
  return sum;
}

double linear(const Point& p) {
  return p[0] - 2 * p[1] + 0.5 * p[2];
}

} // namespace

TEST_CASE("web: what a plane leaves of the cells is closed and holds their volume") {
  for (const NamedMesh& sample : sample_meshes(5)) {
    const Slots slots(sample.mesh, linear);
    const Plane plane{{1, 0.3, -0.2}, 20};
    const auto height = heights(slots.points, plane);
    double kept = 0, all = 0;
    for (std::size_t t = 1; t < slots.tets.size(); ++t) {
      all += slots.volume(t);
      const auto& tet = slots.tets[t];
      if (std::any_of(tet.begin(), tet.end(), [&](std::uint32_t v) { return height[v] <= 0; })) kept += slots.volume(t);
    }
    INFO(sample.name);
    REQUIRE(kept > 0);
    REQUIRE(kept < all);
    const Triangles open = surface(slots.scene(), plane, {});
    CHECK(is_closed(open));
    CHECK(enclosed(open) == Approx(kept));
    const Triangles whole = surface(slots.scene(), std::nullopt, {});
    CHECK(whole.size() == slots.faces.size() - 1);
    CHECK(enclosed(whole) == Approx(all));
  }
}

TEST_CASE("web: slices have the area of what they cut, and the field's colours") {
  const Slots slots(grid({{4, 4, 4}, {}, 0, 1}), linear); // 64 wide
  for (const auto& [plane, expected] :
       {std::pair{Plane{{1, 0, 0}, 30}, 64.0 * 64}, std::pair{Plane{{0, 0, -1}, -16}, 64.0 * 64}, // through vertices
        std::pair{Plane{{1, 1, 0}, 70}, 58 * std::sqrt(2.0) * 64}}) {
    const Point origin{1, 2, 3};
    const Triangles slice = contour(slots.scene(), heights(slots.points, plane), 0, origin);
    CHECK(area(slice) == Approx(expected));
    for (std::size_t i = 0; i < slice.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const Point at = less(corner(slice, i, c), {-origin[0], -origin[1], -origin[2]});
        REQUIRE(heights(std::vector{at}, plane)[0] == Approx(0).margin(1e-4));
        REQUIRE(slice.colours[3 * i + c] == Approx(linear(at)).margin(1e-4));
      }
  }
}

TEST_CASE("web: the diagonal of a four-sided piece is no edge") {
  const Slots slots(single_tet(), linear);
  std::vector<double> values(slots.points.size(), 0);
  values[1] = values[2] = 1;
  const Triangles piece = contour(slots.scene(), values, 0.5, {});
  REQUIRE(piece.size() == 2);
  // Along an edge its two ends agree that the third coordinate is 0; along what is none, that it is not.
  std::map<std::pair<Point, Point>, int> hidden;
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t opposite = 0; opposite < 3; ++opposite) {
      const auto coordinate = [&](std::size_t c) { return piece.barycentric[12 * i + 4 * c + opposite]; };
      const std::size_t a = (opposite + 1) % 3, b = (opposite + 2) % 3;
      REQUIRE(coordinate(opposite) == 255);
      REQUIRE(coordinate(a) == coordinate(b));
      if (coordinate(a) == 255) ++hidden[std::minmax(corner(piece, i, a), corner(piece, i, b))];
    }
  REQUIRE(hidden.size() == 1);
  CHECK(hidden.begin()->second == 2);
}
