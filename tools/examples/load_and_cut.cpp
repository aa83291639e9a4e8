// Opens a .ptet file, takes a mesh out of it within an error, and writes its surface as an OBJ file.
//
//   load_and_cut FILE.ptet [SURFACE.obj]
#include <fstream>
#include <iostream>

#include <ptet/dataset.hpp>

namespace {

void write_surface(const ptet::Extraction& cut, const char* path) {
  std::ofstream file(path);
  for (std::uint32_t v = 0; v < cut.mesh.vertex_count(); ++v) {
    const ptet::Point p = cut.mesh.position(ptet::VertexId{v});
    file << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  }
  for (const auto& face : cut.boundary_faces)
    file << "f " << face[0].index() + 1 << ' ' << face[1].index() + 1 << ' ' << face[2].index() + 1 << '\n';
  if (!file) throw ptet::Error(ptet::ErrorCode::kIo, std::string("cannot write ") + path);
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  try {
    const auto data = ptet::Dataset::open(argv[1]); // shared, const, usable from any thread
    const ptet::DatasetInfo& info = data->info();
    std::cout << info.vertices << " vertices, " << info.tets << " tets, " << info.fields.size() << " fields\n";

    ptet::Request request;
    request.field_error.push_back({"", {0.02, true}}); // every field that has errors: 2% of its range
    request.domain_error = ptet::Bound{0.01, true};    // 1% of the bounding-box diagonal
    const ptet::Extraction cut = data->extract(request);
    std::cout << "cut: " << cut.mesh.vertex_count() << " vertices, " << cut.mesh.tets.size() << " tets, limited by "
              << name_of(cut.limited_by) << '\n';
    std::size_t governing = 0;
    for (const ptet::FieldInfo& field : info.fields)
      if (field.governing)
        std::cout << field.name << " within " << cut.field_error.at(governing++) << ", of a range of " << field.range
                  << '\n';
    std::cout << "boundary within " << cut.domain_error / info.diagonal * 100 << "%\n";
    if (argc > 2) write_surface(cut, argv[2]);
  } catch (const ptet::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
