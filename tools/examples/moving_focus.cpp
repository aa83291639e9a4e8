// A sphere of full resolution moves through a coarse mesh: each step costs what it changes.
//
//   moving_focus FILE.ptet
#include <iostream>

#include <ptet/session.hpp>

namespace {

constexpr int kSteps = 10;

/// From one corner of the domain's box to the opposite one.
ptet::Point on_diagonal(const ptet::DatasetInfo& info, double part) {
  ptet::Point at{};
  for (std::size_t i = 0; i < 3; ++i)
    at[i] = info.box_min[i] + part * (info.box_max[i] - info.box_min[i]);
  return at;
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    const auto data = ptet::Dataset::open(argv[1]);
    const ptet::DatasetInfo& info = data->info();
    ptet::Session session(data);
    for (int step = 0; step <= kSteps; ++step) {
      ptet::Request request;
      request.field_error.push_back({"", {0.1, true}}); // everywhere: 10% of the range of every field
      request.focus.push_back({ptet::Sphere{on_diagonal(info, double(step) / kSteps), 0.1 * info.diagonal}});
      const ptet::SessionUpdate& update = session.update(request);
      std::cout << "step " << step << ": " << update.tets << " tets, " << update.vertices << " vertices; "
                << update.splits << " splits, " << update.collapses << " collapses in " << update.seconds * 1000
                << " ms\n";
    }
    // The same mesh as one request would have given, whatever came before.
    const ptet::Extraction mesh = session.extraction();
    std::cout << "at last " << mesh.mesh.tets.size() << " tets with " << mesh.boundary_faces.size()
              << " boundary faces\n";
  } catch (const ptet::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
