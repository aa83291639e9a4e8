// Makes the file that the examples are run on: from a real mesh where there is one, else from a generated one.
#include "ptet/build.hpp"
#include "ptet/error.hpp"
#include "support/meshes.hpp"
#ifdef PTET_HAS_VTK
#include "formats/vtk/read.hpp"
#endif

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <utility>

namespace {

/// The first field's first component brought to [0, 1]: "unit", a field whose values are known whatever the mesh.
void add_unit_field(ptet::TetMesh& mesh) {
  const ptet::PointArray& from = mesh.point_arrays.at(0);
  double least = from.value(0, 0), most = least;
  for (std::size_t v = 0; v < from.size(); ++v) {
    least = std::min(least, from.value(v, 0));
    most = std::max(most, from.value(v, 0));
  }
  ptet::PointArray unit{"unit", ptet::ScalarType::kFloat32, 1, {}};
  unit.resize(from.size());
  for (std::size_t v = 0; v < from.size(); ++v) {
    const auto value = static_cast<float>((from.value(v, 0) - least) / (most - least));
    std::memcpy(unit.bytes.data() + v * sizeof value, &value, sizeof value);
  }
  mesh.point_arrays.push_back(std::move(unit));
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  ptet::BuildOptions options;
  options.prediction = ptet::Prediction::kQuadric;
  options.evaluation = ptet::Evaluation::kVertices;
  try {
    ptet::TetMesh mesh;
#ifdef PTET_HAS_VTK
    if (const auto path = ptet::test::data_file("fire_ug.vtu")) mesh = ptet::read_mesh(*path);
#endif
    const bool is_real = !mesh.tets.empty();
    if (!is_real) mesh = ptet::test::grid({{12, 10, 8}, {}, 2, 1});
    add_unit_field(mesh);
    const ptet::BuildReport report = ptet::build_file(std::move(mesh), argv[1], options);
    std::printf("%s mesh: %llu tets\n", is_real ? "a real" : "a generated",
                static_cast<unsigned long long>(report.input_tets));
  } catch (const ptet::Error& error) {
    std::fprintf(stderr, "make_example_file: %s\n", error.what());
    return 1;
  }
}
