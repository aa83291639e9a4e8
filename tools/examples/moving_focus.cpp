// A sphere of full resolution moves through a coarse mesh; the ids of the file say which vertices a viewer has already.
//
//   moving_focus FILE.ptet
#include <algorithm>
#include <iostream>
#include <iterator>

#include <ptet/dataset.hpp>

namespace {

constexpr int kSteps = 10;

/// From one corner of the domain's box to the opposite one.
ptet::Point on_diagonal(const ptet::DatasetInfo& info, double part) {
  ptet::Point at{};
  for (std::size_t i = 0; i < 3; ++i)
    at[i] = info.box_min[i] + part * (info.box_max[i] - info.box_min[i]);
  return at;
}

/// How many of the vertices were there before. Both lists ascend.
std::size_t kept(const std::vector<ptet::VertexId>& before, const std::vector<ptet::VertexId>& now) {
  std::vector<ptet::VertexId> both;
  std::set_intersection(before.begin(), before.end(), now.begin(), now.end(), std::back_inserter(both));
  return both.size();
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    const auto data = ptet::Dataset::open(argv[1]);
    const ptet::DatasetInfo& info = data->info();
    std::vector<ptet::VertexId> before;
    for (int step = 0; step <= kSteps; ++step) {
      ptet::Request request;
      request.field_error.push_back({"", {0.1, true}}); // everywhere: 10% of the range of every field
      request.focus.push_back(ptet::Sphere{on_diagonal(info, double(step) / kSteps), 0.1 * info.diagonal});
      const ptet::Extraction cut = data->extract(request);
      std::cout << "step " << step << ": " << cut.mesh.tets.size() << " tets, " << cut.vertex_in_file.size()
                << " vertices, of which " << kept(before, cut.vertex_in_file) << " were there before, "
                << cut.bytes_read << " bytes read\n";
      before = cut.vertex_in_file;
    }
  } catch (const ptet::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
