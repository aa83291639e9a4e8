// The comparison of two meshes: cases known by hand, and random meshes against dense sampling.
#include "error/mesh_comparison.hpp"
#include "mesh/examination.hpp"
#include "support/brute_force.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <catch2/catch.hpp>
#include <tbb/global_control.h>

using namespace ptet;

namespace {

using Function = std::function<std::vector<double>(const Point&)>;

/// A mesh with values, as the comparison takes it.
struct Sample {
  TetMesh mesh;
  Examination found;
  std::vector<double> values;

  Sample(TetMesh of, const Function& value) : mesh(std::move(of)), found(examine(mesh)) {
    for (const Point& p : found.points) {
      const std::vector<double> row = value(p);
      values.insert(values.end(), row.begin(), row.end());
    }
  }
  [[nodiscard]] ComparedMesh view() const { return {found.points, mesh.tets, values}; }
};

MeshComparison compare(const Sample& original, const Sample& simplified, std::vector<std::uint32_t> components = {1}) {
  return {original.view(), simplified.view(), simplified.found.boundary.faces, std::move(components)};
}

TetMesh cube(int cells, int jitter, unsigned seed) {
  return test::grid({{cells, cells, cells}, {}, jitter, seed});
}

Point at(const std::array<Point, 4>& corners, const std::array<double, 4>& weight) {
  Point p{};
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] += weight[k] * corners[k][axis];
  return p;
}

std::array<Point, 4> corners_of(const Sample& sample, std::size_t t) {
  std::array<Point, 4> corners;
  for (std::size_t k = 0; k < 4; ++k)
    corners[k] = sample.found.points[sample.mesh.tets[t][k].index()];
  return corners;
}

double volume_of(const std::array<Point, 4>& tet) {
  std::array<Point, 3> edge;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      edge[i][axis] = tet[i + 1][axis] - tet[0][axis];
  double det = 0;
  for (std::size_t i = 0; i < 3; ++i)
    det += edge[0][i] * (edge[1][(i + 1) % 3] * edge[2][(i + 2) % 3] - edge[1][(i + 2) % 3] * edge[2][(i + 1) % 3]);
  return std::abs(det) / 6;
}

double value_in(const Sample& sample, std::size_t t, const std::array<double, 4>& weight) {
  double value = 0;
  for (std::size_t k = 0; k < 4; ++k)
    value += weight[k] * sample.values[sample.mesh.tets[t][k].index()];
  return value;
}

/// By plain search over all tets at evenly spread points of each original tet: the greatest difference inside, the mean
/// square there, and the volume of the inside.
struct Plain {
  double max = 0, mean_square = 0, volume = 0;
};
Plain plain_inside(const Sample& original, const Sample& simplified, int steps) {
  Plain plain;
  double weighted = 0;
  for (std::size_t t = 0; t < original.mesh.tets.size(); ++t) {
    const std::array<Point, 4> corners = corners_of(original, t);
    const double each = volume_of(corners) / (steps * steps * steps);
    for (int i = 0; i < steps; ++i)
      for (int j = 0; j < steps; ++j)
        for (int k = 0; k < steps; ++k) {
          // The gaps between sorted coordinates take the cube evenly to the tet.
          std::array<double, 3> cut = {(i + 0.4) / steps, (j + 0.5) / steps, (k + 0.6) / steps};
          std::sort(cut.begin(), cut.end());
          const std::array<double, 4> weight = {cut[0], cut[1] - cut[0], cut[2] - cut[1], 1 - cut[2]};
          const Point p = at(corners, weight);
          for (std::size_t s = 0; s < simplified.mesh.tets.size(); ++s) {
            const test::NearestOnTet near = test::nearest_on_tet(p, corners_of(simplified, s));
            if (near.distance > 0) continue;
            const double difference = value_in(original, t, weight) - value_in(simplified, s, near.weight);
            plain.max = std::max(plain.max, std::abs(difference));
            weighted += each * difference * difference;
            plain.volume += each;
          }
        }
  }
  plain.mean_square = weighted / plain.volume;
  return plain;
}

std::vector<double> wavy(const Point& p) {
  return {std::sin(p[0] / 9) * std::cos(p[1] / 7) + p[2] / 40};
}

} // namespace

TEST_CASE("comparison: a linear field is the same on any two meshes", "[mesh-comparison]") {
  const Function linear = [](const Point& p) {
    return std::vector<double>{1e3 + 2 * p[0] - p[1] + 0.5 * p[2], p[0], -p[1]};
  };
  const Sample fine(cube(4, 3, 1), linear);
  const Sample coarse(test::mapped(cube(3, 0, 2),
                                   [](const Point& p) {
                                     return Point{p[0] * 0.9, p[1] * 0.8 + 7, p[2]};
                                   }),
                      linear);
  const MeshComparison comparison = compare(fine, coarse, {1, 2});
  const InsideDifference inside = comparison.exact_inside();
  REQUIRE(inside.volume > 1000);
  for (const FieldDifference& field : inside.fields) {
    CHECK(field.max < 1e-11);
    CHECK(field.mean_square < 1e-22);
  }
  for (const FieldDifference& field : comparison.sampled(2000, 3).inside.fields)
    CHECK(field.max < 1e-11);
}

TEST_CASE("comparison: a mesh is not off from itself, whatever its values", "[mesh-comparison]") {
  std::mt19937 random(1);
  const Sample one(test::mapped(cube(5, 2, 3),
                                [](const Point& p) {
                                  return Point{p[0] * 0.37, p[1] * 0.91, p[2] / 7};
                                }),
                   [&](const Point&) {
                     const double value = static_cast<double>(random() % 1000) / 1000;
                     return std::vector<double>{value < 0.1 ? 1e30 : value};
                   });
  const InsideDifference inside = compare(one, one).exact_inside();
  CHECK(inside.fields[0].max == 0);
  CHECK(inside.fields[0].mean_square == 0);
}

TEST_CASE("comparison: one tet with another value at one corner", "[mesh-comparison]") {
  // The difference is 3 lambda_0: maximum 3 at vertex 0, mean square 9 * 2 * 3! / 5! = 0.9.
  const Sample a(test::single_tet(), [](const Point&) { return std::vector<double>{1.0}; });
  Sample b = a;
  b.values[0] = 4;
  const InsideDifference inside = compare(a, b).exact_inside();
  CHECK(inside.volume == Approx(compare(a, b).original_volume()).epsilon(1e-14));
  CHECK(inside.fields[0].max == Approx(3).epsilon(1e-14));
  CHECK(inside.fields[0].at == a.found.points[0]);
  CHECK(inside.fields[0].mean_square == Approx(0.9).epsilon(1e-14));
  CHECK(inside.cell_max == std::vector<double>{inside.fields[0].max});

  // Squares of values need not be anything that a double holds.
  for (const double unit : {1e-200, 1e200}) {
    Sample small = a, large = b;
    for (Sample* const sample : {&small, &large})
      for (double& value : sample->values)
        value *= unit;
    const MeshComparison comparison = compare(small, large);
    const InsideDifference found = comparison.exact_inside();
    CHECK(found.fields[0].max == Approx(3 * unit).epsilon(1e-14));
    CHECK(found.fields[0].rms() == Approx(std::sqrt(0.9) * unit).epsilon(1e-14));
    CHECK(found.cell_max == std::vector<double>{found.fields[0].max});
    CHECK(comparison.at_vertices().max[0] == Approx(3 * unit).epsilon(1e-14));
    CHECK(comparison.sampled(1000, 1).inside.fields[0].rms() == Approx(std::sqrt(0.9) * unit).epsilon(0.1));
  }

  // The orientation of tets does not matter.
  std::swap(b.mesh.tets[0][1], b.mesh.tets[0][2]);
  CHECK(compare(a, b).exact_inside().fields[0].mean_square == Approx(0.9).epsilon(1e-14));
}

TEST_CASE("comparison: vectors by the norm of their difference", "[mesh-comparison]") {
  const Sample a(cube(2, 0, 1), [](const Point&) { return std::vector<double>{1, 2, 3}; });
  const Sample b(cube(3, 0, 1), [](const Point&) { return std::vector<double>{4, 6, 3}; });
  const InsideDifference inside = compare(a, b, {2, 1}).exact_inside();
  CHECK(inside.fields[0].max == Approx(5).epsilon(1e-12));
  CHECK(inside.fields[0].mean_square == Approx(25).epsilon(1e-12));
  CHECK(inside.fields[1].max < 1e-12);
}

TEST_CASE("comparison: overlap, inside and outside of a shifted box", "[mesh-comparison]") {
  // Boxes of side 48, one shifted by 12 along x: a quarter is outside. Both fields are x, so outside, where the closest
  // point has x = 12, the difference is 12 - x: maximum 12, mean square 12^2 / 3.
  const Function x = [](const Point& p) { return std::vector<double>{p[0]}; };
  const Sample a(cube(3, 0, 1), x);
  const Sample b(test::mapped(cube(2, 0, 1),
                              [](const Point& p) {
                                return Point{p[0] * 1.5 + 12, p[1] * 1.5, p[2] * 1.5};
                              }),
                 x);
  const MeshComparison comparison = compare(a, b);
  const double whole = 48 * 48 * 48;
  CHECK(comparison.original_volume() == Approx(whole).epsilon(1e-12));
  CHECK(comparison.simplified_volume() == Approx(whole).epsilon(1e-12));
  const InsideDifference inside = comparison.exact_inside();
  CHECK(inside.volume == Approx(0.75 * whole).epsilon(1e-12));
  CHECK(inside.fields[0].max < 1e-12);

  OutsideDifference outside = comparison.sampled_outside(inside, false, 20000, 5);
  CHECK(outside.points == 20000);
  CHECK(outside.volume == Approx(0.25 * whole).epsilon(1e-9));
  CHECK(outside.fields[0].mean_square == Approx(48).epsilon(0.03));
  CHECK(outside.fields[0].max <= 12 + 1e-12);
  CHECK(outside.fields[0].max > 11.9);
  const VertexDifference vertices = comparison.at_vertices();
  for (std::size_t v = 0; v < a.found.points.size(); ++v) {
    const double px = a.found.points[v][0];
    CHECK((vertices.outside[v] != 0) == (px < 12));
    CHECK(vertices.max[v] == Approx(std::max(0.0, 12 - px)).margin(1e-12));
  }
  comparison.add_vertices(vertices, outside);
  CHECK(outside.vertices == 16);
  CHECK(outside.fields[0].max == Approx(12).epsilon(1e-14));

  const MeshComparison::Sampled sampled = comparison.sampled(40000, 6);
  CHECK(sampled.inside.points + sampled.outside.points == 40000);
  CHECK(sampled.inside.volume == Approx(inside.volume).epsilon(0.01));
  CHECK(sampled.outside.fields[0].mean_square == Approx(48).epsilon(0.05));
}

TEST_CASE("comparison: the outside of a mesh that overlaps itself", "[mesh-comparison]") {
  const Sample whole(cube(4, 0, 1), [](const Point& p) { return std::vector<double>{p[0]}; });
  TetMesh half = cube(4, 0, 1);
  const std::vector<Point> points = examine(half).points;
  double middle = 0;
  for (const Point& p : points)
    middle = std::max(middle, p[0] / 2);
  std::erase_if(half.tets, [&](const Tet& tet) {
    return std::any_of(tet.begin(), tet.end(), [&](VertexId v) { return points[v.index()][0] > middle; });
  });
  const Sample once(half, wavy);
  const std::vector<Tet> tets = half.tets;
  for (int i = 0; i < 2; ++i)
    half.tets.insert(half.tets.end(), tets.begin(), tets.end());
  Sample thrice(half, wavy);
  thrice.found.boundary = once.found.boundary;

  const MeshComparison a = compare(whole, once), b = compare(whole, thrice);
  const InsideDifference of_a = a.exact_inside(), of_b = b.exact_inside();
  CHECK(of_b.volume == Approx(3 * of_a.volume));
  const OutsideDifference left = a.sampled_outside(of_a, false, 20000, 1),
                          found = b.sampled_outside(of_b, false, 20000, 1);
  CHECK(left.volume == Approx(of_a.volume));
  CHECK(found.volume == Approx(left.volume).epsilon(0.05));
  CHECK(found.fields[0].rms() == Approx(left.fields[0].rms()).epsilon(0.05));
  CHECK(b.sampled(20000, 1).inside.volume == Approx(of_b.volume).epsilon(0.05));

  // Twice half of each tet: what covers it adds up to all of it.
  TetMesh halves = test::make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 2}}, {{0, 1, 2, 3}, {0, 1, 2, 3}});
  const Sample one(test::make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}}, {{0, 1, 2, 3}}), wavy);
  const Sample twice(std::move(halves), wavy);
  const MeshComparison c = compare(one, twice);
  const InsideDifference of_c = c.exact_inside();
  REQUIRE(of_c.volume == Approx(64.0 / 6));
  const OutsideDifference half_left = c.sampled_outside(of_c, true, 2000, 1);
  CHECK(half_left.volume == Approx(32.0 / 6).epsilon(0.01));
  CHECK(half_left.points == 2000);
  // One tet too many takes nothing from how much is looked at.
  TetMesh more = cube(4, 0, 1);
  more.tets.erase(more.tets.begin(), more.tets.begin() + 3);
  more.tets.push_back(more.tets.back());
  const Sample one_more(more, wavy);
  const MeshComparison d = compare(whole, one_more);
  CHECK(d.sampled_outside(d.exact_inside(), false, 2000, 1).points == 2000);
}

TEST_CASE("comparison: what is too thin to be sampled is counted", "[mesh-comparison]") {
  const Function x = [](const Point& p) { return std::vector<double>{p[0]}; };
  const Sample a(cube(3, 0, 1), x);
  const double film = 1e-5;
  const Sample b(test::mapped(cube(3, 0, 1), [&](const Point& p) { return Point{p[0] + film, p[1], p[2]}; }), x);
  const MeshComparison comparison = compare(a, b);
  const InsideDifference inside = comparison.exact_inside();
  const OutsideDifference outside = comparison.sampled_outside(inside, false, 2000, 5);
  CHECK(outside.volume == Approx(film * 48 * 48).epsilon(1e-6));
  CHECK(outside.points + outside.missed == 2000);
  CHECK(outside.missed > 1000);
  CHECK(outside.fields[0].max <= film * (1 + 1e-9));
}

TEST_CASE("comparison: values at points of no tet count for nothing", "[mesh-comparison]") {
  const Function bent = [](const Point& p) { return std::vector<double>{p[0] * p[0]}; };
  const Sample a(cube(4, 0, 1), bent), b(test::mapped(cube(2, 0, 1),
                                                      [](const Point&p) {
                                                        return Point{p[0] * 2, p[1] * 2, p[2] * 2};
                                                      }),
                                         bent);
  const FieldDifference plain = compare(a, b).exact_inside().fields[0];
  REQUIRE(plain.max > 1);
  for (const double unused : {1.79e308, -1e200, std::numeric_limits<double>::infinity()}) {
    Sample with = a;
    with.found.points.push_back({7, 7, 7});
    with.values.push_back(unused);
    const FieldDifference same = compare(with, b).exact_inside().fields[0];
    CHECK(same.max == plain.max);
    CHECK(same.mean_square == plain.mean_square);
    CHECK(same.scale == plain.scale);
  }
}

TEST_CASE("comparison: exact errors of random meshes against dense sampling", "[mesh-comparison]") {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Sample fine(cube(2, 3, seed), wavy);
    Sample coarse(test::mapped(cube(1, 0, seed),
                               [&](const Point& p) {
                                 return Point{2.1 * p[0] + 0.2 * p[1] - 1, 1.9 * p[1] + seed, 2 * p[2] - 0.3 * p[0]};
                               }),
                  wavy);
    std::mt19937 random(seed);
    for (double& value : coarse.values)
      value += std::uniform_real_distribution<double>(-0.2, 0.2)(random);
    const MeshComparison comparison = compare(fine, coarse);
    const InsideDifference inside = comparison.exact_inside();
    const Plain plain = plain_inside(fine, coarse, 12);
    CHECK(inside.fields[0].max >= plain.max * (1 - 1e-12));
    CHECK(inside.fields[0].max <= plain.max * 1.15);
    CHECK(inside.fields[0].mean_square == Approx(plain.mean_square).epsilon(0.02));
    CHECK(inside.volume == Approx(plain.volume).epsilon(0.01));
    CHECK(*std::max_element(inside.cell_max.begin(), inside.cell_max.end(),
                            [](double a, double b) { return std::isnan(a) || a < b; }) == inside.fields[0].max);
    const VertexDifference vertices = comparison.at_vertices();
    for (std::size_t v = 0; v < fine.found.points.size(); ++v)
      if (!vertices.outside[v]) CHECK(vertices.max[v] <= inside.fields[0].max * (1 + 1e-12));
    const MeshComparison::Sampled sampled = comparison.sampled(20000, seed);
    CHECK(sampled.inside.fields[0].max <= inside.fields[0].max * (1 + 1e-12));
    CHECK(sampled.inside.fields[0].mean_square == Approx(inside.fields[0].mean_square).epsilon(0.05));
  }
}

TEST_CASE("comparison: slivers count like other tets", "[mesh-comparison]") {
  // A tet against the same tet with a point just above one of its faces, all turned: there the values are 1 and, a
  // quarter of 16, 4.
  const auto turned = [](const Point& p) {
    const double c = std::cos(0.7), s = std::sin(0.7), y = s * p[0] + c * p[1];
    return Point{c * p[0] - s * p[1], c * y - s * p[2], s * y + c * p[2]};
  };
  const double height = GENERATE(1e-4, 1e-6, 1e-9, 1e-12, 1e-14);
  INFO(height);
  const TetMesh fan = test::make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}, {1, 1, height}},
                                      {{0, 1, 2, 4}, {0, 1, 4, 3}, {1, 2, 4, 3}, {2, 0, 4, 3}}, ScalarType::kFloat64);
  const TetMesh whole =
      test::make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}}, {{0, 1, 2, 3}}, ScalarType::kFloat64);
  const auto none = [](const Point&) { return std::vector<double>{0.0}; };
  Sample a(test::mapped(fan, turned), none), b(test::mapped(whole, turned), none);
  a.values = {0, 16, 0, 0, 1};
  b.values = {0, 16, 0, 0};
  for (const bool swapped : {false, true}) {
    const InsideDifference inside = (swapped ? compare(b, a) : compare(a, b)).exact_inside();
    CHECK(inside.volume == Approx(64.0 / 6).epsilon(1e-12));
    CHECK(inside.fields[0].max == Approx(3).epsilon(std::max(height, 1e-11)));
  }
  a.values = {0.3, -1.7, 0.1, 2.9, 17};
  const InsideDifference none_at_all = compare(a, a).exact_inside();
  CHECK(none_at_all.volume == Approx(64.0 / 6).epsilon(1e-12));
  CHECK(none_at_all.fields[0].max < 1e-10);
  for (const double difference : compare(a, a).at_vertices().max)
    CHECK(difference < 1e-10);
}

TEST_CASE("comparison: meshes apart, flat tets, tets that only touch", "[mesh-comparison]") {
  const auto zero = [](const Point&) { return std::vector<double>{0.0}; };
  const auto one = [](const Point&) { return std::vector<double>{1.0}; };
  // Turned, so that faces which touch do so only to rounding.
  const auto turned = [](double x, double y, double z) {
    const double c = std::cos(0.7), s = std::sin(0.7);
    return Point{c * x - s * y, c * (s * x + c * y) - s * z, s * (s * x + c * y) + c * z};
  };
  const auto moved = [&](const TetMesh& mesh, double by) {
    return test::mapped(mesh, [&](const Point& p) { return turned(p[0] + by, p[1], p[2]); });
  };
  const Sample a(moved(cube(2, 0, 1), 0), zero);
  const Sample far(moved(cube(1, 0, 1), 100), one), touching(moved(cube(3, 0, 1), 32), one);
  const Sample flat(test::make_mesh({{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {9, 9, 0}}, {{0, 1, 2, 3}}), one);
  for (const Sample* other : {&far, &touching, &flat}) {
    const InsideDifference inside = compare(a, *other).exact_inside();
    CHECK(inside.volume == 0);
    CHECK(inside.fields[0].max == 0);
    CHECK(std::all_of(inside.cell_max.begin(), inside.cell_max.end(), [](double x) { return std::isnan(x); }));
  }
  CHECK(compare(a, far).sampled(100, 1).inside.points == 0);
  CHECK_THROWS(MeshComparison(a.view(), far.view(), {}, {2}));
}

TEST_CASE("comparison: the same on any number of threads, and for the same seed", "[mesh-comparison]") {
  const Sample fine(cube(6, 3, 1), wavy), coarse(test::mapped(cube(3, 3, 2),
                                                              [](const Point&p) {
                                                                return Point{1.9 * p[0], 2 * p[1], 2.1 * p[2]};
                                                              }),
                                                 wavy);
  const MeshComparison comparison = compare(fine, coarse);
  std::vector<double> first;
  for (const int threads : {1, 2, 4}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    const InsideDifference inside = comparison.exact_inside();
    const OutsideDifference outside = comparison.sampled_outside(inside, false, 3000, 9);
    const auto [sampled, beyond] = comparison.sampled(3000, 9);
    const std::vector<double> all = {
        inside.fields[0].max, inside.fields[0].mean_square,  inside.volume,         outside.fields[0].max,
        outside.volume,       outside.fields[0].mean_square, sampled.fields[0].max, sampled.fields[0].mean_square,
        beyond.fields[0].max};
    if (first.empty()) first = all;
    CHECK(all == first);
    CHECK(comparison.sampled(3000, 10).inside.fields[0].mean_square != sampled.fields[0].mean_square);
  }
  const auto cancel = [](const Progress&) { return false; };
  CHECK_THROWS(comparison.exact_inside(cancel));
  CHECK_THROWS(comparison.sampled(10, 1, cancel));
  CHECK_THROWS(comparison.at_vertices(cancel));
}

TEST_CASE("boundary intersections: none, two sheets that cross, duplicated faces", "[mesh-comparison]") {
  const auto count = [](const TetMesh& mesh) {
    const Examination found = examine(mesh);
    const auto& faces = found.boundary.faces;
    std::uint64_t plain = 0;
    for (std::size_t i = 0; i < faces.size(); ++i)
      for (std::size_t j = i + 1; j < faces.size(); ++j)
        plain += faces_meet_improperly(faces[i], faces[j], found.points) ? 1 : 0;
    CHECK(count_boundary_intersections(found.points, faces) == plain);
    return plain;
  };
  for (const test::NamedMesh& named : test::sample_meshes(3))
    CHECK(count(named.mesh) == 0);
  // Two tets through one another.
  CHECK(count(test::make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}, {1, 1, -2}, {5, 1, 1}, {1, 5, 1}, {1, 1, 5}},
                              {{0, 1, 2, 3}, {4, 5, 6, 7}})) > 0);
}
