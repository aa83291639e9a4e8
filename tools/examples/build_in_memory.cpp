// From a mesh in memory to a cut of it, without any file between: a block of cubes, six tets each, with a wave in it.
#include <cmath>
#include <cstring>
#include <iostream>

#include <ptet/build.hpp>
#include <ptet/dataset.hpp>

namespace {

constexpr std::uint32_t kSide = 21; // vertices along an edge of the block

ptet::TetMesh block() {
  std::vector<float> points, wave;
  ptet::TetMesh mesh;
  constexpr std::uint32_t kStep[3] = {1, kSide, kSide * kSide};
  constexpr int kWays[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  for (std::uint32_t v = 0; v < kSide * kSide * kSide; ++v) {
    const std::uint32_t x = v % kSide, y = v / kSide % kSide, z = v / kSide / kSide;
    points.insert(points.end(), {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    wave.push_back(std::sin(0.02F * static_cast<float>(x * x + y * y + z)));
    if (x + 1 == kSide || y + 1 == kSide || z + 1 == kSide) continue;
    for (const auto& way : kWays) { // from a corner of the cube to the opposite one, along its edges
      const std::uint32_t b = v + kStep[way[0]], c = b + kStep[way[1]], d = c + kStep[way[2]];
      mesh.tets.push_back({ptet::VertexId{v}, ptet::VertexId{b}, ptet::VertexId{c}, ptet::VertexId{d}});
    }
  }
  const auto as_bytes = [](const std::vector<float>& from) {
    std::vector<std::byte> bytes(from.size() * sizeof(float));
    std::memcpy(bytes.data(), from.data(), bytes.size());
    return bytes;
  };
  mesh.positions = {"", ptet::ScalarType::kFloat32, 3, as_bytes(points)};
  mesh.point_arrays.push_back({"wave", ptet::ScalarType::kFloat32, 1, as_bytes(wave)});
  return mesh;
}

} // namespace

int main() {
  try {
    ptet::BuildOptions options;
    options.prediction = ptet::Prediction::kQuadric; // fast; the errors are measured exactly all the same
    options.target_vertices = 0.02;
    ptet::BuildReport report;
    const auto data = ptet::Dataset::open_memory(ptet::build_memory(block(), options, &report));
    std::cout << report.input_tets << " tets, down to " << report.base_tets << " in " << report.total_seconds << " s, "
              << report.file_bytes << " bytes\n";
    ptet::Request request;
    request.field_error.push_back({"wave", {0.05, true}});
    const ptet::Extraction cut = data->extract(request);
    std::cout << cut.mesh.tets.size() << " tets within " << cut.field_error.at(0) << " of the wave\n";
  } catch (const ptet::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
