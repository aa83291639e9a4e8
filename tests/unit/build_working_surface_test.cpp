// The moving boundary: which collapses it bears, the domain error by hand, and whether it would meet itself.
#include "build/working_surface.hpp"
#include "build_fixture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <catch2/catch.hpp>

using namespace ptet;
using build::SlotId;
using build::Vertex;
using build::test::Fixture;
using build::test::tent;
using Tets = std::vector<std::array<Vertex, 4>>;

namespace {

struct Moving {
  /// `crossing_curves`: by boundary face.
  explicit Moving(Fixture f, std::vector<std::uint32_t> crossing_curves = {})
      : fixture(std::move(f)), frozen(fixture.points.size(), 0), curves(std::move(crossing_curves)) {}

  Fixture fixture;
  std::vector<char> frozen;
  std::vector<std::uint32_t> curves;
  build::WorkingSurface surface{fixture.complex, fixture.points, 10, frozen, build::DomainError::kSampled, curves};
  build::WorkingSurface::Workspace workspace{surface};

  bool would_intersect(Vertex vs, Vertex vd) {
    const build::WorkingSurface::FaceChanges changes = changes_of(vs, vd);
    return surface.would_intersect(fixture.complex, vs, vd, modified, changes, workspace);
  }
  bool would_pass_over(Vertex vs, Vertex vd) {
    classify(vs, vd);
    return surface.would_pass_over(fixture.complex, vs, vd, modified, workspace);
  }
  /// Collapses, and returns the domain error. Only the surface is asked.
  double collapse(Vertex vs, Vertex vd) {
    REQUIRE(surface.collapse_ok(vs, vd));
    const double error = simulate(vs, vd);
    build::WorkingSurface::Handover handover;
    build::WorkingSurface::take_handover(workspace, handover);
    const build::WorkingSurface::FaceChanges changes = changes_of(vs, vd);
    fixture.complex.collapse(vs, vd, deleted, modified);
    surface.collapse(vs, vd, handover);
    surface.move_faces(changes);
    return error;
  }
  build::WorkingSurface::FaceChanges changes_of(Vertex vs, Vertex vd) {
    classify(vs, vd);
    build::WorkingSurface::FaceChanges changes;
    surface.find_changes(fixture.complex, vs, vd, modified, deleted, changes);
    return changes;
  }
  double simulate(Vertex vs, Vertex vd) { return surface.simulate(vs, vd, workspace); }
  BoundingBox reach(Vertex vs, Vertex vd) {
    classify(vs, vd);
    return surface.reach(fixture.complex, vd, modified);
  }

private:
  void classify(Vertex vs, Vertex vd) {
    deleted.clear();
    modified.clear();
    for (const SlotId s : fixture.complex.star(vs)) {
      const auto& v = fixture.complex.slot(s).v;
      (std::find(v.begin(), v.end(), vd) != v.end() ? deleted : modified).push_back(s);
    }
  }
  std::vector<SlotId> deleted, modified;
};

/// Puts two bodies into one mesh.
Fixture both(const Fixture& a, const Tets& a_tets, const Fixture& b, const Tets& b_tets) {
  std::vector<Point> points = a.points;
  const auto shift = static_cast<Vertex>(points.size());
  points.insert(points.end(), b.points.begin(), b.points.end());
  Tets tets = a_tets;
  for (const auto& t : b_tets)
    tets.push_back({t[0] + shift, t[1] + shift, t[2] + shift, t[3] + shift});
  return {points, tets};
}
const Tets kTent = {{0, 1, 2, 3}, {0, 1, 3, 4}, {0, 1, 4, 5}, {0, 1, 5, 2}};

/// The ring is seen from the tip, but not from 2: the triangle 2 3 4 would lie on 2 4 5 upside down.
Fixture folding_tent() {
  Fixture f = tent(1);
  f.points[2] = {3, 0, 0};
  f.points[3] = {0.1, 0.5, 0};
  f.points[4] = {-1, 3, 0};
  f.points[5] = {-1, -1, 0};
  return f;
}

/// A tent with a tip below its ring, and above it a spike down to `z`.
Fixture spike_over_a_dent(double z) {
  return both(tent(-0.5), kTent, Fixture({{0, 0, z}, {0.1, 0.1, 3}, {-0.1, 0.1, 3}, {0, -0.1, 3}}, {{0, 1, 2, 3}}),
              {{0, 1, 2, 3}});
}

} // namespace

TEST_CASE("boundary: only edges of the surface collapse, and not into a fold", "[build][boundary]") {
  Moving m(tent(1));
  for (Vertex v = 0; v < 6; ++v)
    CHECK(m.surface.contains(v));
  CHECK(std::count(m.frozen.begin(), m.frozen.end(), 1) == 0);
  for (Vertex ring = 2; ring < 6; ++ring)
    CHECK(m.surface.collapse_ok(0, ring));
  CHECK_FALSE(m.surface.collapse_ok(0, 1)); // runs through the inside
  CHECK_FALSE(m.surface.collapse_ok(2, 4));
  m.collapse(0, 2);
  CHECK_FALSE(m.surface.contains(0));
  CHECK_FALSE(m.surface.collapse_ok(0, 3));

  // Two tets on the face 1 2 3, which is not on the boundary though its edges are: a waist.
  Moving waist(Fixture({{1, 1, 1.5}, {0, 0, 0}, {2, 0, 0}, {1, 2, 0}, {1, 1, -1.5}}, {{0, 1, 2, 3}, {4, 1, 2, 3}}));
  CHECK_FALSE(waist.surface.collapse_ok(1, 2));
  CHECK_FALSE(waist.surface.collapse_ok(3, 1));
  CHECK(waist.surface.collapse_ok(0, 1));
}

TEST_CASE("boundary: inner vertices are not on it", "[build][boundary]") {
  Moving m(Fixture({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {0, 0, 0}},
                   {{0, 1, 2, 4}, {0, 1, 3, 4}, {0, 2, 3, 4}, {1, 2, 3, 4}}));
  CHECK(m.surface.contains(0));
  CHECK_FALSE(m.surface.contains(4));
}

TEST_CASE("boundary: domain errors of the tent, by hand", "[build][boundary]") {
  for (const double tip : {0.75, -0.25}) {
    Moving m(tent(tip));
    REQUIRE(m.surface.collapse_ok(0, 2));
    // The tip is this far from the square; the centroids of its faces are a third of that.
    CHECK(m.simulate(0, 2) == Approx(std::abs(tip)));
    CHECK(m.simulate(0, 3) == Approx(std::abs(tip)));
    CHECK(m.collapse(0, 2) == Approx(std::abs(tip)));
    // The corner 3 goes to the other end of the side 3 2: what is left of it is the triangle 2 4 1 behind it.
    CHECK(m.collapse(3, 2) == Approx(std::sqrt(2.0)));
  }
}

TEST_CASE("boundary: what was handed on is measured again", "[build][boundary]") {
  // The tip is 4 above the triangle 2 3 4. The second collapse moves the corner 3 by less than that, and takes the tip,
  // which then is nearest to the edge 2 4.
  Fixture f = tent(4);
  f.points[0] = {-0.5, 0.5, 4};
  Moving m(std::move(f));
  CHECK(m.collapse(0, 2) == Approx(4));
  CHECK(m.collapse(3, 2) == Approx(std::sqrt(16 + 0.5)));
}

TEST_CASE("boundary: centroids of faces count where no vertex leaves the surface", "[build][boundary]") {
  // The tip lies in the triangle 2 3 4, so 0 -> 2 loses nothing there. But 5 is 1 lower, and the faces 0 4 5 and 0 5 2
  // are not in the plane of 2 4 5: their centroids stand 0.1 above or below it, and it is sloped by 1 : sqrt(2).
  Fixture f = tent(0, -3);
  f.points[0] = {-0.3, 0.3, 0};
  f.points[5] = {1, -1, -1};
  Moving m(std::move(f));
  CHECK(m.simulate(0, 2) == Approx(0.1 * std::sqrt(2.0 / 3)));
  // To the other side of that bend: the foot of the tip is on the plane 3 4 5 or 3 5 2.
  CHECK(m.simulate(0, 3) > 0.3);
}

TEST_CASE("boundary: bounds on the domain error, by hand", "[build][boundary]") {
  const auto bound = [](const Fixture& f, Vertex vd) {
    std::vector<char> frozen(f.points.size(), 0);
    build::WorkingSurface surface(f.complex, f.points, 10, frozen, build::DomainError::kBound);
    REQUIRE(surface.collapse_ok(0, vd));
    build::WorkingSurface::Workspace workspace(surface);
    const double most = surface.bound(0, vd, 100, workspace);
    // The tip is the only corner that is not in the plane of the others.
    CHECK(surface.at_least(0, vd, 100, workspace) == Approx(most > 0 ? std::abs(f.points[0][2]) : 0));
    return most;
  };
  for (const Vertex vd : {2U, 3U}) {
    CHECK(bound(tent(0), vd) == 0);
    CHECK(bound(tent(1e-14), vd) == 0);
    // The lid of the pit, or of the tent: as far as the tip.
    for (const double tip : {0.75, -0.25, -1.5}) {
      CHECK(bound(tent(tip), vd) >= std::abs(tip));
      CHECK(bound(tent(tip), vd) <= 1.07 * std::abs(tip));
    }
  }
  // All of the plane ring 2 3 4 5 stays covered, and the notch at 3 is too: the point of the edge 2 4 that is equally
  // far from 2 3 and 3 4 is not near anything.
  Fixture notch = tent(0);
  notch.points[2] = {3, 0, 0};
  notch.points[3] = {0.1, 0.5, 0};
  notch.points[4] = {-1, 3, 0};
  notch.points[5] = {-1, -1, 0};
  const double to_23 = 6.7 / std::hypot(0.5, 2.9), to_34 = 6.7 / std::hypot(2.5, 1.1);
  const double farthest = to_23 * to_34 / (to_23 + to_34);
  CHECK(Moving(notch).simulate(0, 2) == 0);
  CHECK(bound(notch, 2) >= farthest);
  CHECK(bound(notch, 2) <= 1.07 * farthest);
}

TEST_CASE("boundary: bounds far from the origin are as at it", "[build][boundary]") {
  // The new faces meet in the edge 2 4, which cuts old faces between their vertices.
  const auto bound = [](double far, double tip) {
    Fixture f = tent(tip);
    f.points[3] = {-0.75, 1.25, 0};
    f.points[5] = {1.25, -0.875, 0};
    for (Point& p : f.points)
      p = {p[0] + far, p[1] - 2 * far, p[2] + far};
    std::vector<char> frozen(f.points.size(), 0);
    build::WorkingSurface surface(f.complex, f.points, 10, frozen, build::DomainError::kBound);
    REQUIRE(surface.collapse_ok(0, 2));
    build::WorkingSurface::Workspace workspace(surface);
    return surface.bound(0, 2, 100, workspace);
  };
  for (const double far : {1e6, 1e9}) {
    CHECK(bound(far, 0) == 0);
    CHECK(bound(far, 0.5) == Approx(bound(0, 0.5)).epsilon(1e-14));
  }
}

TEST_CASE("boundary: distances of rounding only are none", "[build][boundary]") {
  Moving m(tent(1e-14));
  CHECK(m.simulate(0, 2) == 0);
}

TEST_CASE("boundary: a surface that would cross or touch another sheet", "[build][boundary]") {
  CHECK(Moving(spike_over_a_dent(-0.2)).would_intersect(0, 2));
  CHECK(Moving(spike_over_a_dent(0)).would_intersect(0, 2)); // the spike's end in the new face
  CHECK_FALSE(Moving(spike_over_a_dent(0.001)).would_intersect(0, 2));
}

TEST_CASE("boundary: what crosses another sheet already may cross it anew", "[build][boundary]") {
  // One number for each face of the body's vertices: of which curve it is.
  using Curves = std::array<std::uint32_t, 2>;
  const auto intersects = [](const Curves& of_roof, std::uint32_t of_spike) {
    Fixture f = spike_over_a_dent(-0.2);
    std::vector<std::uint32_t> curves;
    for (SlotId s = 0; s < f.complex.slot_count(); ++s) {
      const build::Slot& slot = f.complex.slot(s);
      if (!f.complex.is_ghost(slot)) continue;
      const auto holds = [&](Vertex v) { return std::find(slot.v.begin(), slot.v.end(), v) != slot.v.end(); };
      const bool is_spike = std::any_of(slot.v.begin(), slot.v.end(), [&](Vertex v) { return v >= 6 && v < 10; });
      curves.push_back(is_spike ? of_spike : holds(0) ? of_roof[holds(2) && holds(3) ? 0 : 1] : 0);
    }
    return Moving(std::move(f), std::move(curves)).would_intersect(0, 4);
  };
  CHECK(intersects({0, 0}, 0));
  CHECK_FALSE(intersects({1, 1}, 1));
  CHECK_FALSE(intersects({1, 0}, 1)); // any face of the star is enough, also where the new one is made of another
  CHECK(intersects({1, 1}, 2));       // the spike crosses something else
  CHECK(intersects({1, 1}, 0));
  CHECK(intersects({0, 0}, 1));
}

TEST_CASE("boundary: a crossing elsewhere does not let a surface fold over itself", "[build][boundary]") {
  CHECK(Moving(folding_tent(), std::vector<std::uint32_t>(8, 1)).would_intersect(0, 2));
}

TEST_CASE("boundary: in its own plane a surface meets nothing new", "[build][boundary]") {
  CHECK_FALSE(Moving(tent(0)).would_intersect(0, 2));
}

// A flat tet 0 3 4 6 lies on the roof, so that the ring around 0 is 2 3 6 4 5 outside and 2 3 4 5 inside:
//
//     6
//       '.3 ------- 2      6 (-2, 1.5, 0): from 2 it is hidden by 3
//        |    0    /
//        4 ------ 5
TEST_CASE("boundary: in front of flat tets faces turn over in their plane", "[build][boundary]") {
  Fixture f = tent(0);
  f.points.push_back({-2, 1.5, 0});
  Tets tets = kTent;
  tets.push_back({1, 3, 4, 6});
  tets.push_back({0, 3, 4, 6});
  Moving m(Fixture(f.points, tets));
  REQUIRE(m.fixture.complex.validate() == "");
  for (const Vertex vd : {2U, 5U}) {
    CHECK(m.fixture.examine(0, vd) == CollapseStatus::kAccepted);
    CHECK(m.surface.collapse_ok(0, vd));
  }
  CHECK(m.would_intersect(0, 2)); // 2 3 6 comes to lie on 2 6 4
  CHECK_FALSE(m.would_intersect(0, 5));
}

TEST_CASE("boundary: new faces that fold over one another", "[build][boundary]") {
  Moving m(folding_tent());
  CHECK(m.would_intersect(0, 2));
  CHECK_FALSE(m.would_intersect(0, 3));
}

// The tip of a dent goes to the ring, and the dent is closed: what hovers in it would be inside.
TEST_CASE("boundary: a body wholly in the space that a surface sweeps", "[build][boundary]") {
  const auto dent_and_body_at = [](const Point& at) {
    Fixture body({at, {at[0] + 0.05, at[1], at[2]}, {at[0], at[1] + 0.05, at[2]}, {at[0], at[1], at[2] + 0.05}},
                 {{0, 1, 2, 3}});
    return both(tent(-1), kTent, body, {{0, 1, 2, 3}});
  };
  const auto passes_over = [&](const Point& at) {
    Moving m(dent_and_body_at(at));
    CHECK_FALSE(m.would_intersect(0, 2));
    return m.would_pass_over(0, 2);
  };
  CHECK(passes_over({0.2, -0.1, -0.3}));
  CHECK(passes_over({-0.025, -0.025, -0.3}));  // where two of the swept tets join
  CHECK_FALSE(passes_over({0.2, -0.1, 0.3}));  // above the lid
  CHECK_FALSE(passes_over({0.2, -0.1, -1.4})); // in the body before and after
  CHECK_FALSE(passes_over({5, 5, 5}));
  CHECK_FALSE(Moving(tent(-1)).would_pass_over(0, 2));

  // Bodies that reach into one another: the surface of the one lies in places within what the other sweeps.
  const auto with_curves = [&](std::uint32_t of_tent, std::uint32_t of_body) {
    std::vector<std::uint32_t> curves(12, of_body);
    std::fill_n(curves.begin(), 8, of_tent);
    return Moving(dent_and_body_at({0.2, -0.1, -0.3}), curves).would_pass_over(0, 2);
  };
  CHECK_FALSE(with_curves(1, 1));
  CHECK(with_curves(1, 2));
  CHECK(with_curves(0, 0));
  CHECK_FALSE(with_curves(4000, 4000)); // of a piece: numbers of the whole mesh
  CHECK(with_curves(4000, 4001));

  // A bump that goes away from what touches one of the faces that go, in the middle of it.
  const Fixture beside({{0, 0.5, 0.5}, {0.05, 0.6, 0.6}, {-0.05, 0.6, 0.6}, {0, 0.55, 0.7}}, {{0, 1, 2, 3}});
  CHECK_FALSE(Moving(both(tent(1), kTent, beside, {{0, 1, 2, 3}})).would_pass_over(0, 2));
}

// What hangs into a dent from its ring, and has no other corners in it: with the edge from 2 to 4 above that from 3 to
// 5 the new faces lie over it, and touch it only where they end.
TEST_CASE("boundary: a body that hangs into what a surface sweeps, by its ring", "[build][boundary]") {
  const auto passes_over = [](double height) {
    Fixture f = tent(-1);
    f.points[2][2] = f.points[4][2] = height;
    const auto first = static_cast<Vertex>(f.points.size());
    f.points.push_back({1, 0, 3}); // above 2 and above 4
    f.points.push_back({-1, 0, 3});
    Tets tets = kTent;
    tets.push_back({3, 5, 2, first});
    tets.push_back({3, 5, first, first + 1});
    tets.push_back({3, 5, first + 1, 4});
    Moving m(Fixture(f.points, tets));
    REQUIRE(m.fixture.complex.validate() == "");
    CHECK_FALSE(m.would_intersect(0, 2));
    return m.would_pass_over(0, 2);
  };
  CHECK(passes_over(0.3));
  CHECK_FALSE(passes_over(-0.3));
}

// A thin slab: the tent's underside is another body's upper face, close below its ring. A tip that goes down to the
// ring stays above it; one that goes to a ring hanging through it does not.
TEST_CASE("boundary: thin_slab, through the sheet behind", "[build][boundary]") {
  // One body of two layers that share nothing near the tip: a dented roof over a floor with a bump.
  const auto slab = [](double bump) {
    Fixture roof = tent(0.5, 2); // foot above: the solid is over the tip, its lower side is the sheet that moves
    Fixture floor = tent(bump, -2);
    return both(roof, kTent, floor, kTent);
  };
  // The roof's lower side goes from the tip at z = 0.5 down to the ring at z = 0.
  CHECK(Moving(slab(0.3)).would_intersect(0, 2));
  // Moving the bump out of the way first (the floor's ring touches the roof's, so sink it).
  Fixture sunk = slab(0.3);
  for (Vertex v = 8; v < 12; ++v)
    sunk.points[v][2] = -0.5;
  Moving m(std::move(sunk));
  CHECK(m.would_intersect(0, 2));
  REQUIRE_FALSE(m.would_intersect(6, 8));
  m.collapse(6, 8);
  CHECK_FALSE(m.would_intersect(0, 2)); // the bump's old faces are forgotten
}

// The lower body's collapse makes a ridge from (2, 2, 1) to (-2, -2, 1) where there was a dent; the upper body's
// collapse would then put the edge (1.5, 0.5, 0.8) (0.5, 1.5, 0.8) under the ridge.
TEST_CASE("boundary: faces that were moved are met where they are now", "[build][boundary]") {
  Fixture lower = tent(-1, -5);
  lower.points[2] = {2, 2, 1};
  lower.points[3] = {-2, 2, -1};
  lower.points[4] = {-2, -2, 1};
  lower.points[5] = {2, -2, -1};
  Fixture upper = tent(2, 6);
  upper.points = {{1, 1, 2}, {1, 1, 6}, {1.5, 0.5, 0.8}, {1.5, 1.5, 2}, {0.5, 1.5, 0.8}, {0.5, 0.5, 2}};
  Moving m(both(lower, kTent, upper, kTent));
  m.surface.begin_changes();
  CHECK_FALSE(m.would_intersect(6, 8));
  CHECK(m.surface.would_meet(m.changes_of(0, 2), m.changes_of(6, 8)));
  CHECK_FALSE(m.surface.would_meet(m.changes_of(0, 2), m.changes_of(6, 9)));
  const BoundingBox reach = m.reach(6, 8);
  CHECK_FALSE(m.surface.has_moved(reach));
  REQUIRE_FALSE(m.would_intersect(0, 2));
  m.collapse(0, 2);
  CHECK(m.would_intersect(6, 8));
  CHECK_FALSE(m.would_intersect(6, 9)); // along the ridge there is room
  CHECK(m.surface.has_moved(reach));    // so what was said has to be asked again
  CHECK_FALSE(m.surface.has_moved(box_of(std::array{Point{5, 5, 0}, Point{6, 6, 1}})));
  m.surface.begin_changes();
  CHECK_FALSE(m.surface.has_moved(reach));
}

TEST_CASE("boundary: cut open where it is no manifold, and frozen there", "[build][boundary]") {
  // Two tets that share the edge 0 1: four faces meet there.
  Moving edge(
      Fixture({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2, 3}, {0, 1, 4, 5}}));
  CHECK(edge.frozen == std::vector<char>{1, 1, 0, 0, 0, 0});
  // Two tets that share the vertex 0.
  Moving vertex(Fixture({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                        {{0, 1, 2, 3}, {0, 4, 5, 6}}));
  CHECK(vertex.frozen == std::vector<char>{1, 0, 0, 0, 0, 0, 0});
  for (Vertex v = 0; v < 6; ++v) {
    CHECK(edge.surface.contains(v));
    CHECK(vertex.surface.contains(v));
  }
}

TEST_CASE("boundary: a collapse into a frozen place goes to the right one of its fans", "[build][boundary]") {
  // Two tents that share the ring vertex 2 (the second is the first turned about it).
  Fixture one = tent(0.5);
  std::vector<Point> points = one.points;
  Tets tets = kTent;
  for (const Vertex v : {0U, 1U, 3U, 4U, 5U})
    points.push_back({2 - one.points[v][0], 2 - one.points[v][1], -one.points[v][2]});
  const std::array<Vertex, 6> other = {6, 7, 2, 8, 9, 10};
  for (const auto& t : kTent)
    tets.push_back({other[t[0]], other[t[1]], other[t[2]], other[t[3]]});
  Moving m(Fixture(points, tets));
  CHECK(m.frozen[2] == 1);
  CHECK(std::count(m.frozen.begin(), m.frozen.end(), 1) == 1);
  CHECK(m.collapse(0, 2) == Approx(0.5));
  CHECK(m.collapse(6, 2) == Approx(0.5));
  CHECK(m.fixture.complex.validate() == "");
}
