// The numbers of a whole mesh that costs are measured by: deviations of fields, by hand.
#include "build/mesh_scales.hpp"
#include "support/meshes.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace ptet;
using build::NormalizedFields;

TEST_CASE("mesh scales: the deviation of a field is over the volume, a fraction of its range", "[build][scales]") {
  // Two tets on one face, the second one ten times as high, and a vertex in neither, whose value does not count.
  TetMesh mesh = test::make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -10}, {5, 5, 5}},
                                 {{0, 1, 2, 3}, {0, 2, 1, 4}});
  const auto at_peak = [](const Point& p) { return p[2] > 0 ? 1.0 : 0.0; };
  const auto is_loose = [](const Point& p) { return p[2] > 4; };
  test::add_array(mesh, "peak", ScalarType::kFloat64, 1,
                  [&](const Point& p) { return std::vector{is_loose(p) ? 100 : 8 * at_peak(p)}; });
  test::add_array(mesh, "even", ScalarType::kFloat64, 1,
                  [&](const Point& p) { return std::vector{is_loose(p) ? 100.0 : 3.0}; });
  test::add_array(mesh, "pair", ScalarType::kFloat64, 2, [&](const Point& p) {
    return std::vector{6 * at_peak(p), 1 - 8 * at_peak(p)};
  });
  const PreparedMesh prepared = prepare(mesh);
  const build::MeshScales scales = build::scales_of(prepared, NormalizedFields(prepared, {"peak", "even", "pair"}));
  CHECK(scales.volume == Approx(11.0 / 6));
  CHECK(scales.vertex_count == 5);
  // Of the barycentric coordinate of the peak: its mean over a tet is 1/4, that of its square 1/10. Of the volume the
  // tet at the peak has an eleventh.
  const double mean = 0.25 / 11;
  const double deviation = std::sqrt(0.1 / 11 - mean * mean);
  REQUIRE(scales.field_deviation.size() == 3);
  CHECK(scales.field_deviation[0] == Approx(deviation));
  CHECK(scales.field_deviation[1] == 1);
  CHECK(scales.field_deviation[2] == Approx(deviation));
}
