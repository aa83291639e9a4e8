// The exact errors of one collapse: by hand, and against brute force.
#include "build/trial.hpp"
#include "build_predictor_fixture.hpp"
#include "support/brute_force.hpp"

#include <cmath>
#include <cstring>

#include <catch2/catch.hpp>

using namespace ptet;
using build::SlotId;
using build::Vertex;
using build::test::Scene;

namespace {

/// A mesh with scalar fields, and a trial of it.
struct Tried {
  explicit Tried(PreparedMesh mesh)
      : scene(std::move(mesh)), exact(scene.prepared, scene.fields.view()),
        removed(scene.points(), scene.fields, scene.diagonal, build::CoveredPoints::kStay),
        trial(scene.complex, scene.points(), removed, &exact, 0, 64) {}

  Scene scene;
  ExactFieldError exact;
  build::RemovedVertices removed;
  build::Trial trial;

  [[nodiscard]] Vertex at(const Point& p) const {
    const auto found = std::find(scene.points().begin(), scene.points().end(), p);
    REQUIRE(found != scene.points().end());
    return static_cast<Vertex>(found - scene.points().begin());
  }

  struct Errors {
    double at_vertices, maximum, squared;
    std::vector<double> integrals; ///< modified slot x (field, volume outside)
    double outside = 0;
  };
  /// Of the first field, as fractions of its range.
  Errors errors(Vertex vs, Vertex vd) {
    REQUIRE(trial.examine(vs, vd) == CollapseStatus::kAccepted);
    const auto seen = trial.simulate().errors();
    Errors result{seen[0], 0, 0, {}};
    std::vector<double> errors(seen.begin(), seen.end());
    const std::vector<double> no_limit(errors.size(), std::numeric_limits<double>::infinity());
    REQUIRE(trial.measure(errors, &result.integrals, no_limit, [] { return false; }));
    result.maximum = errors[0];
    for (std::size_t i = 0; i < result.integrals.size(); i += seen.size() + 1) {
      result.squared += result.integrals[i];
      result.outside += result.integrals[i + seen.size()];
    }
    // Without integrals: the same.
    std::vector<double> alone(seen.begin(), seen.end());
    REQUIRE(trial.measure(alone, nullptr, no_limit, [] { return false; }));
    for (std::size_t f = 0; f < errors.size(); ++f)
      CHECK(alone[f] == Approx(errors[f]).epsilon(1e-12));
    return result;
  }
};

/// A box of cells of width 1 in its regular refinement, with its middle in the origin.
PreparedMesh box(int cells, const build::test::FieldAt& field) {
  ptet::test::GridOptions options;
  options.cells = {cells, cells, cells};
  options.jitter = 0;
  TetMesh mesh = ptet::test::grid(options);
  for (std::size_t i = 0; i < 3 * mesh.vertex_count(); ++i) {
    const auto value =
        static_cast<float>(mesh.positions.value(i / 3, static_cast<std::uint32_t>(i % 3)) / 16 - 0.5 * cells);
    std::memcpy(mesh.positions.bytes.data() + i * sizeof value, &value, sizeof value);
  }
  mesh.point_arrays.clear();
  ptet::test::add_array(mesh, "f", ScalarType::kFloat64, 1, field);
  return prepare(std::move(mesh));
}

} // namespace

// Eight tets around c = (0, 1/2, 0) in an octahedron, seen along z, and x^2:
//
//             N 0                     c goes to E: the new edge W E crosses c S in the origin o.
//           / | \          .
//        W 1- c 0 -1 E     Before, Phi is |x|: 0 in c, N, S and the corners on the z axis, 1 in E and W. Afterwards the
//           \ |o/          field is the part of W and E in the four tets around W E: 1 - |y| - |z|. The difference
//             S 0          1 - |x| - |y| - |z| is 1/2 in c, but 1 in o.
//
// Its square over one octant is the integral of (1 - s)^2 s^2 / 2 ds from 0 to 1, B(3, 3) / 2 = 1/60; in all 2/15.
TEST_CASE("trial: a quadratic field on an octahedron has the errors known by hand", "[build][trial]") {
  const std::vector<Point> points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {0, 0.5, 0}};
  const std::vector<std::array<std::uint32_t, 4>> tets = {{0, 2, 4, 6}, {0, 2, 5, 6}, {0, 3, 4, 6}, {0, 3, 5, 6},
                                                          {1, 2, 4, 6}, {1, 2, 5, 6}, {1, 3, 4, 6}, {1, 3, 5, 6}};
  TetMesh mesh = ptet::test::make_mesh(points, tets, ScalarType::kFloat64);
  ptet::test::add_array(mesh, "f", ScalarType::kFloat64, 1,
                        [](const Point& p) { return std::vector<double>{p[0] * p[0]}; });
  Tried tried(prepare(std::move(mesh)));
  const Vertex c = tried.at({0, 0.5, 0});
  for (const double end : {1.0, -1.0}) {
    const auto errors = tried.errors(c, tried.at({end, 0, 0}));
    CHECK(errors.at_vertices == Approx(0.5).epsilon(1e-14));
    CHECK(errors.maximum == Approx(1).epsilon(1e-8));
    CHECK(errors.maximum >= 1);
    CHECK(errors.squared == Approx(2.0 / 15).epsilon(1e-13));
  }
  // Towards the other corners |x| stays what it is.
  for (const Point& end : {Point{0, 1, 0}, Point{0, -1, 0}, Point{0, 0, 1}, Point{0, 0, -1}}) {
    const auto errors = tried.errors(c, tried.at(end));
    CHECK(errors.at_vertices == 0);
    CHECK(errors.maximum == 0);
    CHECK(errors.squared == 0);
  }
}

// In the regular refinement of a box, the field x y around the origin o. It is 1 in the neighbours (1, 1, .) and
// (-1, -1, .), 0 in o and the others. o goes to e = (1, 0, 0): the new edge from e to q = (-1, -1, 0) passes through
// (0, -1/2, 0) half way, where the field was 0 and becomes (0 + 1) / 2. In o itself it was 0 and stays 0, half way
// between e and (-1, 0, 0): vertices alone see nothing.
TEST_CASE("trial: a quadratic field on a regularly refined box, of which vertices see nothing", "[build][trial]") {
  Tried tried(box(2, [](const Point& p) { return std::vector<double>{p[0] * p[1]}; }));
  REQUIRE(tried.scene.fields.fields()[0].range == 2); // from -1 to 1 at the corners of the box
  const auto errors = tried.errors(tried.at({0, 0, 0}), tried.at({1, 0, 0}));
  CHECK(errors.at_vertices == 0);
  CHECK(errors.maximum == Approx(0.5 / 2).epsilon(1e-8));
  CHECK(errors.squared > 0);
  CHECK(errors.outside == 0);
}

TEST_CASE("trial: maxima and integrals against brute force", "[build][trial]") {
  Tried tried(build::test::prepared_grid(build::test::curved, 1, {3, 3, 3}));
  const Scene& scene = tried.scene;
  const PointArray& field = scene.prepared.mesh.point_arrays[0];
  const double range = scene.fields.fields()[0].range;
  int accepted = 0;
  double missed = 0;
  for (Vertex vs = 0; vs < scene.complex.vertex_count() && accepted < 12; vs += 3)
    for (const Vertex vd : scene.neighbours(vs)) {
      if (tried.trial.examine(vs, vd) != CollapseStatus::kAccepted) continue;
      const auto errors = tried.errors(vs, vd);
      const auto modified = tried.trial.check().modified();
      REQUIRE(errors.integrals.size() == 2 * modified.size());
      if (!tried.trial.check().moves_boundary()) CHECK(errors.outside == 0);
      double largest = 0;
      for (std::size_t m = 0; m < modified.size(); ++m) {
        if (scene.complex.is_ghost(scene.complex.slot(modified[m]))) {
          CHECK(errors.integrals[2 * m] == 0);
          continue;
        }
        Tet version;
        std::array<Point, 4> corners{};
        for (std::size_t i = 0; i < 4; ++i) {
          const Vertex x = scene.complex.slot(modified[m]).v[i];
          version[i] = VertexId{x == vs ? vd : x};
          corners[i] = scene.points()[version[i].index()];
        }
        double squared = 0;
        for (const Tet& original : scene.prepared.mesh.tets) {
          squared += ptet::test::integrals_over_overlap(scene.points(), field, original, version).squared[0];
          // Points of a lattice in every original tet.
          for (int a = 0; a <= 6; ++a)
            for (int b = 0; a + b <= 6; ++b)
              for (int c = 0; a + b + c <= 6; ++c) {
                const std::array<double, 4> fine = {a / 6.0, b / 6.0, c / 6.0, (6 - a - b - c) / 6.0};
                Point p{};
                double value = 0;
                for (std::size_t i = 0; i < 4; ++i) {
                  value += fine[i] * field.value(original[i].index(), 0);
                  for (std::size_t axis = 0; axis < 3; ++axis)
                    p[axis] += fine[i] * scene.points()[original[i].index()][axis];
                }
                const auto coarse = ptet::test::barycentrics(p, corners);
                if (!coarse || *std::min_element(coarse->begin(), coarse->end()) < 0) continue;
                for (std::size_t i = 0; i < 4; ++i)
                  value -= coarse->at(i) * field.value(version[i].index(), 0);
                largest = std::max(largest, std::abs(value) / range);
              }
        }
        CHECK(errors.integrals[2 * m] == Approx(squared / (range * range)).epsilon(1e-9).margin(1e-9));
      }
      CHECK(largest <= errors.maximum + 1e-9);
      if (!tried.trial.check().moves_boundary()) CHECK(errors.maximum <= 1.25 * largest + 1e-9);
      missed += errors.maximum - errors.at_vertices;
      ++accepted;
      break;
    }
  CHECK(accepted >= 8);
  CHECK(missed > 0);
}

TEST_CASE("trial: it gives up when told so, with what it has seen", "[build][trial]") {
  Tried tried(build::test::prepared_grid(build::test::curved, 1, {3, 3, 3}));
  const Scene& scene = tried.scene;
  Vertex vs = 0;
  while (!scene.is_inner(vs))
    ++vs;
  const Vertex vd = scene.neighbours(vs)[0];
  REQUIRE(tried.trial.examine(vs, vd) == CollapseStatus::kAccepted);
  REQUIRE(tried.trial.check().modified().size() > 2);
  int asked = 0;
  std::vector<double> errors(1), integrals;
  const std::vector<double> no_limit(1, std::numeric_limits<double>::infinity());
  CHECK_FALSE(tried.trial.measure(errors, &integrals, no_limit, [&] { return ++asked == 2; }));
  CHECK(asked == 2);
  CHECK(integrals.size() == 2 * tried.trial.check().modified().size());
  CHECK(std::count_if(integrals.begin(), integrals.end(), [](double x) { return x > 0; }) == 2);
  // Errors only rise.
  std::vector<double> raised = {17.0};
  CHECK(tried.trial.measure(raised, nullptr, no_limit, [] { return false; }));
  CHECK(raised[0] == 17);
  // Past a limit the walk ends.
  std::vector<double> limited(1);
  CHECK_FALSE(tried.trial.measure(limited, &integrals, {0.0}, [] { return false; }));
}

TEST_CASE("trial: what is known of versions stands for measuring them", "[build][trial]") {
  Tried tried(build::test::prepared_grid(build::test::curved, 1, {3, 3, 3}));
  const Scene& scene = tried.scene;
  Vertex vs = 0;
  while (!scene.is_inner(vs))
    ++vs;
  const auto around = scene.neighbours(vs);
  const std::vector<double> no_limit(1, std::numeric_limits<double>::infinity());
  const auto never = [] { return false; };
  build::KnownVersions known;
  int compared = 0;
  for (const Vertex vd : around) {
    if (tried.trial.examine(vs, vd) != CollapseStatus::kAccepted) continue;
    tried.trial.simulate();
    std::vector<double> errors(1), integrals;
    REQUIRE(tried.trial.measure(errors, &integrals, no_limit, never));
    // Given up half way, then gone on with, then all known, and given up again: always as if nothing were known.
    for (const double part : {0.5, 0.9, 2.0, 2.0, 0.9, 0.5, 0.1}) {
      const double limit = part * errors[0];
      std::vector<double> fresh(1), again(1), integrals_fresh, integrals_again;
      const bool whole = tried.trial.measure(again, &integrals_again, {limit}, never, &known);
      REQUIRE(whole == (errors[0] <= limit));
      CHECK(whole == tried.trial.measure(fresh, &integrals_fresh, {limit}, never));
      CHECK(again == fresh);
      CHECK(integrals_again == integrals_fresh);
      if (!whole) continue;
      CHECK(again == errors);
      CHECK(integrals_again == integrals);
      ++compared;
    }
  }
  CHECK(compared >= 4);
  // What it says is believed.
  REQUIRE_FALSE(known.values.empty());
  for (double& value : known.values)
    value *= 4;
  const Vertex vd = known.keys.back().target;
  REQUIRE(tried.trial.examine(vs, vd) == CollapseStatus::kAccepted);
  std::vector<double> fresh(1), believed(1), integrals;
  REQUIRE(tried.trial.measure(fresh, &integrals, no_limit, never));
  REQUIRE(tried.trial.measure(believed, &integrals, no_limit, never, &known));
  CHECK(believed[0] == Approx(4 * fresh[0]));
}

TEST_CASE("known versions: they stay within their room, and nothing joins them beyond it", "[build][trial]") {
  const auto learn = [](build::KnownVersions& known, std::size_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      known.keys.push_back({i, 7});
      known.values.insert(known.values.end(), {1.0, 2.0});
    }
  };
  build::KnownOfVertices all(3);
  CHECK(all.of(0) == nullptr); // no room yet
  all.settle(0);
  all.forget(0);
  all.set_room(1000);
  build::KnownVersions* const first = all.of(0);
  REQUIRE(first != nullptr);
  CHECK(first->takes_more);
  learn(*first, 33);
  CHECK(all.of(1) != nullptr); // what was learnt does not count before it is settled
  all.settle(0);
  CHECK(first->keys.capacity() == 33);
  CHECK(first->values.capacity() == 66);
  all.settle(0); // counts once
  CHECK(all.of(2) != nullptr);
  all.settle(2);
  learn(*all.of(1), 20);
  all.settle(1);
  // Full: what is known is told, but takes no more.
  CHECK(all.of(0) == first);
  CHECK_FALSE(first->takes_more);
  CHECK(first->keys.size() == 33);
  all.forget(2);
  CHECK(all.of(2) == nullptr);
  all.forget(0);
  CHECK(all.of(2) != nullptr);
  CHECK(all.of(1)->takes_more);
}
