// Builds a .ptet file from a block of 6 x 6 x 6 cubes, each cut into six tetrahedra, with one field.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <utility>

#include <ptet/build.hpp>
#include <ptet/error.hpp>

namespace {

constexpr std::uint32_t kCubes = 6;

ptet::VertexId vertex_at(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return ptet::VertexId{x + (kCubes + 1) * (y + (kCubes + 1) * z)};
}

void set(ptet::PointArray& array, std::size_t index, float value) {
  std::memcpy(array.bytes.data() + index * sizeof(float), &value, sizeof(float));
}

ptet::TetMesh block() {
  ptet::TetMesh mesh;
  const std::size_t vertices = (kCubes + 1) * (kCubes + 1) * (kCubes + 1);
  mesh.positions = {"", ptet::ScalarType::kFloat32, 3, {}};
  mesh.positions.resize(vertices);
  ptet::PointArray field{"f", ptet::ScalarType::kFloat32, 1, {}};
  field.resize(vertices);
  for (std::uint32_t z = 0; z <= kCubes; ++z)
    for (std::uint32_t y = 0; y <= kCubes; ++y)
      for (std::uint32_t x = 0; x <= kCubes; ++x) {
        const std::size_t v = vertex_at(x, y, z).index();
        set(mesh.positions, 3 * v, static_cast<float>(x));
        set(mesh.positions, 3 * v + 1, static_cast<float>(y));
        set(mesh.positions, 3 * v + 2, static_cast<float>(z));
        set(field, v, std::sin(static_cast<float>(x + 2 * y) * 0.4F) + static_cast<float>(z * z) * 0.05F);
      }
  mesh.point_arrays.push_back(std::move(field));

  // The six ways from one corner of a cube to the opposite one, along its edges; odd ways are turned round.
  constexpr std::uint32_t kWays[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  for (std::uint32_t z = 0; z < kCubes; ++z)
    for (std::uint32_t y = 0; y < kCubes; ++y)
      for (std::uint32_t x = 0; x < kCubes; ++x)
        for (std::size_t way = 0; way < 6; ++way) {
          std::uint32_t at[3] = {x, y, z};
          ptet::Tet tet{vertex_at(x, y, z)};
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[kWays[way][step]];
            tet[step + 1] = vertex_at(at[0], at[1], at[2]);
          }
          if (way >= 3) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
        }
  return mesh;
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    ptet::BuildOptions options;
    options.target_vertices = 0.1;
    const ptet::BuildReport report = ptet::build_file(block(), argv[1], options);
    std::printf("%llu of %llu vertices in the base mesh\n", static_cast<unsigned long long>(report.base_vertices),
                static_cast<unsigned long long>(report.input_vertices));
    return report.base_vertices < report.input_vertices ? 0 : 1;
  } catch (const ptet::Error& error) {
    std::fprintf(stderr, "write_file: %s\n", error.what());
    return 1;
  }
}
