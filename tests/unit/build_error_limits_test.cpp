// What a file states of errors within the limits of a build.
#include "build/error_limits.hpp"
#include "ptet/build.hpp"
#include "record/error_code.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

using namespace ptet;

TEST_CASE("error limits: what a file states of an error within one is not above what was asked", "[build]") {
  const PreparedMesh prepared = prepare(test::grid({{2, 2, 2}, {}, 1, 1}));
  const build::NormalizedFields fields(prepared, {"pressure"});
  const double range = fields.fields().front().range, diagonal = 17.3;
  int rounded = 0;
  for (double asked = 1e-9; asked < 3; asked *= 1.37)
    for (const bool relative : {true, false}) {
      BuildOptions options;
      options.max_field_error = {{"", {relative ? asked : asked * range, relative}}};
      options.max_domain_error = {relative ? asked : asked * diagonal, relative};
      const build::ErrorLimits limits(prepared, fields, options, diagonal);
      const auto check = [&](double greatest, double scale, const Bound& bound) {
        const double stated = decode_error(encode_error(greatest, scale), scale);
        CHECK(stated <= bound.absolute(scale));
        CHECK(greatest >= bound.absolute(scale) / std::exp2(1.0 / 16) * (1 - 1e-12));
        rounded += decode_error(encode_error(bound.absolute(scale), scale), scale) > bound.absolute(scale) ? 1 : 0;
      };
      check(limits.field().front() * range, range, options.max_field_error.front().bound);
      check(limits.domain(), diagonal, options.max_domain_error);
    }
  CHECK(rounded > 100);
}

TEST_CASE("error limits: those that the file holds as they are, none at all, and none allowed", "[build]") {
  const PreparedMesh prepared = prepare(test::grid({{2, 2, 2}, {}, 1, 1}));
  const build::NormalizedFields fields(prepared, {"pressure"});
  BuildOptions options;
  for (const double asked : {0.0, 0.125, 1.0, 4.0}) {
    options.max_field_error = {{"pressure", {asked, true}}};
    options.max_domain_error = {asked, true};
    const build::ErrorLimits limits(prepared, fields, options, 3);
    CHECK(limits.field() == std::vector<double>{asked});
    CHECK(limits.domain() == 3 * asked);
  }
  options.max_field_error.clear();
  options.max_domain_error = {INFINITY, false};
  const build::ErrorLimits limits(prepared, fields, options, 3);
  CHECK(std::isinf(limits.field().front()));
  CHECK(std::isinf(limits.domain()));
  CHECK_FALSE(limits.bounds_fields());
}

TEST_CASE("error limits: that of a flat domain is told of where it is more than its thickness", "[build]") {
  const bool is_flat = GENERATE(false, true);
  test::GridOptions shape{{8, 8, 1}, {}, 0, 1};
  TetMesh mesh = test::grid(shape);
  if (is_flat) {
    std::vector<Point> points;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
      points.push_back(mesh.position(VertexId(v)));
      points.back()[2] /= 64;
    }
    std::vector<std::array<std::uint32_t, 4>> tets;
    for (const Tet& tet : mesh.tets)
      tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
    mesh = test::make_mesh(points, tets);
  }
  BuildOptions options;
  options.prediction = Prediction::kQuadric;
  options.evaluation = Evaluation::kNone;
  const auto is_told = [&](const Bound& limit) {
    options.max_domain_error = limit;
    BuildReport report;
    (void)build_memory(mesh, options, &report);
    return std::any_of(report.notes.begin(), report.notes.end(),
                       [](const std::string& note) { return note.find("--max-domain-error") != std::string::npos; });
  };
  CHECK(is_told({0.02, true}) == is_flat);
  CHECK_FALSE(is_told({0.0001, true}));
  CHECK(is_told({100, false}));
}
