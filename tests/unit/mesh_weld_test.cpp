// Points that stand more than once, made one: which are, which stay apart, and what a mesh of parts becomes.
#include "mesh/prepare.hpp"
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"
#include "ptet/error.hpp"
#include "ptet/validate.hpp"
#include "ptet/weld.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using test::make_mesh;

namespace {

/// The tets `t` with `part_of(t)` p have points of their own for each p; the points of a part in random order.
template <class PartOf>
TetMesh in_parts(const TetMesh& whole, std::uint32_t parts, PartOf&& part_of, std::mt19937& random) {
  std::vector<std::vector<VertexId>> of_part(parts);
  for (std::uint32_t p = 0; p < parts; ++p) {
    std::vector<VertexId>& used = of_part[p];
    for (std::uint32_t t = 0; t < whole.tets.size(); ++t)
      if (part_of(t) == p) used.insert(used.end(), whole.tets[t].begin(), whole.tets[t].end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    std::shuffle(used.begin(), used.end(), random);
  }
  TetMesh mesh;
  mesh.positions = {"", whole.positions.type, 3, {}};
  for (const PointArray& array : whole.point_arrays)
    mesh.point_arrays.push_back({array.name, array.type, array.components, {}});
  const auto add_row = [](PointArray& to, const PointArray& from, VertexId v) {
    const auto row = from.bytes.begin() + static_cast<std::ptrdiff_t>(v.index() * from.row_bytes());
    to.bytes.insert(to.bytes.end(), row, row + static_cast<std::ptrdiff_t>(from.row_bytes()));
  };
  for (std::uint32_t p = 0; p < parts; ++p) {
    std::map<VertexId, VertexId> id;
    for (const VertexId v : of_part[p]) {
      id[v] = VertexId{static_cast<std::uint32_t>(mesh.vertex_count())};
      add_row(mesh.positions, whole.positions, v);
      for (std::size_t a = 0; a < whole.point_arrays.size(); ++a)
        add_row(mesh.point_arrays[a], whole.point_arrays[a], v);
    }
    for (std::uint32_t t = 0; t < whole.tets.size(); ++t) {
      if (part_of(t) != p) continue;
      const Tet& tet = whole.tets[t];
      mesh.tets.push_back({id[tet[0]], id[tet[1]], id[tet[2]], id[tet[3]]});
    }
  }
  return mesh;
}

/// Two tets on either side of the face 0 1 2, the second with points of its own.
TetMesh two_parts(const std::vector<float>& values) {
  TetMesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 0}, {0, 0, -1}, {1, 0, 0}},
                           {{0, 1, 2, 3}, {5, 4, 7, 6}});
  PointArray array{"f", ScalarType::kFloat32, 1, {}};
  array.resize(values.size());
  std::copy_n(reinterpret_cast<const std::byte*>(values.data()), array.bytes.size(), array.bytes.begin());
  mesh.point_arrays.push_back(array);
  return mesh;
}

void append(PointArray& array, const Point& p) {
  const auto* const bytes = reinterpret_cast<const std::byte*>(p.data());
  array.bytes.insert(array.bytes.end(), bytes, bytes + sizeof p);
}

/// Moves every number by up to `most`.
void disturb(PointArray& array, double most, std::mt19937& random) {
  REQUIRE(array.type == ScalarType::kFloat64);
  std::uniform_real_distribution<double> noise(-most, most);
  for (std::size_t at = 0; at < array.bytes.size(); at += sizeof(double)) {
    double x = 0;
    std::memcpy(&x, array.bytes.data() + at, sizeof x);
    x += noise(random);
    std::memcpy(array.bytes.data() + at, &x, sizeof x);
  }
}

double range_of(const PointArray& array, std::uint32_t component) {
  double least = array.value(0, component), greatest = least;
  for (std::size_t row = 1; row < array.size(); ++row) {
    least = std::min(least, array.value(row, component));
    greatest = std::max(greatest, array.value(row, component));
  }
  return greatest - least;
}

std::optional<Finding> finding(const MeshReport& report, const std::string& code) {
  const auto found = std::find_if(report.findings.begin(), report.findings.end(),
                                  [&](const Finding& other) { return other.code == code; });
  return found == report.findings.end() ? std::nullopt : std::optional(*found);
}

} // namespace

TEST_CASE("welding: points of the same place and values become the first of them", "[weld]") {
  TetMesh mesh = two_parts({1, 2, 3, 4, 3, 1, 5, 2});
  CHECK(weld_points(mesh) == 3);
  const TetMesh wanted =
      make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}}, {{0, 1, 2, 3}, {0, 2, 1, 4}});
  CHECK(mesh.positions == wanted.positions);
  CHECK(mesh.tets == wanted.tets);
  for (std::uint32_t v = 0; v < 5; ++v)
    CHECK(mesh.point_arrays[0].value(v, 0) == v + 1.0);
  CHECK(weld_points(mesh) == 0);
}

TEST_CASE("welding: what differs in a bit stays apart", "[weld]") {
  TetMesh jump = two_parts({1, 2, 3, 4, 3, 1, 5, 2.5});
  CHECK(weld_points(jump) == 2);
  CHECK(jump.vertex_count() == 6);
  TetMesh zeros = two_parts({1, 2, 0, 4, -0.0F, 1, 5, 2});
  CHECK(weld_points(zeros) == 2);
  const float nan = std::nanf("");
  TetMesh nans = two_parts({1, nan, 3, 4, 3, 1, 5, nan});
  CHECK(weld_points(nans) == 3);
}

TEST_CASE("welding: a tet keeps its four corners", "[weld]") {
  // The second tet is flat: two of its corners are alike, and a third point elsewhere is like both.
  TetMesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 1}, {2, 0, 0}, {0, 0, 1}, {2, 0, 0}},
                           {{0, 1, 2, 3}, {1, 2, 3, 4}, {0, 1, 5, 6}, {2, 3, 7, 0}});
  const TetMesh before = mesh;
  CHECK(weld_points(mesh) == 1); // of (2, 0, 0)
  CHECK(mesh.vertex_count() == 7);
  CHECK(mesh.tets[1] == before.tets[1]);
  CHECK(mesh.tets[2] == before.tets[2]);
  CHECK(mesh.tets[3][2] == VertexId{5});
}

TEST_CASE("welding: what rounding has set apart is welded where a distance says so", "[weld]") {
  // As the parts of a mesh that two processes computed.
  constexpr std::uint64_t kSeam = 7 * 7, kAll = 7 * 7 * 7;
  std::mt19937 random(5);
  const TetMesh whole = test::grid({{6, 6, 6}, {}, 2, 3});
  TetMesh exact = make_mesh({}, {}, ScalarType::kFloat64);
  for (std::uint32_t v = 0; v < whole.vertex_count(); ++v)
    append(exact.positions, whole.position(VertexId{v}));
  exact.point_arrays = {*std::find_if(whole.point_arrays.begin(), whole.point_arrays.end(),
                                      [](const PointArray& array) { return array.name == "flow"; })};
  exact.tets = whole.tets;
  exact = in_parts(
      exact, 2, [](std::uint32_t t) { return t < 3 * 6 * 6 * 6 ? 0U : 1U; }, random);
  REQUIRE(exact.vertex_count() == kAll + kSeam);
  const double diagonal = validate(exact).diagonal();

  TetMesh mesh = exact;
  disturb(mesh.positions, 1e-12, random);
  TetMesh by_bits = mesh;
  CHECK(weld_points(by_bits) == 0);
  const auto near = finding(validate(mesh), "near-points");
  REQUIRE(near);
  CHECK(near->count == kSeam);
  CHECK(near->severity == Severity::kNote);

  TetMesh welded = mesh;
  CHECK(weld_points(welded, {1e-11, false}) == kSeam);
  CHECK(validate(welded).findings.empty());
  CHECK(validate(welded).components == 1);
  // The first of them stays as it is, bit for bit: the parts stand one after the other.
  const std::size_t first_part = (kAll + kSeam) / 2 * welded.positions.row_bytes();
  CHECK(std::equal(mesh.positions.bytes.begin(), mesh.positions.bytes.begin() + static_cast<std::ptrdiff_t>(first_part),
                   welded.positions.bytes.begin()));
  TetMesh by_share = mesh;
  CHECK(weld_points(by_share, {1e-11 / diagonal, true}) == kSeam);
  CHECK(by_share.positions == welded.positions);
  TetMesh too_near = mesh;
  CHECK(weld_points(too_near, {1e-14, false}) == 0);
  CHECK(too_near.tets == mesh.tets);

  // Values have to be as near, as a part of their range.
  const double range = std::max(
      {range_of(exact.point_arrays[0], 0), range_of(exact.point_arrays[0], 1), range_of(exact.point_arrays[0], 2)});
  TetMesh changed = exact;
  disturb(changed.point_arrays[0], 1e-9 * range, random);
  CHECK(weld_points(changed, {1e-10, true}) < kSeam / 2);
  TetMesh changed_less = exact;
  disturb(changed_less.point_arrays[0], 1e-9 * range, random);
  CHECK(weld_points(changed_less, {2e-9, true}) == kSeam);

  // The order of the file is that of the welded mesh, and the file says within what it was welded.
  BuildOptions options;
  options.prediction = Prediction::kQuadric;
  options.evaluation = Evaluation::kVertices;
  options.weld = Bound{1e-13, true};
  options.keep_order = true;
  const auto dataset = Dataset::open_memory(build_memory(mesh, options));
  Request request;
  request.input_order = true;
  CHECK(dataset->extract(request).mesh.positions.bytes == welded.positions.bytes);
  CHECK(dataset->info().provenance_json.find("1e-13 of the diagonal") != std::string::npos);
}

TEST_CASE("welding over a distance: no chains, no whole numbers, no shapes", "[weld]") {
  const auto chain = [](double step) { // four tets side by side, each with a corner one step on from the last one's
    return make_mesh({{0, 0, 0},
                      {1, 0, 0},
                      {0, 1, 0},
                      {0, 0, 1},
                      {step, 0, 0},
                      {-1, 0, 0},
                      {0, 1, -1},
                      {0, 0, -1},
                      {2 * step, 0, 0},
                      {1, 0, -2},
                      {1, 1, -2},
                      {0, -1, -2},
                      {2.2 * step, 0, 0},
                      {3, 0, 5},
                      {3, 1, 5},
                      {3, 0, 6}},
                     {{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 9, 10, 11}, {12, 13, 14, 15}}, ScalarType::kFloat64);
  };
  TetMesh mesh = chain(1e-10);
  // The second becomes the first; the third is too far from it, and stays; the fourth becomes the third, not the
  // second.
  CHECK(weld_points(mesh, {1.5e-10, false}) == 2);
  CHECK(mesh.tets[1][0] == VertexId{0});
  CHECK(mesh.tets[2][0] == VertexId{7});
  CHECK(mesh.tets[3][0] == VertexId{7});
  CHECK(mesh.position(VertexId{7}) == Point{2e-10, 0, 0});

  TetMesh numbered = chain(1e-10);
  PointArray ids{"id", ScalarType::kInt32, 1, {}};
  ids.resize(numbered.vertex_count());
  ids.bytes[4 * 12] = std::byte{1}; // of the last corner
  numbered.point_arrays.push_back(ids);
  CHECK(weld_points(numbered, {1.5e-10, false}) == 1);

  for (const Bound& far : {Bound{0.1, false}, Bound{0.002, true}, Bound{-1e-9, false}, Bound{std::nan(""), false}}) {
    TetMesh left = chain(1e-10);
    CHECK_THROWS_AS(weld_points(left, far), Error);
    CHECK(left.vertex_count() == 16);
  }
  BuildOptions options;
  options.weld = Bound{-1, false};
  CHECK_THROWS_AS(build_memory(chain(1e-10), options), Error);
}

TEST_CASE("welding over a distance: edges may be shorter than it", "[weld]") {
  // Two blocks of four cubes each way side by side, the second set apart by rounding.
  TetMesh mesh = make_mesh({}, {}, ScalarType::kFloat64);
  const TetMesh block = test::grid({{4, 4, 4}, {}, 0, 1});
  double width = 0;
  for (std::uint32_t v = 0; v < block.vertex_count(); ++v)
    width = std::max(width, block.position(VertexId{v})[0]);
  const auto count = static_cast<std::uint32_t>(block.vertex_count());
  for (const double move : {0.0, width + 1e-12})
    for (std::uint32_t v = 0; v < count; ++v) {
      const Point p = block.position(VertexId{v});
      append(mesh.positions, {p[0] + move, p[1], p[2]});
    }
  append(mesh.positions, {2000 * width, 0, 0}); // so that a thousandth of the diagonal is more than an edge
  append(mesh.positions, {2000 * width, width, 0});
  append(mesh.positions, {2000 * width, 0, width});
  append(mesh.positions, {2001 * width, 0, 0});
  for (const std::uint32_t from : {0U, count})
    for (const Tet& tet : block.tets) {
      Tet moved = tet;
      for (VertexId& v : moved)
        v = VertexId{v.index() + from};
      mesh.tets.push_back(moved);
    }
  mesh.tets.push_back({VertexId{2 * count}, VertexId{2 * count + 1}, VertexId{2 * count + 2}, VertexId{2 * count + 3}});
  for (const double within : {1e-11, 0.2 * width, 0.26 * width, 0.6 * width, 1.1 * width}) {
    CAPTURE(within);
    TetMesh welded = mesh;
    CHECK(weld_points(welded, {within, false}) == 25);
    const MeshReport report = validate(welded);
    CHECK(report.components == 2);
    CHECK_FALSE(finding(report, "inverted-tets"));
  }
}

TEST_CASE("welding over a distance: what is no number is no obstacle", "[weld]") {
  TetMesh mesh =
      make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1 + 1e-12, 0}, {0, 0, 0}, {0, 0, -1}, {1, 0, 0}},
                {{0, 1, 2, 3}, {5, 4, 7, 6}}, ScalarType::kFloat64);
  PointArray flow{"flow", ScalarType::kFloat64, 3, {}}; // of two components, as some programs write it
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Point p = mesh.position(VertexId{v});
    append(flow, {p[0], p[1], std::nan("")});
  }
  mesh.point_arrays.push_back(flow);
  CHECK(weld_points(mesh, {1e-10, false}) == 3);

  TetMesh broken = make_mesh(
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, std::nan("")}, {0, 1 + 1e-12, 0}, {0, 0, 0}, {0, 0, -1}, {1, 0, 0}},
      {{0, 1, 2, 3}, {5, 4, 7, 6}}, ScalarType::kFloat64);
  CHECK(weld_points(broken, {1e-10, false}) == 3);
}

TEST_CASE("welding over a distance: thin parts are not closed", "[weld]") {
  // A plate of two layers, as thick as two thirds of the distance: no tet has points of both sides.
  TetMesh plate = make_mesh({}, {}, ScalarType::kFloat64);
  const TetMesh block = test::grid({{6, 6, 2}, {}, 0, 1});
  for (std::uint32_t v = 0; v < block.vertex_count(); ++v) {
    const Point p = block.position(VertexId{v});
    append(plate.positions, {p[0], p[1], 1e-3 * p[2]});
  }
  plate.tets = block.tets;
  const TetMesh before = plate;
  CHECK(weld_points(plate, {4.8e-2, false}) == 0);
  CHECK(plate.tets == before.tets);
}

TEST_CASE("welding over a distance: values are near by the range of those that tets have", "[weld]") {
  // A thousandth of the range apart, where a millionth was asked for; and in the last place of their type.
  const auto pair = [](float value, std::vector<float> others) {
    TetMesh mesh = make_mesh(
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1e-9, 0, 0}, {1, 1e-9, 0}, {1e-9, 1, 0}, {0, 0, -1}, {5, 5, 5}},
        {{0, 1, 2, 3}, {4, 6, 5, 7}}, ScalarType::kFloat64);
    PointArray array{"f", ScalarType::kFloat32, 1, {}};
    std::vector<float> values = {1, 1, 1, others[0], value, value, value, others[1], others[2]};
    array.resize(values.size());
    std::copy_n(reinterpret_cast<const std::byte*>(values.data()), array.bytes.size(), array.bytes.begin());
    mesh.point_arrays.push_back(array);
    return mesh;
  };
  TetMesh apart = pair(1.001F, {2, 1, 1}), with_fill = pair(1.001F, {2, 1, 1e30F}),
          last_place = pair(1 + 0x1p-23F, {2, 1, 1});
  CHECK(weld_points(apart, {1e-6, false}) == 0);
  CHECK(weld_points(with_fill, {1e-6, false}) == 0);
  CHECK(weld_points(last_place, {1e-8, false}) == 3);
  TetMesh far = pair(-3e38F, {3e38F, 1, 1});
  CHECK(weld_points(far, {1e-6, false}) == 0);
}

TEST_CASE("welding over a distance: a pile takes no more than its size, and who waits is asked", "[weld]") {
  // Tets with a tip in one place each, nearly, whose values differ.
  TetMesh pile = make_mesh({}, {}, ScalarType::kFloat64);
  PointArray values{"f", ScalarType::kFloat64, 1, {}};
  constexpr std::uint32_t kTets = 20'000;
  for (std::uint32_t t = 0; t < kTets; ++t) {
    const double x = t;
    append(pile.positions, {1e-12 * x, 0, 0});
    append(pile.positions, {x, 1, 1});
    append(pile.positions, {x + 0.5, 1, 1});
    append(pile.positions, {x, 1.5, 1});
    pile.tets.push_back({VertexId{4 * t}, VertexId{4 * t + 1}, VertexId{4 * t + 3}, VertexId{4 * t + 2}});
    for (int i = 0; i < 4; ++i) {
      const double value = x + i;
      const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
      values.bytes.insert(values.bytes.end(), bytes, bytes + sizeof value);
    }
  }
  pile.point_arrays.push_back(values);
  const TetMesh before = pile;
  int asked = 0;
  CHECK(weld_points(pile, {1e-6, false}, [&](const Progress&) { return ++asked > 0; }) == 0);
  CHECK(asked > 4);
  for (int at = 1; at <= 5; ++at) {
    int left = at;
    CHECK_THROWS_AS(weld_points(pile, {1e-6, false}, [&](const Progress&) { return --left > 0; }), Error);
    CHECK(pile.tets == before.tets);
  }
}

TEST_CASE("near points are found whichever way round a mesh lies, and by the type that coordinates had", "[weld]") {
  // A large tet and a small one beside it, as far as half its edges: not by rounding; and two that touch but for that.
  for (const double sign : {1.0, -1.0}) {
    const auto two = [&](double edge, double gap, double at) {
      std::vector<Point> points = {{at, 0, 0},          {at + 1, 0, 0},      {at, 1, 0},
                                   {at, 0, 1},          {at - gap, 0, 0},    {at - gap - edge, 0, 0},
                                   {at - gap, edge, 0}, {at - gap, 0, -edge}};
      for (Point& p : points)
        for (double& x : p)
          x *= sign;
      return make_mesh(points, {{0, 1, 2, 3}, {4, 5, 6, 7}}, ScalarType::kFloat64);
    };
    CHECK(!finding(validate(two(1e-6, 5e-7, 0)), "near-points"));
    CHECK(finding(validate(two(1, 5e-7, 0)), "near-points"));
    // One place of a float32, in doubles.
    CHECK(finding(validate(two(0.125, 0x1p-20, 8)), "near-points"));
    CHECK(!finding(validate(two(0.125, 0x1p-20, 8 + 0x1p-40)), "near-points"));
  }
}

TEST_CASE("welding: what is no mesh is left as it is", "[weld]") {
  TetMesh short_array = two_parts({1, 2, 3, 4, 3, 1, 5, 2});
  short_array.point_arrays[0].bytes.pop_back();
  TetMesh no_vertex = two_parts({1, 2, 3, 4, 3, 1, 5, 2});
  no_vertex.tets[1][3] = VertexId{8};
  for (TetMesh mesh : {short_array, no_vertex, TetMesh{}}) {
    const TetMesh before = mesh;
    CHECK(weld_points(mesh) == 0);
    CHECK(mesh.positions == before.positions);
    CHECK(mesh.point_arrays == before.point_arrays);
    CHECK(mesh.tets == before.tets);
  }
}

TEST_CASE("welding: parts become the mesh that they are of, and it can get as coarse", "[weld]") {
  std::mt19937 random(11);
  const TetMesh whole = test::grid({{8, 8, 8}, {}, 2, 3});
  const TetMesh parts = in_parts(
      whole, 5, [](std::uint32_t t) { return t / 6 * 2654435761U % 5; }, random); // cells here and there
  const std::uint64_t more = parts.vertex_count() - whole.vertex_count();
  REQUIRE(more > whole.vertex_count());
  CHECK(validate(parts).components > 5);
  TetMesh welded = parts;
  CHECK(weld_points(welded) == more);
  const MeshReport is = validate(welded), was = validate(whole);
  CHECK(is.findings.empty());
  CHECK(is.vertices == was.vertices);
  CHECK(is.boundary_faces == was.boundary_faces);
  CHECK(is.components == 1);
  CHECK(is.euler_characteristic == was.euler_characteristic);

  BuildOptions options;
  options.prediction = Prediction::kQuadric;
  options.evaluation = Evaluation::kVertices;
  options.target_vertices = 0.2;
  BuildReport apart, together;
  (void)build_memory(parts, options, &apart);
  options.weld = Bound{};
  options.keep_order = true;
  const auto bytes = build_memory(parts, options, &together);
  CHECK(apart.stopped_by != "target");
  CHECK(together.stopped_by == "target");
  CHECK(together.input_vertices == whole.vertex_count());
  CHECK(together.base_vertices <= 0.21 * static_cast<double>(whole.vertex_count()));
  REQUIRE(!together.notes.empty());
  CHECK(together.notes[0] == std::to_string(more) + " points were welded with others of the same place and values");
  // The order that is kept is that of the welded mesh.
  const auto dataset = Dataset::open_memory(bytes);
  Request request;
  request.input_order = true;
  const Extraction all = dataset->extract(request);
  CHECK(all.mesh.positions.bytes == welded.positions.bytes);
  CHECK(all.mesh.tets == welded.tets);
  CHECK(all.mesh.point_arrays == welded.point_arrays);
  CHECK(dataset->info().provenance_json.find("\"weld\"") != std::string::npos);
}
