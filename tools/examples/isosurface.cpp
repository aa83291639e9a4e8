// An isosurface of a mesh that is fine only where the surface runs: where a field may take the value.
//
//   isosurface FILE.ptet FIELD VALUE
#include <cmath>
#include <cstdlib>
#include <iostream>

#include <ptet/dataset.hpp>

namespace {

using Triangle = std::array<ptet::Point, 3>;

/// The one or two triangles in which the surface cuts each tet (marching tetrahedra).
std::vector<Triangle> isosurface(const ptet::TetMesh& mesh, const ptet::PointArray& field, double value) {
  std::vector<Triangle> surface;
  for (const ptet::Tet& tet : mesh.tets) {
    std::vector<ptet::VertexId> low, high;
    for (const ptet::VertexId v : tet)
      (field.value(v.index(), 0) < value ? low : high).push_back(v);
    const auto crossing = [&](ptet::VertexId a, ptet::VertexId b) {
      const double fa = field.value(a.index(), 0), fb = field.value(b.index(), 0), t = (value - fa) / (fb - fa);
      const ptet::Point p = mesh.position(a), q = mesh.position(b);
      return ptet::Point{p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])};
    };
    std::vector<ptet::Point> ring; // in the order of neighbours round the cut
    for (std::size_t i = 0; i < low.size(); ++i)
      for (std::size_t j = 0; j < high.size(); ++j)
        ring.push_back(crossing(low[i], high[i % 2 == 0 ? j : high.size() - 1 - j]));
    for (std::size_t i = 2; i < ring.size(); ++i)
      surface.push_back({ring[0], ring[i - 1], ring[i]});
  }
  return surface;
}

} // namespace

int main(int argc, char** argv) {
  char* end = nullptr;
  const double value = argc == 4 ? std::strtod(argv[3], &end) : 0;
  if (argc != 4 || end == argv[3] || *end != '\0') {
    std::cerr << "usage: isosurface FILE.ptet FIELD VALUE\n";
    return 2;
  }
  try {
    const auto data = ptet::Dataset::open(argv[1]);
    ptet::Request request;
    request.field_error.push_back({argv[2], {0.01, true}}); // 1% of the range
    const std::size_t everywhere = data->extract(request).mesh.tets.size();
    request.values.push_back({argv[2], value, value}); // but only where it takes the value
    const ptet::Extraction cut = data->extract(request);
    const auto surface = isosurface(cut.mesh, *cut.mesh.find(argv[2]), value);
    std::cout << cut.mesh.tets.size() << " tets for " << surface.size()
              << " triangles; the same error everywhere takes " << everywhere << " tets\n";
  } catch (const ptet::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
