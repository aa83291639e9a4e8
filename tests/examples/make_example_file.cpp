// Makes the file that the examples are run on: from a real mesh where there is one, else from a generated one.
#include "ptet/build.hpp"
#include "ptet/error.hpp"
#include "support/meshes.hpp"
#ifdef PTET_HAS_VTK
#include "formats/vtk/read.hpp"
#endif

#include <cstdio>

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
    const ptet::BuildReport report = ptet::build_file(std::move(mesh), argv[1], options);
    std::printf("%s mesh: %llu tets\n", is_real ? "a real" : "a generated",
                static_cast<unsigned long long>(report.input_tets));
  } catch (const ptet::Error& error) {
    std::fprintf(stderr, "make_example_file: %s\n", error.what());
    return 1;
  }
}
