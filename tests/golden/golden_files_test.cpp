// Files of version 1 that were written once (make_golden.py) and are read for ever: the originals come out of them, and
// their coarsest meshes. That a second reader sees the same in them is tested in tests/second_reader.
#include "formats/ptet/verification.hpp"
#include "ptet/dataset.hpp"

#include <cmath>
#include <functional>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

struct Golden {
  const char* name;
  std::size_t vertices, tets;
  double volume;
  const char* array;
  std::function<double(const Point&)> value; ///< of the array, where it is known
};

double volume(const TetMesh& mesh) {
  double sum = 0;
  for (const Tet& tet : mesh.tets) {
    std::array<Point, 3> edge{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        edge[i][axis] = mesh.position(tet[i + 1])[axis] - mesh.position(tet[0])[axis];
    const auto& [a, b, c] = edge;
    const double determinant =
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    CHECK(determinant > 0);
    sum += determinant / 6;
  }
  return sum;
}

const Golden kFiles[] = {
    {"tiny", 27, 48, 1, "f", [](const Point& p) { return p[0] + 2 * p[1] * p[2]; }},
    {"fields", 125, 384, 1, "flow", [](const Point& p) { return p[1] - p[2]; }},
    {"double", 216, 750, 0, "density",
     [](const Point& p) { return std::exp(p[0] - p[1] * p[1]) * std::sin(7 * p[2]); }},
    {"no_squared_errors", 216, 750, 0, "density",
     [](const Point& p) { return std::exp(p[0] - p[1] * p[1]) * std::sin(7 * p[2]); }},
    {"pinched", 180, 420, 4, "f", [](const Point& p) { return p[0] * p[0] - p[1] * p[2]; }},
    {"sheets", 196, 468, 0, "f", [](const Point& p) { return p[0] * p[1] + p[2]; }},
    {"ordered", 66, 162, 1, "f", [](const Point& p) { return p[0] + std::sin(4 * p[1]) * p[2]; }},
    {"real", 714, 2869, 0, "t", {}},
};

} // namespace

TEST_CASE("golden files of version 1 are read") {
  for (const Golden& golden : kFiles) {
    INFO(golden.name);
    const auto data = Dataset::open(std::string(PTET_SOURCE_DIR "/tests/golden/") + golden.name + ".ptet");
    const TetMesh original = data->extract({}).mesh;
    CHECK(original.vertex_count() == golden.vertices);
    CHECK(original.tets.size() == golden.tets);
    const double whole = volume(original);
    if (golden.volume > 0) CHECK(whole == Approx(golden.volume));
    const PointArray* const array = original.find(golden.array);
    REQUIRE(array != nullptr);
    for (std::uint32_t v = 0; golden.value && v < original.vertex_count(); ++v)
      CHECK(array->value(v, 0) == Approx(golden.value(original.position(VertexId{v}))).epsilon(1e-6).margin(1e-6));

    Request request;
    request.max_tets = 0;
    const TetMesh coarsest = data->extract(request).mesh;
    CHECK(coarsest.tets.size() < original.tets.size() / 3);
    CHECK(volume(coarsest) > 0);
  }
}

TEST_CASE("golden files of version 1 keep all rules") {
  for (const Golden& golden : kFiles) {
    INFO(golden.name);
    const file::Verified verified =
        file::verify(file::open_file(std::string(PTET_SOURCE_DIR "/tests/golden/") + golden.name + ".ptet"),
                     [&](const file::Violation& violation) { FAIL_CHECK(violation.what); });
    CHECK(verified.is_whole());
  }
}
