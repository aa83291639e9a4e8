// What a viewer does each frame: a mesh of as many tets as the machine can draw, fine where the camera looks, made from
// the last one by what differs; only what changed goes to the graphics card.
//
//   viewer_loop FILE.ptet
#include <cmath>
#include <iostream>

#include <ptet/session.hpp>

namespace {

constexpr int kFrames = 60;

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
      request.focus.push_back({ptet::Sphere{looked_at(info, frame), 0.05 * info.diagonal}});
      request.max_tets = info.tets / 4;
      request.max_milliseconds = 8; // what is not done by then the next frame does
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
