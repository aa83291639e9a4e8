// Pages of half-edges: what comes next, and what never comes twice.
#include "build/candidates.hpp"
#include "build_predictor_fixture.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <set>

#include <catch2/catch.hpp>

using namespace ptet;
using build::Candidates;
using build::HalfEdge;
using build::Vertex;
using build::test::Scene;

namespace {

/// Half-edges on a page where they are measured.
constexpr std::size_t kPage = 2;

/// Candidates over a mesh with one field.
struct Choice {
  explicit Choice(Prediction prediction, double round_fraction = 0.3, std::array<int, 3> cells = {3, 3, 3})
      : scene(build::test::prepared_grid(build::test::curved, 1, cells)), frozen(scene.prepared.frozen),
        surface(scene.complex, scene.points(), scene.diagonal, frozen),
        quadrics(scene.complex, scene.points(), scene.fields, scene.diagonal, {1.0}, 1.0,
                 build::QuadricWeight::kVolume),
        cost(Objective::kMaximum, {1.0}, std::array{1.0}, 1.0),
        removed(scene.points(), scene.fields, scene.diagonal, build::CoveredPoints::kStay),
        candidates(
            scene.complex, surface, quadrics, &quadrics, cost, prediction, round_fraction,
            [this] { return build::Trial(scene.complex, scene.points(), removed, nullptr, 1e-3, 64); }, frozen) {
    candidates.predict(1);
  }

  Scene scene;
  std::vector<char> frozen;
  build::WorkingSurface surface;
  build::QuadricPredictor quadrics;
  build::CollapseCost cost;
  build::RemovedVertices removed;
  Candidates candidates;

  [[nodiscard]] bool simulates() const { return candidates.simulations() > 0; }
  /// Where `v` may go at all.
  [[nodiscard]] std::set<Vertex> targets(Vertex v) const {
    std::set<Vertex> found;
    for (const build::SlotId s : scene.complex.star(v)) {
      const build::Slot& slot = scene.complex.slot(s);
      if (!scene.is_inner(v) && !scene.complex.is_ghost(slot)) continue;
      for (const Vertex x : slot.v)
        if (x != v && x != scene.complex.dummy()) found.insert(x);
    }
    return found;
  }
  /// Drops the best of `v`; where pages wait for the next round to be refilled, that is begun.
  void drop(Vertex v) {
    candidates.drop_best(v, 1);
    if (candidates.best(v).target == build::kNone) candidates.predict(1);
  }
  /// Drops the best of `v` until there is none; in order.
  std::vector<HalfEdge> drop_all(Vertex v) {
    std::vector<HalfEdge> seen;
    for (; candidates.best(v).target != build::kNone && seen.size() < 1000; drop(v))
      seen.push_back(candidates.best(v));
    return seen;
  }
  [[nodiscard]] double predicted(Vertex v, Vertex target) const { return Scene::cost(quadrics, v, target); }
};

} // namespace

TEST_CASE("candidates: pages are refilled until every half-edge was there, once", "[build][candidates]") {
  for (const Prediction prediction : {Prediction::kQuadric, Prediction::kSimulate, Prediction::kExact}) {
    Choice choice(prediction);
    CHECK(choice.simulates() == (prediction != Prediction::kQuadric));
    build::CollapseCheck check(choice.scene.complex, choice.scene.points(), 1e-3, 64);
    for (Vertex v = 0; v < choice.scene.complex.vertex_count(); ++v) {
      std::set<Vertex> expected = choice.targets(v);
      REQUIRE(expected.size() > kPage);
      if (choice.simulates())
        std::erase_if(expected, [&](Vertex x) { return check.examine(v, x) != CollapseStatus::kAccepted; });
      const std::vector<HalfEdge> seen = choice.drop_all(v);
      std::set<Vertex> targets;
      for (const HalfEdge& h : seen)
        targets.insert(h.target);
      CHECK(targets.size() == seen.size());
      CHECK(targets == expected);
      // What is simulated is only sorted within a page, for it is the prediction that orders the pages.
      if (prediction != Prediction::kExact) CHECK(std::is_sorted(seen.begin(), seen.end()));
      if (prediction == Prediction::kQuadric)
        for (const HalfEdge& h : seen)
          CHECK(h.cost == static_cast<float>(choice.predicted(v, h.target)));
    }
  }
}

TEST_CASE("candidates: the shortlist has the best by prediction, with simulated costs", "[build][candidates]") {
  Choice choice(Prediction::kExact);
  build::CollapseCheck check(choice.scene.complex, choice.scene.points(), 1e-3, 64);
  build::RemovedVertices::Simulation simulation;
  std::size_t differing = 0;
  for (Vertex v = 0; v < choice.scene.complex.vertex_count(); ++v) {
    std::vector<std::pair<double, Vertex>> order;
    for (const Vertex x : choice.targets(v))
      if (check.examine(v, x) == CollapseStatus::kAccepted) order.emplace_back(choice.predicted(v, x), x);
    std::sort(order.begin(), order.end());
    const std::vector<HalfEdge> seen = choice.drop_all(v);
    REQUIRE(seen.size() == order.size());
    for (std::size_t page = 0; page < seen.size(); page += kPage) {
      std::set<Vertex> here, expected;
      for (std::size_t i = page; i < std::min(page + kPage, seen.size()); ++i) {
        here.insert(seen[i].target);
        expected.insert(order[i].second);
        if (i > page) CHECK(seen[i - 1] < seen[i]);
      }
      CHECK(here == expected);
    }
    for (const HalfEdge& h : seen) {
      REQUIRE(check.examine(v, h.target) == CollapseStatus::kAccepted);
      choice.removed.simulate(choice.scene.complex, v, h.target, check.deleted(), check.modified(),
                              check.moves_boundary(), simulation);
      // Of the domain error that the quadrics see, half counts: it is measured later.
      const double expected = std::max(simulation.errors()[0], 0.5 * choice.quadrics.domain_cost(v, h.target)) +
                              choice.scene.length_part(v, h.target);
      CHECK(h.cost == Approx(expected).epsilon(1e-6));
      differing += h.cost != static_cast<float>(choice.predicted(v, h.target)) ? 1 : 0;
    }
  }
  CHECK(differing > 100);
}

TEST_CASE("candidates: a raised cost takes its place on the page, and is never lowered", "[build][candidates]") {
  Choice choice(Prediction::kExact);
  Candidates& candidates = choice.candidates;
  Choice same(Prediction::kExact);
  for (Vertex v = 0; v < choice.scene.complex.vertex_count(); ++v) {
    const std::vector<HalfEdge> before = same.drop_all(v);
    if (before.size() < 3) continue;
    candidates.raise_best(v, 0);
    CHECK(candidates.best(v) == before[0]);
    const float above = std::nextafter(before[1].cost, std::numeric_limits<float>::infinity());
    candidates.raise_best(v, above);
    CHECK(candidates.best(v) == before[1]);
    choice.drop(v);
    CHECK(candidates.best(v) == HalfEdge{above, before[0].target});
    choice.drop(v);
    CHECK(candidates.best(v) == before[2]);
  }
}

TEST_CASE("candidates: a vertex that failed waits, longer each time, unless all is looked at afresh",
          "[build][candidates]") {
  Choice choice(Prediction::kQuadric);
  Candidates& candidates = choice.candidates;
  const Vertex v = 5;
  const auto is_there = [&] { return candidates.best(v).target != build::kNone; };
  REQUIRE(is_there());
  const HalfEdge best = candidates.best(v);
  std::uint32_t round = 1;
  for (const std::uint32_t wait : {1U, 2U, 4U, 8U, 16U, 32U, 32U}) {
    while (is_there())
      candidates.drop_best(v, round);
    candidates.predict(round + wait);
    CHECK_FALSE(is_there()); // its star has not changed
    candidates.forget(v);
    candidates.predict(round + wait - 1);
    CHECK_FALSE(is_there());
    candidates.predict(round += wait);
    CHECK(candidates.best(v) == best);
  }
  while (is_there())
    candidates.drop_best(v, round);
  candidates.forget_all();
  candidates.predict(round);
  CHECK(candidates.best(v) == best);
}

TEST_CASE("candidates: only what has changed is predicted again", "[build][candidates]") {
  Choice choice(Prediction::kQuadric);
  Candidates& candidates = choice.candidates;
  const HalfEdge best = candidates.best(7);
  candidates.drop_best(7, 1);
  const HalfEdge second = candidates.best(7);
  REQUIRE(second != best);
  candidates.forget(8);
  candidates.predict(2);
  CHECK(candidates.best(7) == second);
  candidates.forget(7);
  candidates.predict(3);
  CHECK(candidates.best(7) == best);
}

TEST_CASE("candidates: the pick is the best part, and its highest cost is known", "[build][candidates]") {
  for (const double fraction : {0.1, 0.3, 1.0}) {
    Choice choice(Prediction::kQuadric, fraction);
    Candidates& candidates = choice.candidates;
    const auto count = choice.scene.complex.vertex_count();
    CHECK(candidates.movable_count() == count);
    const std::vector<Vertex> picked = candidates.pick();
    CHECK(picked.size() == static_cast<std::size_t>(std::ceil(fraction * count)));
    const std::set<Vertex> in(picked.begin(), picked.end());
    CHECK(in.size() == picked.size());
    float highest = 0;
    for (const Vertex v : picked) {
      highest = std::max(highest, candidates.best(v).cost);
      CHECK(candidates.height(v) == 0);
    }
    CHECK(candidates.round_cost() == highest);
    for (Vertex v = 0; v < count; ++v)
      if (in.count(v) == 0) CHECK(candidates.best(v).cost >= highest);
  }
}

TEST_CASE("candidates: lower heights come first, and the gone and the frozen not at all", "[build][candidates]") {
  Choice choice(Prediction::kQuadric, 1.0);
  Candidates& candidates = choice.candidates;
  const auto count = choice.scene.complex.vertex_count();
  // The slots around one vertex have been collapsed into five times.
  Vertex raised = 0;
  while (!choice.scene.is_inner(raised))
    ++raised;
  std::set<Vertex> around;
  for (const build::SlotId s : choice.scene.complex.star(raised)) {
    choice.scene.complex.slot(s).height = 5;
    for (const Vertex x : choice.scene.complex.slot(s).v)
      around.insert(x);
  }
  candidates.forget_all();
  candidates.predict(2);
  std::vector<Vertex> picked = candidates.pick();
  REQUIRE(picked.size() == count);
  for (std::size_t i = 0; i < picked.size(); ++i) {
    CHECK(candidates.height(picked[i]) == (around.count(picked[i]) != 0 ? 5 : 0));
    if (i > 0) CHECK(candidates.height(picked[i - 1]) <= candidates.height(picked[i]));
  }

  build::CollapseCheck check(choice.scene.complex, choice.scene.points(), 0, 64);
  Vertex target = build::kNone;
  for (const Vertex x : choice.targets(raised))
    if (check.examine(raised, x) == CollapseStatus::kAccepted) target = x;
  REQUIRE(check.examine(raised, target) == CollapseStatus::kAccepted);
  choice.quadrics.collapse(raised, target, check.deleted(), check.modified());
  choice.scene.complex.collapse(raised, target, check.deleted(), check.modified());
  candidates.forget_all();
  candidates.predict(3);
  picked = candidates.pick();
  CHECK(picked.size() == count - 1);
  CHECK(candidates.movable_count() == count - 1);
  CHECK(std::count(picked.begin(), picked.end(), raised) == 0);
  for (Vertex v = 0; v < count; ++v)
    if (v != raised) CHECK(candidates.best(v).target != raised);

  const std::vector<char> all_but_two = [&] {
    std::vector<char> frozen(count, 1);
    frozen[3] = frozen[9] = 0;
    return frozen;
  }();
  Candidates two(
      choice.scene.complex, choice.surface, choice.quadrics, &choice.quadrics, choice.cost, Prediction::kQuadric, 1.0,
      [&] { return build::Trial(choice.scene.complex, choice.scene.points(), choice.removed, nullptr, 0, 64); },
      all_but_two);
  two.predict(1);
  picked = two.pick();
  CHECK(std::set<Vertex>(picked.begin(), picked.end()) == std::set<Vertex>{3, 9});
}

// Inner vertices go, in rounds of stars that do not overlap, and some half-edges are refused. The pages of all others
// are mended, or filled, and must have what pages have that never knew anything else.
TEST_CASE("candidates: mended pages have all that pages filled anew have", "[build][candidates]") {
  Choice choice(Prediction::kQuadric, 0.3, {6, 6, 6});
  Candidates& candidates = choice.candidates;
  build::WorkingComplex& complex = choice.scene.complex;
  build::CollapseCheck check(complex, choice.scene.points(), 0, 64);
  std::size_t collapsed = 0, joined = 0;
  const std::uint32_t kLast = 6;
  for (std::uint32_t round = 2; round <= kLast; ++round) {
    std::set<Vertex> touched;
    // What was refused and has not changed may go again, so that in the end there is nothing that anew has and this
    // not.
    if (round == kLast)
      for (Vertex v = 0; v < complex.vertex_count(); ++v)
        if (complex.alive(v)) candidates.change_star({v, false, false}, build::kNone, 0);
    for (Vertex vs = 0; vs < complex.vertex_count(); ++vs) {
      if (!complex.alive(vs) || !choice.scene.is_inner(vs) || touched.count(vs) != 0) continue;
      const Vertex vd = candidates.best(vs).target;
      if (vd == build::kNone || check.examine(vs, vd) != CollapseStatus::kAccepted) continue;
      for (const build::LinkVertex& x : check.plan().link) {
        touched.insert(x.vertex);
        candidates.change_star(x, vd, round);
        joined += x.joins ? 1 : 0;
      }
      candidates.forget(vd);
      choice.quadrics.collapse(vs, vd, check.deleted(), check.modified());
      complex.collapse(vs, vd, check.deleted(), check.modified());
      ++collapsed;
    }
    candidates.predict(round);
    Candidates anew(
        complex, choice.surface, choice.quadrics, &choice.quadrics, choice.cost, Prediction::kQuadric, 0.3,
        [&] { return build::Trial(complex, choice.scene.points(), choice.removed, nullptr, 1e-3, 64); }, choice.frozen);
    anew.predict(round);
    for (Vertex v = 0; v < complex.vertex_count(); ++v) {
      if (!complex.alive(v) || (touched.count(v) == 0 && round < kLast)) continue;
      INFO("vertex " << v << ", round " << round);
      CHECK(candidates.best(v) == anew.best(v));
      for (std::size_t i = v % (choice.scene.is_inner(v) ? 8 : 3);
           i > 0 && round < kLast && candidates.best(v).target != build::kNone; --i)
        candidates.drop_best(v, round);
      for (std::size_t seen = 0; round == kLast && anew.best(v).target != build::kNone && seen < 1000; ++seen) {
        REQUIRE(candidates.best(v) == anew.best(v));
        candidates.drop_best(v, round);
        anew.drop_best(v, round);
      }
      if (round == kLast) CHECK(candidates.best(v).target == build::kNone);
    }
  }
  CHECK(collapsed > 40);
  CHECK(joined > 300);
}
