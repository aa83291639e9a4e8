// The same records, whatever the units and the number of threads.
#include "build/collapse_check.hpp"
#include "build/working_complex.hpp"
#include "support/built.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <catch2/catch.hpp>

using namespace ptet;
using test::Built, test::build_all, test::same_bytes, test::same_collapses, test::scale, test::to_the_end,
    test::vertices_left;

namespace {

/// `one`: built on one thread.
void check_same_on_more_threads(const TetMesh& mesh, BuildOptions options, const Built& one) {
  for (const unsigned threads : {2U, 5U}) {
    options.threads = threads;
    const Built other = build_all(mesh, options);
    CHECK(same_collapses(one.stream, other.stream));
    CHECK(same_bytes(one.stream.field_error, other.stream.field_error));
    CHECK(same_bytes(one.stream.domain_error, other.stream.domain_error));
    CHECK(one.report.collapses == other.report.collapses);
  }
}

/// Whether each record is allowed, but for the geometry of the boundary, where they are made one by one.
bool each_is_possible(const Built& built, std::uint32_t max_star) {
  const PreparedMesh& prepared = built.prepared;
  build::WorkingComplex complex(prepared.used_vertex_count, prepared.mesh.tets, prepared.boundary_faces);
  build::CollapseCheck check(complex, prepared.points, 0, max_star);
  for (std::size_t r = 0; r < built.stream.size(); ++r) {
    const build::Vertex vs = built.stream.removed[r].index(), vd = built.stream.target[r].index();
    if (check.examine(vs, vd) != CollapseStatus::kAccepted) return false;
    complex.collapse(vs, vd, check.deleted(), check.modified());
  }
  return true;
}

} // namespace

TEST_CASE("units do not matter", "[build]") {
  const TetMesh mesh = test::grid({{6, 5, 4}, [](int x, int y, int) { return x != 3 || y != 2; }, 3, 11});
  const Built built = build_all(mesh, to_the_end());
  const auto scaled = [&](double length, double pressure, double flow) {
    TetMesh other = mesh;
    scale(other.positions, length);
    scale(other.point_arrays[0], pressure);
    scale(other.point_arrays[1], flow);
    return build_all(other, to_the_end());
  };
  SECTION("powers of two: the same records, errors scaled exactly") {
    for (const auto& [length, pressure, flow] :
         {std::array<double, 3>{0x1p20, 0x1p-18, 0x1p9}, std::array<double, 3>{0x1p-33, 0x1p40, 0x1p-60}}) {
      const Built other = scaled(length, pressure, flow);
      CHECK(same_collapses(built.stream, other.stream));
      REQUIRE(other.stream.field_error.size() == built.stream.field_error.size());
      std::size_t different = 0;
      for (std::size_t i = 0; i < built.stream.size(); ++i) {
        const auto differs = [](double here, double factor, double there) { return here * factor != there; };
        different += differs(built.stream.domain_error[i], length, other.stream.domain_error[i]) ? 1 : 0;
        different += differs(built.stream.field_error[2 * i], pressure, other.stream.field_error[2 * i]) ? 1 : 0;
        different += differs(built.stream.field_error[2 * i + 1], flow, other.stream.field_error[2 * i + 1]) ? 1 : 0;
      }
      CHECK(different == 0);
    }
  }
  SECTION("other factors: but for rounding") {
    for (const double factor : {1000.0, 1e-6}) {
      const Built other = scaled(factor, 1 / factor, 3 * factor);
      CHECK(std::abs(static_cast<double>(vertices_left(other)) - static_cast<double>(vertices_left(built))) <=
            0.02 * built.prepared.used_vertex_count + 3);
      // Where two collapses cost the same but for rounding, that decides, and what comes after differs: other
      // collapses, and as good ones.
      const auto mean = [](const std::vector<double>& errors, std::size_t first, std::size_t step, std::size_t end) {
        double sum = 0;
        for (std::size_t i = 0; i < end; ++i)
          sum += errors[i * step + first];
        return sum / static_cast<double>(end);
      };
      for (const double part : {0.25, 0.5, 0.75}) {
        const auto end = static_cast<std::size_t>(part * static_cast<double>(built.stream.size()));
        INFO("factor " << factor << ", the first " << end << " records");
        REQUIRE(other.stream.size() > end);
        const auto here = [&](std::size_t f) { return mean(built.stream.field_error, f, 2, end); };
        const auto there = [&](std::size_t f) { return mean(other.stream.field_error, f, 2, end); };
        CHECK(there(0) * factor == Approx(here(0)).epsilon(0.2));
        CHECK(there(1) / (3 * factor) == Approx(here(1)).epsilon(0.2));
        CHECK(mean(other.stream.domain_error, 0, 1, end) / factor ==
              Approx(mean(built.stream.domain_error, 0, 1, end)).epsilon(0.2));
      }
    }
  }
}

TEST_CASE("the same records on any number of threads", "[build]") {
  const TetMesh mesh = test::grid({{9, 9, 8}, [](int x, int y, int z) { return x != 4 || y != 4 || z > 3; }, 3, 5});
  BuildOptions options = to_the_end();
  options.threads = 1;
  const Built one = build_all(mesh, options);
  check_same_on_more_threads(mesh, options, one);
}

// More stars in a round than are examined at once, and a boundary among them.
TEST_CASE("by quadrics alone the same records on any number of threads", "[build]") {
  const TetMesh mesh = test::grid({{20, 20, 20}, [](int x, int y, int z) { return x != 9 || y < 4 || z < 8; }, 3, 5});
  BuildOptions options = to_the_end();
  options.prediction = Prediction::kQuadric;
  options.evaluation = Evaluation::kNone;
  options.threads = 1;
  const Built one = build_all(mesh, options);
  REQUIRE(one.stream.validate() == "");
  std::size_t most = 0, in_round = 0; // records
  for (std::size_t r = 0; r < one.stream.size(); ++r) {
    in_round = r > 0 && one.stream.round[r] == one.stream.round[r - 1] ? in_round + 1 : 1;
    most = std::max(most, in_round);
  }
  CHECK(most > 300);
  check_same_on_more_threads(mesh, options, one);
}

// A half-edge that did not wait for those that change the star of its target would be forbidden when it is made: by
// local predictions, where what comes first is refused more often, one of 50,000.
TEST_CASE("what is examined together could be collapsed one by one", "[build]") {
  BuildOptions options = to_the_end();
  options.prediction = Prediction::kLocal;
  options.evaluation = Evaluation::kNone;
  for (unsigned seed = 12; seed <= 15; ++seed) {
    INFO("seed " << seed);
    const TetMesh mesh =
        test::grid({{20, 20, 20}, [](int x, int y, int z) { return x != 10 || y < 6 || z < 10; }, 3, seed});
    CHECK(each_is_possible(build_all(mesh, options), options.max_star));
  }
}
