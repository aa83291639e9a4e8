// Quadrics: what they say at a point does not depend on the vertex that carries them.
#include "build/quadric.hpp"

#include <random>

#include <catch2/catch.hpp>

using namespace ptet::build;

namespace {

struct Random {
  std::mt19937 engine{5};
  double number() { return std::uniform_real_distribution<double>(-1, 1)(engine); }
  ptet::Vec3 vector() { return {number(), number(), number()}; }
};

/// A tet's linear field, seen from the origin: value(x) = gradient . x + offset.
struct LinearField {
  double weight;
  ptet::Vec3 gradient;
  double offset;
  [[nodiscard]] double residual_sq(const ptet::Vec3& x, double f) const {
    const double r = ptet::dot(gradient, x) + offset - f;
    return weight * r * r;
  }
};

} // namespace

TEST_CASE("field quadric: the weighted square of the residual", "[build][quadric]") {
  FieldQuadric q;
  q.add_tet(2, {3, 0, 0});
  q.add_tet(5, {0, 1, -1});
  // At the carrying vertex nothing is lost.
  CHECK(q.at({0, 0, 0}, 0, 7) == 0);
  // 2 (3 * 1 - 4)^2 + 5 (2 - 3 - 4)^2
  CHECK(q.at({1, 2, 3}, 4, 7) == Approx(2 * 1 + 5 * 25));
}

TEST_CASE("field quadric: 0 wherever a point lies on the linear field of all tets", "[build][quadric]") {
  Random random;
  const ptet::Vec3 gradient = random.vector();
  FieldQuadric q;
  double weight = 0;
  for (int i = 0; i < 6; ++i) {
    const double w = 1 + random.number() / 2;
    q.add_tet(w, gradient);
    weight += w;
  }
  for (int i = 0; i < 20; ++i) {
    const ptet::Vec3 x = random.vector();
    CHECK(q.at(x, ptet::dot(gradient, x), weight) == Approx(0).margin(1e-14));
    CHECK(q.at(x, ptet::dot(gradient, x) + 0.5, weight) == Approx(0.25 * weight));
  }
}

TEST_CASE("field quadric: moving the carrying vertex keeps the value at every point", "[build][quadric]") {
  Random random;
  // Two vertices with tets of their own; one is merged into the other, and that one into a third.
  struct Carrier {
    ptet::Vec3 x;
    double f;
    FieldQuadric q;
    double weight = 0;
  };
  std::vector<LinearField> tets;
  std::vector<Carrier> carriers;
  for (int c = 0; c < 3; ++c) {
    Carrier carrier{random.vector(), random.number(), {}, 0};
    for (int i = 0; i < 4; ++i) {
      const double w = 1.5 + random.number();
      const ptet::Vec3 gradient = random.vector();
      carrier.q.add_tet(w, gradient);
      carrier.weight += w;
      tets.push_back({w, gradient, carrier.f - ptet::dot(gradient, carrier.x)});
    }
    carriers.push_back(carrier);
  }
  const auto merge = [&](const Carrier& from, Carrier& to) {
    to.q.add_moved(from.q, to.x - from.x, to.f - from.f, from.weight);
    to.weight += from.weight;
  };
  merge(carriers[0], carriers[1]);
  merge(carriers[1], carriers[2]);
  const Carrier& last = carriers[2];
  for (int i = 0; i < 50; ++i) {
    const ptet::Vec3 x = random.vector();
    const double f = random.number();
    double expected = 0;
    for (const LinearField& tet : tets)
      expected += tet.residual_sq(x, f);
    CHECK(last.q.at(x - last.x, f - last.f, last.weight) == Approx(expected).epsilon(1e-12));
  }
}

TEST_CASE("plane quadric: squared distances to planes, whatever vertex carries them", "[build][quadric]") {
  PlaneQuadric q;
  q.add_plane(1, {0, 0, 1});
  q.add_plane(4, {1, 0, 0});
  CHECK(q.at({0, 9, 0}) == 0);
  CHECK(q.at({2, 9, 3}) == Approx(9 + 4 * 4));

  PlaneQuadric moved;
  moved.add_plane(2, {0, 1, 0});
  const ptet::Vec3 t = {1, -2, 5}; // the new carrier as seen from the old one
  moved.add_moved(q, t);
  // At the new carrier itself, and at (2, 9, 3) of the old frame.
  CHECK(moved.at({0, 0, 0}) == Approx(25 + 4 * 1));
  CHECK(moved.at({1, 11, -2}) == Approx(2 * 121 + 9 + 4 * 4));
}
