// How fast the desktop viewer follows: a sphere of 1% of the box's volume, the original inside it, moves through the
// domain in small steps over a coarse background. Counted are the cut, the polygons of what is shown, and putting them
// into VTK's structures: all of a frame but the drawing. One thread; a line for each case.
//
//   view_bench FILE.ptet [FRAMES [SIZE_OF_A_STEP]]     a step is a fraction of the sphere's diameter
#include "ptet/error.hpp"
#include "tools/view/scene.hpp"
#include "tools/view/to_vtk.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace ptet::view;

double processor_milliseconds() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

/// A closed path that bends through the middle of the vertices, where the mesh is finest.
class Path {
public:
  Path(const ptet::DatasetInfo& info, const ptet::TetMesh& mesh) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<double> x;
      for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
        x.push_back(mesh.position(ptet::VertexId{v})[axis]);
      middle_[axis] = quantile(x, 0.5);
      reach_[axis] = (info.box_max[axis] - info.box_min[axis]) / 2;
    }
  }
  /// `way`: mesh units from the start, about.
  [[nodiscard]] ptet::Point at(double way) const {
    const double turn = way / std::max({reach_[0], reach_[1], reach_[2]});
    const ptet::Point wave = {std::sin(turn), std::sin(1.3 * turn), std::sin(1.7 * turn)};
    ptet::Point p{};
    for (std::size_t i = 0; i < 3; ++i)
      p[i] = middle_[i] + 0.5 * wave[i] * reach_[i];
    return p;
  }

private:
  ptet::Point middle_{}, reach_{};
};

struct Case {
  const char* name;
  Show show;
  ColourKind colour = ColourKind::kField;
};

void follow(const Case& shown, const std::shared_ptr<const ptet::Dataset>& data, const Path& path, Settings settings,
            double isovalue, int frames, double step) {
  const ptet::DatasetInfo& info = data->info();
  double volume = 1;
  for (std::size_t i = 0; i < 3; ++i)
    volume *= info.box_max[i] - info.box_min[i];
  const double radius = std::cbrt(0.01 * volume * 3 / (4 * 3.14159265358979323846));
  settings.show = shown.show;
  settings.colour.kind = shown.colour;
  settings.isovalue = isovalue;
  settings.plane = {{0, -1, 0}, -path.at(0)[1]};
  Scene scene(data);
  std::vector<double> cut_and_geometry, upload, all, polygons, tets;
  for (int i = 0; i <= frames; ++i) {
    settings.focus = ptet::Sphere{path.at(i * 2 * radius * step), radius};
    const double begin = processor_milliseconds();
    const Frame& frame = scene.step(settings);
    const double made = processor_milliseconds();
    const auto surface = to_vtk(frame.polygons);
    const auto cells = to_vtk(frame.cells);
    const double end = processor_milliseconds();
    if (i == 0) continue; // from the base to the first mesh
    cut_and_geometry.push_back(made - begin);
    upload.push_back(end - made);
    all.push_back(end - begin);
    polygons.push_back(static_cast<double>(frame.polygons.count()));
    tets.push_back(static_cast<double>(frame.tets));
  }
  std::printf("  %-24s %8.2f %8.2f %8.2f %8.2f %8.2f %9.0f %9.0f\n", shown.name, quantile(cut_and_geometry, 0.5),
              quantile(upload, 0.5), quantile(all, 0.5), quantile(all, 0.99), quantile(all, 1), quantile(polygons, 0.5),
              quantile(tets, 0.5));
  (void)std::fflush(stdout);
}

void run(const std::string& file, int frames, double step) {
  const auto data = ptet::Dataset::open(file);
  const ptet::Extraction whole = data->extract({}); // every block is in memory from here on
  const ptet::DatasetInfo& info = data->info();
  const Path path(info, whole.mesh);
  std::vector<double> values;
  for (std::size_t v = 0; v < whole.mesh.vertex_count(); ++v)
    values.push_back(whole.mesh.point_arrays.front().value(v, 0));
  const double isovalue = quantile(values, 0.5);
  std::printf("%s: %llu tets; %d frames, processor milliseconds each\n", file.c_str(),
              static_cast<unsigned long long>(info.tets), frames);
  std::printf("  %-24s %8s %8s %8s %8s %8s %9s %9s\n", "shown", "step", "upload", "both", "99%", "most", "polygons",
              "tets");
  Settings vertices, error;
  vertices.max_vertices = info.vertices / 50;
  error.error = 0.02;
  for (const auto& [name, settings] : {std::pair{"2% of the vertices", vertices}, {"error 2%", error}}) {
    std::printf("background: %s\n", name);
    for (const Case& shown :
         {Case{"boundary surface", Show::kSurface}, Case{"cells cut open", Show::kCells}, Case{"slice", Show::kSlice},
          Case{"isosurface", Show::kIsosurface}, Case{"volume", Show::kVolume},
          Case{"surface, by error", Show::kSurface, ColourKind::kError},
          Case{"cells, by error", Show::kCells, ColourKind::kError},
          Case{"cells, by level", Show::kCells, ColourKind::kLevel},
          Case{"slice, by error", Show::kSlice, ColourKind::kError},
          Case{"volume, by error", Show::kVolume, ColourKind::kError}})
      follow(shown, data, path, settings, isovalue, frames, step);
  }
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: view_bench FILE.ptet [FRAMES [SIZE_OF_A_STEP]]\n");
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? std::max(1, std::atoi(argv[2])) : 200, argc > 3 ? std::atof(argv[3]) : 0.05);
  } catch (const ptet::Error& error) {
    std::fprintf(stderr, "view_bench: %s\n", error.what());
    return 1;
  }
  return 0;
}
