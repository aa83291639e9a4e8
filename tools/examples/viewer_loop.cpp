// What a viewer does each frame: a mesh of as many tets as the machine can afford, fine where the camera looks.
//
//   viewer_loop FILE.ptet
#include <algorithm>
#include <cmath>
#include <iostream>

#include <ptet/dataset.hpp>

namespace {

constexpr int kFrames = 60;
constexpr double kSecondsPerFrame = 1.0 / 60;

/// Where the camera looks in this frame: it goes round the middle of the domain.
ptet::Point looked_at(const ptet::DatasetInfo& info, int frame) {
  const double angle_rad = 2 * 3.14159265358979 * frame / kFrames;
  ptet::Point at{};
  for (std::size_t i = 0; i < 3; ++i)
    at[i] = (info.box_min[i] + info.box_max[i]) / 2;
  at[0] += std::cos(angle_rad) * (info.box_max[0] - info.box_min[0]) / 3;
  at[1] += std::sin(angle_rad) * (info.box_max[1] - info.box_min[1]) / 3;
  return at;
}

/// More when there was time to spare, less at once when there was not.
std::uint64_t next_budget(std::uint64_t budget, double seconds, const ptet::DatasetInfo& info) {
  const double factor = seconds > kSecondsPerFrame ? 0.7 : seconds < kSecondsPerFrame / 2 ? 1.2 : 1;
  return std::clamp(static_cast<std::uint64_t>(static_cast<double>(budget) * factor), info.base_tets, info.tets);
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    const auto data = ptet::Dataset::open(argv[1]);
    const ptet::DatasetInfo& info = data->info();
    std::uint64_t budget = info.tets / 10;
    for (int frame = 0; frame < kFrames; ++frame) {
      ptet::Request request;
      request.focus.push_back(ptet::Sphere{looked_at(info, frame), 0.05 * info.diagonal});
      request.max_tets = budget;
      const ptet::Extraction cut = data->extract(request); // conforming; draw cut.mesh or cut.boundary_faces
      if (frame % 10 == 0)
        std::cout << "frame " << frame << ": " << cut.mesh.tets.size() << " tets of " << budget << ", "
                  << cut.seconds * 1000 << " ms, limited by " << name_of(cut.limited_by) << '\n';
      budget = next_budget(budget, cut.seconds, info);
    }
  } catch (const ptet::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
