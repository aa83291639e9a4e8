#include "formats/vtk/read.hpp"
#include "fuzz/checks.hpp"
#include "fuzz/memory_file.hpp"
#include "fuzz/targets.hpp"
#include "mesh/prepare.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>

namespace ptet::fuzz {

void run_import(Input input) {
  // Exodus is read by netCDF and HDF5, whose own faults these are; a PVTU file names other files.
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  if (text.starts_with("CDF") || text.starts_with("\x89HDF") || text.find("PUnstr") != std::string_view::npos) return;
  const MemoryFile file(input);
  try {
    const TetMesh mesh = read_mesh(file.path());
    for (const PointArray& array : mesh.point_arrays)
      if (array.size() != mesh.vertex_count()) fail("an array has not a row for each vertex");
    for (const Tet& tet : mesh.tets)
      for (const VertexId v : tet)
        if (v.index() >= mesh.vertex_count()) fail("a tet has a vertex that is not there");
    const PreparedMesh prepared = prepare(mesh);
    if (prepared.mesh.tets.size() != mesh.tets.size()) fail("tets were lost");
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBadInput && error.code() != ErrorCode::kLimit)
      fail(std::string("another error than that of a mesh: ") + error.what());
  }
}

std::vector<Bytes> import_seeds() {
  std::vector<Bytes> seeds;
  for (const char* name : {"meshio_42.vtk", "vtk_51.vtk", "meshio_ascii.vtu", "meshio_lzma.vtu", "meshio_zlib.vtu",
                           "piece_0.vtu", "vtk_appended_base64_lz4.vtu", "vtk_polyhedra.vtu"}) {
    std::ifstream in(std::filesystem::path(PTET_SOURCE_DIR) / "tests" / "fixtures" / name, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const Input bytes = std::as_bytes(std::span(text));
    seeds.emplace_back(bytes.begin(), bytes.end());
  }
  return seeds;
}

} // namespace ptet::fuzz
