#include "fuzz/sample_files.hpp"

#include "formats/ptet/writer.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/stream_extras.hpp"

#include <algorithm>
#include <cmath>

namespace ptet::fuzz {
namespace {

/// As if the mesh had been given from back to front, each corner in another place.
file::GivenIds backwards(const TetMesh& mesh) {
  const auto vertices = static_cast<std::uint32_t>(mesh.vertex_count());
  file::GivenIds given;
  for (std::uint32_t v = 0; v < vertices; ++v)
    given.vertex.emplace_back(vertices - 1 - v);
  for (std::size_t t = mesh.tets.size(); t-- > 0;) {
    Tet tet = mesh.tets[t];
    for (VertexId& v : tet)
      v = given.vertex[v.index()];
    std::rotate(tet.begin(), tet.begin() + static_cast<std::ptrdiff_t>(t % 4), tet.end());
    given.tets.push_back(tet);
  }
  return given;
}

Bytes encode(const TetMesh& mesh, bool has_extras, bool keeps_order = false) {
  RecordStream records = test::simplify_naively(mesh);
  if (has_extras) {
    test::add_random_dependencies(records, 6);
    test::add_random_squared_errors(records, 6);
  }
  const file::GivenIds given = backwards(mesh);
  return file::encode(mesh, records, {"0.1.0", "sample.vtu", "xxh64:0", {{"option", "value"}}, {"note"}}, {},
                      keeps_order ? &given : nullptr);
}

/// Every type, decimal numbers and numbers that are none.
TetMesh of_all_types() {
  TetMesh mesh = test::grid({{3, 3, 2}, {}, 2, 3});
  const ScalarType types[] = {ScalarType::kInt8,   ScalarType::kUInt16, ScalarType::kInt32, ScalarType::kUInt32,
                              ScalarType::kUInt64, ScalarType::kInt64,  ScalarType::kInt16};
  for (const ScalarType type : types)
    test::add_array(mesh, name_of(type), type, 1,
                    [](const Point& p) { return std::vector{std::floor(std::fabs(p[0] * p[1]) / 32)}; });
  test::add_array(mesh, "price", ScalarType::kFloat64, 2, [](const Point& p) {
    return std::vector{std::round(100 * p[2]) / 100, p[0] > 30 ? std::nan("") : p[0] / 8};
  });
  return mesh;
}

} // namespace

const std::vector<Bytes>& sample_files() {
  static const std::vector<Bytes> files = [] {
    const auto without_centre = [](int i, int j, int k) { return i != 1 || j != 1 || k != 1; };
    return std::vector<Bytes>{encode(test::two_tets_sharing_a_face(), false),
                              encode(test::pinched_edge(), false),
                              encode(test::grid({{2, 2, 2}, {}, 2, 1}), false),
                              encode(test::grid({{3, 3, 3}, without_centre, 2, 2}), true),
                              encode(of_all_types(), true),
                              encode(test::grid({{2, 2, 3}, {}, 2, 1}), true, true),
                              encode(test::grid({{4, 4, 4}, {}, 2, 4}), true)};
  }();
  return files;
}

} // namespace ptet::fuzz
