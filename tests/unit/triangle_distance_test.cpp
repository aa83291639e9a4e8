// The distance that is made for many points against the closest point of each.
#include "error/triangle_distance.hpp"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;

TEST_CASE("triangle distance: as of the closest point, for triangles of any shape", "[error]") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1, 1);
  const auto somewhere = [&] { return Point{place(random), place(random), place(random)}; };
  for (int i = 0; i < 300; ++i) {
    const Point a = somewhere(), b = somewhere();
    Point c = somewhere();
    if (i % 3 == 1) // thin, down to flat
      for (std::size_t axis = 0; axis < 3; ++axis)
        c[axis] = a[axis] + 0.3 * (b[axis] - a[axis]) + std::pow(10.0, -i / 20) * c[axis];
    if (i % 50 == 2) c = b; // an edge
    if (i % 100 == 5) c = a;
    const TriangleDistance triangle({a, b, c});
    for (int k = 0; k < 50; ++k) {
      Point p = somewhere();
      if (k % 5 == 0) p = k % 2 == 0 ? a : b;
      if (k % 5 == 1) // in the plane, inside and outside
        for (std::size_t axis = 0; axis < 3; ++axis)
          p[axis] = a[axis] + p[0] * (b[axis] - a[axis]) + p[1] * (c[axis] - a[axis]);
      const double expected = std::sqrt(closest_on_triangle(p, a, b, c).distance_sq);
      const double found_sq = triangle.squared(p);
      CHECK(std::sqrt(found_sq) == Approx(expected).epsilon(1e-12).margin(1e-14));
      // What is said early is never beyond the truth, and never less than what was asked about.
      for (const double part : {0.5, 0.9, 2.0}) {
        const double enough = part * found_sq, said = triangle.squared(p, enough);
        CHECK(said <= found_sq * (1 + 1e-12) + 1e-28);
        if (said < enough) CHECK(said == found_sq);
        if (found_sq < enough * (1 - 1e-12) - 1e-28) CHECK(said == found_sq);
      }
    }
  }
}
