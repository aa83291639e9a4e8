// The field error of a version, largest and integrated, where both are known by hand.
#include "error/exact_field_error.hpp"
#include "error/original_cells.hpp"
#include "error/star_cones.hpp"
#include "error/version_view.hpp"
#include "mesh/vec3.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::vec;

namespace {

struct Measured {
  double largest = 0;
  double integral = 0;
  double outside = 0; ///< volume
};

/// A mesh with one field, its values given by vertex; asked about versions by their vertices.
class Original {
public:
  Original(const TetMesh& mesh, const std::vector<double>& value)
      : prepared_(prepare(mesh)), new_id_(mesh.vertex_count()) {
    for (std::uint32_t v = 0; v < new_id_.size(); ++v) {
      const VertexId given = prepared_.original_vertex[v];
      new_id_[given.index()] = VertexId{v};
      values_.push_back(value.at(given.index()));
    }
  }

  /// The version is turned round if it is negatively oriented.
  [[nodiscard]] Measured measure(const std::array<std::uint32_t, 4>& version) const {
    const std::array<std::size_t, 1> field_of = {0};
    const ExactFieldError exact(prepared_, {values_, 1, field_of});
    ExactFieldError::Workspace workspace(exact);
    Tet tet{};
    for (std::size_t i = 0; i < 4; ++i)
      tet[i] = new_id_[version[i]];
    const auto at = [&](std::size_t i) { return prepared_.points[tet[i].index()]; };
    if (orientation(at(0), at(1), at(2), at(3)) < 0) std::swap(tet[2], tet[3]);
    Measured measured;
    std::array<double, 2> sums{};
    exact.measure(tet, workspace, {&measured.largest, 1}, sums);
    measured.integral = sums[0];
    measured.outside = sums[1];
    double alone = 0;
    exact.measure(tet, workspace, {&alone, 1});
    // Where original tets overlap, as only a test has them, corners of the parts see more than faces do.
    CHECK(alone <= measured.largest * (1 + 1e-12));
    return measured;
  }

private:
  PreparedMesh prepared_;
  std::vector<VertexId> new_id_;
  std::vector<double> values_;
};

/// Cells of width 16; the field is a function of the cell coordinates.
struct RegularGrid {
  RegularGrid(int size, const std::function<double(double, double, double)>& f)
      : cells(size), mesh(test::grid({{size, size, size}, {}, 0, 1})) {
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
      const Point p = mesh.position(VertexId{v});
      value.push_back(f(p[0] / 16, p[1] / 16, p[2] / 16));
    }
  }
  /// The whole cube as six tets around one of its diagonals: from (0, 0, 0) or, mirrored in x, from (1, 0, 0).
  [[nodiscard]] Measured measure_cube(bool mirrored) const {
    const Original original(mesh, value);
    Measured sum;
    std::array<std::size_t, 3> axes = {0, 1, 2};
    do {
      Point p = {mirrored ? 16.0 * cells : 0, 0, 0};
      std::array<std::uint32_t, 4> tet{vertex_at(p)};
      for (std::size_t step = 0; step < 3; ++step) {
        p[axes[step]] = 16.0 * cells - p[axes[step]];
        tet[step + 1] = vertex_at(p);
      }
      const Measured measured = original.measure(tet);
      sum.largest = std::max(sum.largest, measured.largest);
      sum.integral += measured.integral;
      CHECK(measured.outside == 0); // not by rounding either
    } while (std::next_permutation(axes.begin(), axes.end()));
    return sum;
  }
  [[nodiscard]] std::uint32_t vertex_at(const Point& p) const {
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.position(VertexId{v}) == p) return v;
    FAIL("no vertex there");
    return 0;
  }

  int cells;
  TetMesh mesh;
  std::vector<double> value;
};

constexpr double kCellVolume = 16.0 * 16 * 16;

/// A quadrangle, its centre and an apex on either side: eight tets around the centre.
struct Quadrangle {
  Quadrangle(const Point& center, const Vec3& u, const Vec3& v) {
    const Vec3 up = cross(u, v);
    points = {center + u, center + v, center - u, center - v, center, center + up, center - up};
  }
  /// Of the tet of its corners.
  [[nodiscard]] int orientation_of_diagonals() const { return orientation(points[0], points[1], points[2], points[3]); }
  /// The same as it is computed, for the tet turned the right way.
  [[nodiscard]] double determinant() const {
    return orientation_of_diagonals() * dot(points[1] - points[0], cross(points[2] - points[0], points[3] - points[0]));
  }
  [[nodiscard]] bool is_fair() const { return norm(points[5] - points[6]) > 0.1; }
  [[nodiscard]] TetMesh mesh() const {
    std::vector<std::array<std::uint32_t, 4>> tets;
    for (std::uint32_t i = 0; i < 4; ++i) {
      tets.push_back({i, (i + 1) % 4, 4, 5});
      tets.push_back({(i + 1) % 4, i, 4, 6});
    }
    return test::make_mesh(points, tets, ScalarType::kFloat64);
  }

  std::vector<Point> points;
};

/// Vertex 0 and all the triangles around it: the sides of a cube in size x size squares each, moved to a ball.
struct Hub {
  explicit Hub(int size) : points{{0, 0, 0}} {
    std::map<Point, std::uint32_t> ids;
    const auto id = [&](const Point& on_cube) {
      const auto [it, is_new] = ids.try_emplace(on_cube, static_cast<std::uint32_t>(points.size()));
      const double length = std::hypot(on_cube[0], on_cube[1], on_cube[2]);
      if (is_new) points.push_back({on_cube[0] / length, on_cube[1] / length, on_cube[2] / length});
      return it->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int side : {-size, size})
        for (int i = -size; i < size; i += 2)
          for (int j = -size; j < size; j += 2) {
            const auto at = [&](int di, int dj) {
              Point p{};
              p[axis] = side;
              p[(axis + 1) % 3] = i + di;
              p[(axis + 2) % 3] = j + dj;
              return id(p);
            };
            add({0, at(0, 0), at(2, 0), at(2, 2)});
            add({0, at(0, 0), at(2, 2), at(0, 2)});
          }
  }
  void add(std::array<std::uint32_t, 4> tet) {
    if (orientation(points[tet[0]], points[tet[1]], points[tet[2]], points[tet[3]]) < 0) std::swap(tet[2], tet[3]);
    tets.push_back(tet);
  }
  /// The vertex nearest to a direction.
  [[nodiscard]] std::uint32_t towards(const Point& direction) const {
    const auto along = [&](const Point& p) { return dot(p, direction); };
    const auto it =
        std::max_element(points.begin(), points.end(), [&](auto& a, auto& b) { return along(a) < along(b); });
    return static_cast<std::uint32_t>(it - points.begin());
  }
  [[nodiscard]] StarCones::Triangle opposite(const std::array<std::uint32_t, 4>& tet) const {
    return {points[tet[1]], points[tet[2]], points[tet[3]]};
  }

  std::vector<Point> points;
  std::vector<std::array<std::uint32_t, 4>> tets;
};

} // namespace

TEST_CASE("a linear field has no error in any version") {
  const RegularGrid grid(4, [](double x, double y, double z) { return 3 * x - 2 * y + z / 2 + 7; });
  for (const bool mirrored : {false, true}) {
    const Measured measured = grid.measure_cube(mirrored);
    CHECK(measured.largest <= 1e-13);
    CHECK(measured.integral <= 1e-24 * kCellVolume);
  }
}

TEST_CASE("a square on a regular refinement") {
  // Both fields depend on x alone: the original one joins 0, 1, 4, 9, 16, the coarse one is 4 x. The difference
  // 0, -3, -4, -3, 0 is linear in between, and the square of one that runs from a to b has the integral
  // (a a + a b + b b) / 3: (9 + 37 + 37 + 9) / 3 over each of 16 rows of cells.
  const RegularGrid grid(4, [](double x, double, double) { return x * x; });
  for (const bool mirrored : {false, true}) { // mirrored, the versions cut across the original tets
    const Measured measured = grid.measure_cube(mirrored);
    CHECK(measured.largest == Approx(4).epsilon(1e-13));
    CHECK(measured.integral == Approx(16 * 92.0 / 3 * kCellVolume).epsilon(1e-13));
  }
}

TEST_CASE("a version made of two original tets") {
  // The difference is 1 at the middle of the edge that was cut and falls to 0 at the other corners.
  const TetMesh mesh =
      test::make_mesh({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, {{0, 4, 2, 3}, {4, 1, 2, 3}});
  const Measured measured = Original(mesh, {5, 5, 5, 5, 6}).measure({0, 1, 2, 3});
  CHECK(measured.largest == Approx(1).epsilon(1e-14));
  CHECK(measured.integral == Approx(2.0 / 6 / 10).epsilon(1e-14)); // two tets of 1/6, the square of a hat: V / 10
}

TEST_CASE("a version that sticks out of the domain") {
  // The difference is x on the unit tet; the version's other corners carry small tets that lie outside of it.
  const TetMesh mesh = test::make_mesh({{0, 0, 0},
                                        {1, 0, 0},
                                        {0, 1, 0},
                                        {0, 0, 1}, //
                                        {4, 0, 0},
                                        {5, 0, 0},
                                        {5, 1, 0},
                                        {5, 0, 1}, //
                                        {0, 4, 0},
                                        {0, 5, 0},
                                        {1, 5, 0},
                                        {0, 5, 1}, //
                                        {0, 0, 4},
                                        {0, 0, 5},
                                        {1, 0, 5},
                                        {0, 1, 5}},
                                       {{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 10, 9, 11}, {12, 14, 15, 13}});
  std::vector<double> value(16, 0.0);
  value[1] = 1;
  const Original original(mesh, value);
  const Measured whole = original.measure({0, 4, 8, 12});
  CHECK(whole.largest == Approx(1).epsilon(1e-14));
  CHECK(whole.integral == Approx(1.0 / 60).epsilon(1e-14)); // of x^2 over the unit tet
  // From a corner where there is nothing of the domain.
  const Measured from_outside = original.measure({4, 0, 12, 8});
  CHECK(from_outside.largest == Approx(1).epsilon(1e-14));
  CHECK(from_outside.integral == Approx(1.0 / 60).epsilon(1e-14));
}

TEST_CASE("the integral over a version inside of one original tet") {
  // As above with the sizes exchanged: the version is the unit tet, the original one 4 times as large. Small tets
  // outside of it that touch it bring the corners, so this is no mesh of a domain; all four planes cut the large tet.
  const TetMesh mesh = test::make_mesh({{0, 0, 0},
                                        {4, 0, 0},
                                        {0, 4, 0},
                                        {0, 0, 4}, //
                                        {1, 0, 0},
                                        {1, -1, 0},
                                        {2, -1, 0},
                                        {1, -1, -1}, //
                                        {0, 1, 0},
                                        {-1, 1, 0},
                                        {-1, 2, 0},
                                        {-1, 1, -1}, //
                                        {0, 0, 1},
                                        {0, -1, 1},
                                        {0, -1, 2},
                                        {-1, -1, 1}},
                                       {{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 10, 9, 11}, {12, 14, 13, 15}});
  std::vector<double> value(16, 0.0);
  value[1] = 4;
  const Measured measured = Original(mesh, value).measure({0, 4, 8, 12});
  CHECK(measured.integral == Approx(1.0 / 60).epsilon(1e-14));
}

TEST_CASE("what a flat original tet says lies in no space") {
  // Two tets over the halves of a quadrangle, on either side of its diagonal 0 2, on which the field is 0. Below them,
  // on the boundary, the quadrangle as a flat tet: on its diagonal 1 3 the field is 1.
  std::mt19937_64 random(1);
  const auto near = [&](double x) { return x + static_cast<double>(random() % 100) / 1000; };
  for (int tries = 0; tries < 20; ++tries) {
    const TetMesh mesh = test::make_mesh({{near(1), near(0), 0.1},
                                          {near(0), near(1), 0.1},
                                          {near(-1), near(0), 0.1},
                                          {near(0), near(-1), 0.1},
                                          {near(0), near(0), 0.9}},
                                         {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 2, 1, 3}}, ScalarType::kFloat64);
    const Original original(mesh, {0, 1, 0, 1, 0});
    std::array<std::uint32_t, 4> version = {0, 1, 2, 4};
    do {
      const Measured measured = original.measure(version);
      CHECK(measured.largest == 0);
      CHECK(measured.integral == 0);
    } while (std::next_permutation(version.begin(), version.end()));
  }
}

TEST_CASE("the field on either side of a flat original tet") {
  // The square between an upper pyramid, divided along x, and a lower one, divided along y, with a flat tet in between.
  const std::vector<Point> points = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  TetMesh mesh = test::make_mesh(points, {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 1, 2, 3}, {0, 3, 1, 5}, {1, 3, 2, 5}});
  for (Tet& tet : mesh.tets)
    if (orientation(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3])) < 0)
      std::swap(tet[2], tet[3]);
  // The version is y. So is the field above; below it is 1 - x + z, and 1 more than y at the middle of the square: a
  // hat over the tet between that and the corners 0, 1 and 5, of the volume V = 1 / 6, the square of which has V / 10.
  const Measured quarter = Original(mesh, {0, 1, 0, 1, 0, 0}).measure({4, 0, 1, 5});
  CHECK(quarter.largest == Approx(1).epsilon(1e-14));
  CHECK(quarter.integral == Approx(1.0 / 60).epsilon(1e-14));
}

TEST_CASE("what of a version is outside of the domain") {
  // A tet with a dent: in the place of one face there are three that meet at a point inside.
  const Point inside = {0.5, 0.3, 0.4};
  const TetMesh dented = test::make_mesh({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, inside},
                                         {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 3, 1, 4}}, ScalarType::kFloat64);
  const double of_dent = 8.0 / 6 * (1 - (inside[0] + inside[1] + inside[2]) / 2);
  CHECK(Original(dented, {0, 0, 0, 0, 1}).measure({0, 1, 2, 3}).outside == Approx(of_dent).epsilon(1e-14));
  CHECK(Original(dented, {0, 0, 0, 0, 1}).measure({1, 2, 3, 4}).outside == Approx(of_dent).epsilon(1e-14));
  CHECK(Original(dented, {0, 0, 0, 0, 1}).measure({0, 1, 2, 4}).outside == 0);
  // Two tets on one side of a face: what is covered twice is not less than nothing outside.
  const TetMesh folded = test::make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}},
                                         {{0, 1, 2, 3}, {0, 1, 2, 4}}, ScalarType::kFloat64);
  CHECK(Original(folded, {0, 0, 0, 0, 0}).measure({0, 1, 2, 4}).outside == 0);
}

TEST_CASE("an error is none where rounding makes it, whatever is elsewhere in the mesh or added to the field") {
  // The middle of an edge is taken out of two tets as above: the difference is `own` there. A third tet, which shares
  // one face with the version, goes to a vertex with a fill value.
  const TetMesh mesh = test::make_mesh({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 0.3, 0.1}},
                                       {{0, 4, 2, 3}, {4, 1, 2, 3}, {5, 0, 2, 3}});
  for (const double fill : {0.0, 1e20, -9.96921e36, 1.7e308})
    for (const double unit : {1.0, 1e-20}) {
      INFO("fill " << fill << " unit " << unit);
      const double own = (5 + 1e-3) * unit - 5 * unit;
      const Original original(mesh, {5 * unit, 5 * unit, 5 * unit, 5 * unit, 5 * unit + own, fill});
      for (const std::array<std::uint32_t, 4> version : {std::array<std::uint32_t, 4>{0, 1, 2, 3}, {3, 2, 1, 0}}) {
        const Measured measured = original.measure(version);
        CHECK(measured.largest == Approx(own).epsilon(1e-12));
        CHECK(measured.integral == Approx(own * own * 2.0 / 6 / 10).epsilon(1e-12));
      }
    }
  // A field that is linear but for rounding has no error; one that is off by 1e-12 of its values has.
  const auto with = [&](double off) {
    return Original(mesh, {0.1, 0.7, 0.1, 0.1, 0.4 + off, 0}).measure({0, 1, 2, 3});
  };
  REQUIRE(0.4 - 0.1 != (0.7 - 0.1) / 2); // it is not linear to the last bit
  CHECK(with(0).largest == 0);
  CHECK(with(0).integral == 0);
  CHECK(with(1e-11).largest == Approx(1e-11).epsilon(1e-3));
}

TEST_CASE("a common offset of the values loses none of the error") {
  // Values that are sums without rounding: multiples of 2^-9 on top of 2^40. A grid cell's diagonal as one version's
  // edge.
  const auto field = [](double x, double y, double z) { return x * x / 8 - y * z / 4 + x * y * z / 16; };
  const RegularGrid plain(3, field);
  const RegularGrid high(3, [&](double x, double y, double z) { return 0x1p40 + field(x, y, z); });
  for (const bool mirrored : {false, true}) {
    const Measured expected = plain.measure_cube(mirrored);
    const Measured found = high.measure_cube(mirrored);
    REQUIRE(expected.largest > 0.1);
    CHECK(found.largest == expected.largest);
    CHECK(found.integral == expected.integral);
  }
}

TEST_CASE("what is thin is told by the size of the body that it is of") {
  const TetMesh grid = test::grid({{4, 4, 4}, {}, 3, 1});
  std::vector<Point> points;
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t v = 0; v < grid.vertex_count(); ++v)
    points.push_back(grid.position(VertexId(v)));
  for (const Tet& tet : grid.tets)
    tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
  const auto is_thin = [&](std::size_t tet) {
    const PreparedMesh prepared = prepare(test::make_mesh(points, tets, ScalarType::kFloat64));
    const std::vector<double> values(prepared.used_vertex_count);
    const std::size_t field = 0;
    const OriginalCells original(prepared, {values, 1, {&field, 1}});
    return original.is_thin(static_cast<std::uint32_t>(tet));
  };
  const auto first = static_cast<std::uint32_t>(points.size());
  constexpr double kFar = 1e13;
  for (const Point& p : {Point{kFar, 0, 0}, Point{kFar + 8, 0, 0}, Point{kFar, 8, 0}, Point{kFar, 0, 8}})
    points.push_back(p);
  tets.push_back({first, first + 1, first + 2, first + 3});
  CHECK(!is_thin(0)); // the far one is a body by itself
  tets.back() = {tets[0][0], tets[0][1], tets[0][2], first};
  if (orientation(points[tets.back()[0]], points[tets.back()[1]], points[tets.back()[2]], points[first]) < 0)
    std::swap(tets.back()[0], tets.back()[1]);
  CHECK(is_thin(0));
}

TEST_CASE("a box is beyond a version where one of its planes has every vertex in it on the outer side") {
  const PreparedMesh prepared = prepare(test::grid({{4, 4, 4}, {}, 3, 1}));
  const std::vector<double> values(prepared.used_vertex_count);
  const std::size_t none = 0;
  const OriginalCells original(prepared, {values, 1, {&none, 1}});
  VersionView view(original);
  std::mt19937_64 random(11);
  const auto vertex = [&] { return static_cast<std::uint32_t>(random() % prepared.used_vertex_count); };
  int beyond = 0, told_apart_by_planes_alone = 0;
  for (int tries = 0; tries < 20000; ++tries) {
    Tet version{VertexId{vertex()}, VertexId{vertex()}, VertexId{vertex()}, VertexId{vertex()}};
    const auto at = [&](std::size_t i) { return prepared.points[version[i].index()]; };
    if (orientation(at(0), at(1), at(2), at(3)) < 0) std::swap(version[2], version[3]);
    if (view.begin(version) != VersionView::Shape::kSolid) continue;
    const std::array<std::uint32_t, 3> held{vertex(), vertex(), vertex()};
    const BoundingBox box = box_of<3>({original.point(held[0]), original.point(held[1]), original.point(held[2])});
    unsigned common = 0xF;
    for (const std::uint32_t v : held)
      common &= view.row(view.look_at(v)).strictly_beyond;
    if (!view.is_beyond(box)) continue;
    CHECK(common != 0);
    ++beyond;
    if (box.meets(box_of<4>({at(0), at(1), at(2), at(3)}))) ++told_apart_by_planes_alone;
  }
  CHECK(beyond > 1000);
  CHECK(told_apart_by_planes_alone > 100);
}

TEST_CASE("a version's error does not depend on how its corners are numbered, to the last bit") {
  const PreparedMesh prepared = prepare(test::grid({{3, 3, 3}, {}, 3, 1}));
  std::mt19937_64 random(7);
  std::vector<double> values(prepared.used_vertex_count);
  for (double& value : values)
    value = static_cast<double>(random() % 1000);
  const std::size_t none = 0;
  const ExactFieldError exact(prepared, {values, 1, {&none, 1}});
  ExactFieldError::Workspace workspace(exact);
  for (int tries = 0; tries < 50; ++tries) {
    Tet version{};
    for (VertexId& v : version)
      v = VertexId{static_cast<std::uint32_t>(random() % prepared.used_vertex_count)};
    const auto at = [&](std::size_t i) { return prepared.points[version[i].index()]; };
    std::sort(version.begin(), version.end());
    std::vector<double> found;
    do {
      if (orientation(at(0), at(1), at(2), at(3)) <= 0) continue;
      double error = 0;
      exact.measure(version, workspace, {&error, 1});
      found.push_back(error);
    } while (std::next_permutation(version.begin(), version.end()));
    for (const double error : found)
      CHECK(error == found[0]);
  }
}

TEST_CASE("in versions so flat that a double does not tell their volume errors are true, too") {
  // Two diagonals of a quadrangle that cross in its centre but for rounding; the centre has another value.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  const std::vector<double> value = {0, 0, 0, 0, 1, 0.5, 0.5};
  int untold = 0;
  for (int i = 0; i < 300; ++i) {
    const auto draw = [&] { return Vec3{number(random), number(random), number(random)}; };
    const Quadrangle quadrangle(draw(), draw(), draw());
    if (!quadrangle.is_fair() || quadrangle.orientation_of_diagonals() == 0) continue;
    if (!(quadrangle.determinant() > 0)) ++untold;
    const Measured measured = Original(quadrangle.mesh(), value).measure({0, 1, 2, 3});
    CHECK(measured.largest == Approx(1).epsilon(1e-9));
  }
  CHECK(untold > 10);
  // And where twice the digits do not tell it: a bound, here the greatest difference of values that there are.
  for (const double height : {1e-30, 1e-40, 1e-200}) {
    Quadrangle flattest({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    for (const std::size_t end : {1U, 3U})
      flattest.points[end][2] = height;
    REQUIRE(flattest.orientation_of_diagonals() != 0);
    const Measured measured = Original(flattest.mesh(), value).measure({0, 1, 2, 3});
    CHECK(measured.largest == 1);
    // All of it may be wrong by so much.
    CHECK(measured.integral > 0);
    CHECK(measured.integral >= std::abs(flattest.determinant()) / 6);
  }
}

TEST_CASE("nothing is hidden behind a layer so thin that all of it seems to lie on the version's plane") {
  std::mt19937 random(13);
  const TetMesh grid = test::grid({{4, 4, 4}, {}, 0, 1});
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (const Tet& tet : grid.tets)
    tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
  for (const double gap : {0x1p-20, 0x1p-30, 0x1p-40, 0x1p-50}) {
    INFO("gap " << gap);
    std::vector<Point> points;
    std::vector<double> value;
    for (std::uint32_t v = 0; v < grid.vertex_count(); ++v) {
      const Point p = grid.position(VertexId{v});
      const double z = p[2] < 40 ? p[2] / 16 - 2 : p[2] / 16 - 3 + gap; // the third layer of cells
      points.push_back({p[0] / 16, p[1] / 16, z});
      value.push_back(z > 0 ? 1 : 0);
    }
    const Original original(test::make_mesh(points, tets, ScalarType::kFloat64), value);
    int across = 0;
    while (across < 200) {
      std::array<std::uint32_t, 4> version{};
      for (std::uint32_t& v : version)
        v = static_cast<std::uint32_t>(random() % points.size());
      const auto at = [&](std::size_t i) { return points[version[i]]; };
      const double volume = std::abs(dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0)))) / 6;
      const auto below =
          std::count_if(version.begin(), version.end(), [&](std::uint32_t v) { return points[v][2] <= 0; });
      if (volume < 0.01 || below == 0 || below == 4) continue;
      ++across;
      const Measured measured = original.measure(version);
      CHECK(measured.outside <= 1e-9 * volume); // the domain is a box
      CHECK(measured.largest > 0.4);
    }
  }
}

TEST_CASE("a mesh pressed flat has the errors that it had, however flat it is") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(0, 1);
  const auto jitter = [&] { return (static_cast<double>(random() % 32) - 16) / 64; };
  const TetMesh grid = test::grid({{4, 4, 4}, {}, 0, 1});
  std::map<std::array<double, 2>, std::array<double, 2>> columns; // so that versions have edges that get short alone
  std::vector<Point> points;
  std::vector<double> value, nearly_linear, all_but_linear;
  for (std::uint32_t v = 0; v < grid.vertex_count(); ++v) {
    const Point p = grid.position(VertexId{v});
    auto& [x, y] = columns.try_emplace({p[0], p[1]}, std::array{jitter(), jitter()}).first->second;
    points.push_back({p[0] / 16 + x, p[1] / 16 + y, p[2] / 16});
    value.push_back(any(random));
    nearly_linear.push_back(points.back()[0] / 8 + 1e-5 * any(random));
    all_but_linear.push_back(points.back()[0] / 8 + 1e-9 * any(random));
  }
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (const Tet& tet : grid.tets)
    tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
  const auto pressed = [&](double by, const std::vector<double>& field) {
    std::vector<Point> flat = points;
    for (Point& p : flat)
      p[2] = p[0] + p[2] * by; // aslant, and no digit is lost
    return Original(test::make_mesh(flat, tets, ScalarType::kFloat64), field);
  };
  std::vector<std::array<std::uint32_t, 4>> versions;
  while (versions.size() < 400) {
    std::array<std::uint32_t, 4> version{};
    for (std::uint32_t& v : version)
      v = static_cast<std::uint32_t>(random() % points.size());
    if (orientation(points[version[0]], points[version[1]], points[version[2]], points[version[3]]) > 0)
      versions.push_back(version);
  }
  for (const auto& [field, digits] :
       {std::pair(value, 1e-9), std::pair(nearly_linear, 1e-8), std::pair(all_but_linear, 1e-3)}) {
    const Original thick = pressed(1, field);
    for (const double by : {0x1p-10, 0x1p-18, 0x1p-20, 0x1p-30, 0x1p-40}) {
      INFO("pressed by " << by << ", to " << digits);
      const Original thin = pressed(by, field);
      for (const auto& version : versions) {
        const Measured expected = thick.measure(version), found = thin.measure(version);
        CHECK(found.largest == Approx(expected.largest).epsilon(digits));
        CHECK(found.integral == Approx(expected.integral * by).epsilon(digits));
      }
    }
  }
}

TEST_CASE("a flat version's error does not depend on how original tets are numbered, to the last bit") {
  // A grid turned and jittered by rounding and little more: many fours of vertices are flat but for that.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> jitter(-1e-9, 1e-9), any(0, 1);
  const TetMesh grid = test::grid({{3, 3, 3}, {}, 0, 1});
  std::vector<Point> points;
  std::vector<double> value;
  for (std::uint32_t v = 0; v < grid.vertex_count(); ++v) {
    const Point p = grid.position(VertexId{v});
    points.push_back({(0.8 * p[0] - 0.6 * p[1]) / 48 + jitter(random), (0.6 * p[0] + 0.8 * p[1]) / 48 + jitter(random),
                      p[2] / 48 + jitter(random)});
    value.push_back(any(random));
  }
  std::vector<std::array<std::uint32_t, 4>> tets, turned;
  for (const Tet& tet : grid.tets) {
    tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
    turned.push_back({tet[3].index(), tet[1].index(), tet[0].index(), tet[2].index()});
  }
  std::reverse(turned.begin(), turned.end());
  const Original one(test::make_mesh(points, tets, ScalarType::kFloat64), value);
  const Original other(test::make_mesh(points, turned, ScalarType::kFloat64), value);
  int flat = 0;
  while (flat < 200) {
    std::array<std::uint32_t, 4> version{};
    for (std::uint32_t& v : version)
      v = static_cast<std::uint32_t>(random() % points.size());
    const auto at = [&](std::size_t i) { return points[version[i]]; };
    const double volume = dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0)));
    if (!(std::abs(volume) < 1e-8) || !(std::abs(volume) > 1e-12)) continue;
    ++flat;
    CHECK(one.measure(version).largest == other.measure(version).largest);
  }
}

TEST_CASE("what cannot be computed is infinite") {
  const TetMesh mesh =
      test::make_mesh({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, {{0, 4, 2, 3}, {4, 1, 2, 3}});
  const Measured measured = Original(mesh, {1.7e308, -1.7e308, 5, 5, 6}).measure({0, 1, 2, 3});
  CHECK(std::isinf(measured.largest));
}

TEST_CASE("across a crack the field is not looked at") {
  // Two blocks that meet at points of their own; over the second one the field is 100 larger.
  const TetMesh block = test::grid({{3, 3, 3}, {}, 0, 1});
  const auto count = static_cast<std::uint32_t>(block.vertex_count());
  std::vector<Point> points;
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<double> value;
  std::mt19937_64 random(2);
  for (std::uint32_t half = 0; half < 2; ++half) {
    for (std::uint32_t v = 0; v < count; ++v) {
      const Point p = block.position(VertexId{v});
      points.push_back({p[0] + 48 * half, p[1], p[2]});
      value.push_back(100 * half + static_cast<double>(random() % 1000) / 1000);
    }
    for (const Tet& tet : block.tets)
      tets.push_back({tet[0].index() + count * half, tet[1].index() + count * half, tet[2].index() + count * half,
                      tet[3].index() + count * half});
  }
  const Original original(test::make_mesh(points, tets), value);
  int with_errors = 0;
  for (int tries = 0; tries < 1000; ++tries) {
    std::array<std::uint32_t, 4> version{};
    for (std::uint32_t& v : version)
      v = static_cast<std::uint32_t>(random() % count);
    const double largest = original.measure(version).largest;
    CHECK(largest <= 1);
    with_errors += largest > 0.01 ? 1 : 0;
  }
  CHECK(with_errors > 500);
}

TEST_CASE("behind flat original tets there may be others") {
  // Three layers, the middle one flat; above it the field is 1, below it 0.
  const TetMesh grid = test::grid({{3, 3, 3}, {}, 0, 1});
  std::vector<Point> points;
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<double> value;
  const auto vertex_at = [&](const Point& p) {
    std::uint32_t v = 0;
    while (grid.position(VertexId{v}) != p)
      ++v;
    return v;
  };
  for (std::uint32_t v = 0; v < grid.vertex_count(); ++v) {
    const Point p = grid.position(VertexId{v});
    points.push_back({p[0], p[1], p[2] > 16 ? p[2] - 16 : p[2]});
    value.push_back(p[2] > 16 ? 1 : 0);
  }
  for (const Tet& tet : grid.tets)
    tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
  // A tet above whose first corner is that of the layer below: all around it there the error is 1 less the distance.
  const std::array<std::uint32_t, 4> version = {vertex_at({16, 16, 16}), vertex_at({32, 16, 32}),
                                                vertex_at({16, 32, 32}), vertex_at({16, 16, 48})};
  const Original original(test::make_mesh(points, tets), value);
  const Measured measured = original.measure(version);
  CHECK(measured.largest == Approx(1).epsilon(1e-14));
  CHECK(measured.integral == Approx(kCellVolume / 6 / 10).epsilon(1e-14)); // of the square of a hat: V / 10

  // Above there is no error, whatever the flat ones have that only touch.
  std::vector<std::uint32_t> above;
  for (std::uint32_t v = 0; v < grid.vertex_count(); ++v)
    if (value[v] == 1) above.push_back(v);
  std::mt19937_64 random(3);
  for (int tries = 0; tries < 1000; ++tries) {
    std::array<std::uint32_t, 4> other{};
    for (std::uint32_t& v : other)
      v = above[random() % above.size()];
    CHECK(original.measure(other).largest <= 1e-13);
  }
}

TEST_CASE("behind flat original tets there may be all of a version") {
  // The corners of a version stand twice: a second vertex in the same place has a tet that leaves it in another
  // direction, and the flat ones around that. From there on the version is in tets of the first ones.
  const RegularGrid grid(5, [](double x, double y, double z) { return x * x - y * z + std::sin(3 * x + 2 * y + z); });
  std::vector<Point> points;
  for (std::uint32_t v = 0; v < grid.mesh.vertex_count(); ++v)
    points.push_back(grid.mesh.position(VertexId{v}));
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (const Tet& tet : grid.mesh.tets)
    tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
  std::vector<double> value = grid.value;
  const std::array<std::uint32_t, 4> corners = {grid.vertex_at({16, 16, 16}), grid.vertex_at({64, 16, 16}),
                                                grid.vertex_at({16, 64, 16}), grid.vertex_at({16, 16, 64})};
  const Measured single = Original(grid.mesh, value).measure(corners);
  REQUIRE(single.largest > 0.5);
  const Point inside = {28, 28, 28};
  std::array<std::uint32_t, 4> doubled{};
  for (std::size_t k = 0; k < 4; ++k) {
    const std::uint32_t first = corners[k];
    const auto second = doubled[k] = static_cast<std::uint32_t>(points.size());
    points.push_back(points[first]);
    value.push_back(value[first]);
    const auto away = [&](const std::array<std::uint32_t, 4>& tet) {
      if (std::find(tet.begin(), tet.end(), first) == tet.end()) return -1.0;
      double least = 1; // of the edges from the corner: the cosine of the angle to the way out
      for (const std::uint32_t v : tet) {
        const Vec3 edge = points[v] - points[first], out = points[first] - inside;
        if (v != first) least = std::min(least, dot(edge, out) / (norm(edge) * norm(out)));
      }
      return least;
    };
    const auto leaves =
        std::max_element(tets.begin(), tets.end(), [&](const auto& a, const auto& b) { return away(a) < away(b); });
    std::array<std::uint32_t, 4> tet = *leaves;
    std::replace(leaves->begin(), leaves->end(), first, second);
    std::partition(tet.begin(), tet.end(), [&](std::uint32_t v) { return v == first; });
    for (std::size_t i = 1; i < 4; ++i)
      tets.push_back({first, second, tet[i], tet[i % 3 + 1]});
  }
  const Measured measured = Original(test::make_mesh(points, tets), value).measure(doubled);
  CHECK(measured.outside == 0);
  CHECK(measured.largest == Approx(single.largest).epsilon(1e-14));
  CHECK(measured.integral == Approx(single.integral).epsilon(1e-13));
}

TEST_CASE("errors and integrals of many fields are those of each channel by itself") {
  const PreparedMesh prepared = prepare(test::grid({{3, 3, 3}, {}, 3, 1}));
  std::mt19937_64 random(1);
  for (const std::vector<std::size_t>& components :
       {std::vector<std::size_t>{1, 1, 1}, {2, 1, 3}, {3, 1, 3}, {2, 2, 1, 3, 1}, {1, 1, 1, 1, 1, 1, 1, 1, 1}}) {
    std::vector<std::size_t> field_of;
    for (std::size_t field = 0; field < components.size(); ++field)
      field_of.insert(field_of.end(), components[field], field);
    const std::size_t channels = field_of.size();
    std::vector<double> values(prepared.used_vertex_count * channels);
    for (std::size_t i = 0; i < values.size(); ++i) // each field a third of the one before
      values[i] = static_cast<double>(random() % 1000) / std::pow(3.0, static_cast<double>(field_of[i % channels]));
    const ExactFieldError together(prepared, {values, channels, field_of});
    ExactFieldError::Workspace workspace(together);
    for (int tries = 0; tries < 20; ++tries) {
      Tet version{};
      for (VertexId& v : version)
        v = VertexId{static_cast<std::uint32_t>(random() % prepared.used_vertex_count)};
      const auto at = [&](std::size_t i) { return prepared.points[version[i].index()]; };
      if (orientation(at(0), at(1), at(2), at(3)) < 0) std::swap(version[2], version[3]);
      std::vector<double> errors(components.size()), integrals(components.size()), faces_alone(components.size());
      integrals.push_back(0);
      together.measure(version, workspace, errors, integrals);
      together.measure(version, workspace, faces_alone);
      for (std::size_t field = 0, channel = 0; field < components.size(); channel += components[field++]) {
        INFO("field " << field << " of " << components.size());
        std::array<double, 2> sums{};
        double error = 0, greatest = 0;
        for (std::size_t c = 0; c < components[field]; ++c) {
          std::vector<double> alone;
          for (std::size_t v = 0; v < prepared.used_vertex_count; ++v)
            alone.push_back(values[v * channels + channel + c]);
          const std::size_t none = 0;
          const ExactFieldError exact(prepared, {alone, 1, {&none, 1}});
          ExactFieldError::Workspace its(exact);
          double of_channel = 0;
          sums[1] = 0;
          exact.measure(version, its, {&of_channel, 1}, sums);
          CHECK(sums[1] == Approx(integrals.back()).epsilon(1e-10));
          greatest = std::max(greatest, of_channel);
          error += of_channel * of_channel;
        }
        CHECK(integrals[field] == Approx(sums[0]).epsilon(1e-10));
        // The components of a vector are not greatest in one place.
        CHECK(errors[field] >= greatest * (1 - 1e-12));
        CHECK(errors[field] <= std::sqrt(error) * (1 + 1e-12));
        CHECK(faces_alone[field] == Approx(errors[field]).epsilon(1e-10));
      }
    }
  }
}

TEST_CASE("around a vertex of very many tets those are found that go where a version goes") {
  const Hub hub(20);
  std::vector<StarCones::Triangle> opposite;
  for (const auto& tet : hub.tets)
    opposite.push_back(hub.opposite(tet));
  REQUIRE(opposite.size() == 4800);
  const StarCones cones(hub.points[0], opposite);
  std::vector<std::uint32_t> found;
  for (const StarCones::Triangle& tet : opposite) { // itself and its neighbours, and few others
    cones.find_near(tet, found);
    if (found.size() > 40) FAIL(found.size() << " tets near one");
  }
  std::mt19937 random(5);
  const auto holds = [&](const std::array<std::uint32_t, 4>& tet, const Point& direction) {
    for (std::size_t k = 1; k < 4; ++k) {
      std::array<Point, 4> at{hub.points[tet[0]], hub.points[tet[1]], hub.points[tet[2]], hub.points[tet[3]]};
      at[k] = direction;
      if (orientation(at[0], at[1], at[2], at[3]) <= 0) return false;
    }
    return true;
  };
  for (const double width : {0.1, 0.5, 2.0, 10.0})
    for (int tries = 0; tries < 10; ++tries) {
      const auto uniform = [&] { return static_cast<double>(random() % 20001) / 10000 - 1; };
      const Point middle = {uniform(), uniform(), uniform()};
      StarCones::Triangle version{};
      for (Point& corner : version)
        for (std::size_t axis = 0; axis < 3; ++axis)
          corner[axis] = middle[axis] + width * uniform();
      cones.find_near(version, found);
      CHECK(std::is_sorted(found.begin(), found.end()));
      for (int ray = 0; ray < 20; ++ray) {
        const double a = 1 + uniform(), b = 1 + uniform(), c = 1 + uniform();
        using namespace vec;
        const Point direction = a * version[0] + b * version[1] + c * version[2];
        for (std::uint32_t t = 0; t < hub.tets.size(); ++t)
          if (holds(hub.tets[t], direction) && !std::binary_search(found.begin(), found.end(), t))
            FAIL("tet " << t << " is missed, width " << width);
      }
    }
}

TEST_CASE("what goes elsewhere from a vertex of very many tets does not count") {
  // With the whole ball, and with what of it is on the version's side: some hundred of its tets.
  const Hub ball(10);
  const std::array<std::uint32_t, 4> version = {0, ball.towards({1, 0.1, 0}), ball.towards({1, 0.4, 0.1}),
                                                ball.towards({1, 0.2, 0.4})};
  std::vector<std::array<std::uint32_t, 4>> near;
  for (const auto& tet : ball.tets)
    if (std::any_of(tet.begin() + 1, tet.end(), [&](std::uint32_t v) {
          const Point& p = ball.points[v];
          return p[0] > 0.6 && p[1] > -0.3 && p[2] > -0.3;
        }))
      near.push_back(tet);
  REQUIRE(ball.tets.size() == 1200);
  REQUIRE(near.size() < 250);
  std::mt19937 random(1);
  std::vector<double> value;
  for (std::size_t v = 0; v < ball.points.size(); ++v)
    value.push_back(static_cast<double>(random() % 1000));
  const TetMesh mesh = test::make_mesh(ball.points, ball.tets, ScalarType::kFloat64);
  TetMesh part = mesh;
  part.tets.clear();
  for (const auto& tet : near)
    part.tets.push_back({VertexId{tet[0]}, VertexId{tet[1]}, VertexId{tet[2]}, VertexId{tet[3]}});
  const Measured of_ball = Original(mesh, value).measure(version);
  const Measured of_part = Original(part, value).measure(version);
  CHECK(of_ball.largest > 100);
  CHECK(of_ball.largest == Approx(of_part.largest).epsilon(1e-13));
  CHECK(of_ball.integral == Approx(of_part.integral).epsilon(1e-12));
}
