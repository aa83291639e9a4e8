// What a viewer does each frame: a mesh of as many tets as the machine can draw, sharp where the camera sees it, made
// from the last one by what differs; only what changed goes to the graphics card.
//
//   viewer_loop FILE.ptet
#include <cmath>
#include <iostream>

#include <ptet/session.hpp>

namespace {

constexpr int kFrames = 60;

/// What the camera sees in this frame: it goes round the domain, and looks at the middle of it.
ptet::View seen(const ptet::DatasetInfo& info, int frame) {
  const double angle_rad = 2 * 3.14159265358979 * frame / kFrames;
  ptet::View view;
  view.direction = {-std::cos(angle_rad), -std::sin(angle_rad), -0.5};
  view.up = {0, 0, 1};
  for (std::size_t i = 0; i < 3; ++i)
    view.eye[i] = (info.box_min[i] + info.box_max[i]) / 2 - 0.5 * info.diagonal * view.direction[i];
  return view;
}

/// Stands for the graphics card's copy of the tets.
void upload(std::vector<std::array<std::uint32_t, 4>>& copy, const ptet::Session& session,
            const ptet::SessionUpdate& update) {
  copy.resize(session.tets().size());
  for (const std::uint32_t slot : update.changed_tets)
    copy[slot] = session.tets()[slot];
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    const auto data = ptet::Dataset::open(argv[1]);
    const ptet::DatasetInfo& info = data->info();
    ptet::Session session(data);
    std::vector<std::array<std::uint32_t, 4>> on_card;
    for (int frame = 0; frame < kFrames; ++frame) {
      ptet::Request request;
      request.view = seen(info, frame);                  // to a pixel,
      request.field_error.push_back({"", {1e-3, true}}); // and so in its fields, as far as the tets go:
      request.max_tets = info.tets / 4;
      request.max_milliseconds = 8; // for splits and collapses: the next frame does the rest
      const ptet::SessionUpdate& update = session.update(request);
      upload(on_card, session, update);
      if (frame % 10 == 0)
        std::cout << "frame " << frame << ": " << update.tets << " tets, " << update.changed_tets.size()
                  << " slots changed, " << update.seconds * 1000 << " ms, limited by " << name_of(update.limited_by)
                  << '\n';
    }
  } catch (const ptet::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
