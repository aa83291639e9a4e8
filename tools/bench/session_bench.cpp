// How fast a session follows a viewer: a sphere of 1% of the volume, the original inside it, moves through the domain
// in small steps over a background of 5% of the vertices, or within an error bound, once with a falloff that lets
// errors grow from nothing at the sphere over half of the diagonal; or an eye goes around it, and errors are bounded in
// pixels, with and without a budget. One thread; a line for each case.
//
//   session_bench FILE.ptet [UPDATES [SIZE_OF_A_STEP]]     a step is a fraction of the sphere's diameter; the eye turns
//                                                          by a fifth of that fraction, in radians
#include "ptet/error.hpp"
#include "ptet/session.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <malloc.h>

namespace {

using ptet::Dataset;
using ptet::Request;
using ptet::Session;

double processor_milliseconds() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0;
  statm >> pages >> pages;
  return pages * 4096;
}

/// Of the bounding box's volume; 1% of the domain's where the domain fills it.
double radius_of(const ptet::DatasetInfo& info, double fraction) {
  double volume = 1;
  for (std::size_t i = 0; i < 3; ++i)
    volume *= info.box_max[i] - info.box_min[i];
  return std::cbrt(fraction * volume * 3 / (4 * 3.14159265358979323846));
}

/// A closed path that bends through the box and, where the mesh is finest, comes by again and again.
class Path {
public:
  explicit Path(const Session& session) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<double> x;
      for (std::uint32_t slot = 0; slot < session.vertex_in_file().size(); ++slot)
        if (!session.vertex_in_file()[slot].is_none())
          x.push_back(session.positions().value(slot, static_cast<unsigned>(axis)));
      std::sort(x.begin(), x.end());
      middle_[axis] = x[x.size() / 2];
      reach_[axis] = (x.back() - x.front()) / 2;
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

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

/// Puts into the request where the viewer is at a step.
using Motion = std::function<void(Request&, int)>;

Motion moving_sphere(const ptet::DatasetInfo& info, const Path& path, double step) {
  return [&path, step, radius = radius_of(info, 0.01)](Request& request, int i) {
    request.focus.assign(1, {ptet::Sphere{path.at(i * 2 * radius * step), radius}});
  };
}

Motion with_falloff(const Motion& move) {
  return [move](Request& request, int i) {
    move(request, i);
    request.focus.front().falloff = ptet::Bound{0.5, true};
  };
}

Motion circling_eye(const ptet::DatasetInfo& info, double step) {
  return [&info, step](Request& request, int i) {
    const double turn = 0.2 * step * i;
    const ptet::Point from_middle = {0.7 * info.diagonal * std::cos(turn), 0.7 * info.diagonal * std::sin(turn),
                                     0.3 * info.diagonal};
    ptet::View view;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      view.eye[axis] = (info.box_min[axis] + info.box_max[axis]) / 2 + from_middle[axis];
      view.direction[axis] = -from_middle[axis];
    }
    view.max_pixels = 1;
    request.view = view;
  };
}

void follow(const std::string& name, const std::shared_ptr<const Dataset>& data, const Motion& move, Request request,
            int updates) {
  Session session(data);
  std::vector<double> milliseconds, changes, changed, tets;
  for (int i = 0; i <= updates; ++i) {
    move(request, i);
    const double begin = processor_milliseconds();
    const ptet::SessionUpdate& update = session.update(request);
    const double end = processor_milliseconds();
    if (i == 0) continue; // from the base to the first mesh
    milliseconds.push_back(end - begin);
    changes.push_back(static_cast<double>(update.splits + update.collapses));
    changed.push_back(static_cast<double>(update.changed_tets.size()));
    tets.push_back(static_cast<double>(update.tets));
  }
  std::printf("%-28s %8.2f %8.2f %8.2f %8.0f %8.0f %9.0f %9.0f %9.0f\n", name.c_str(), quantile(milliseconds, 0.5),
              quantile(milliseconds, 0.99), quantile(milliseconds, 1), quantile(changes, 0.5), quantile(changes, 0.99),
              quantile(changed, 0.5), quantile(changed, 0.99), quantile(tets, 0.5));
}

void run(const std::string& file, int updates, double step) {
  const double before = resident_bytes();
  const auto data = Dataset::open(file);
  auto whole = std::make_unique<Session>(data);
  (void)whole->update({}); // every block is in memory from here on
  const Path path(*whole);
  whole.reset();
  malloc_trim(0);
  const ptet::DatasetInfo& info = data->info();
  double row_bytes = 3 * static_cast<double>(ptet::size_of(info.position_type));
  for (const ptet::FieldInfo& field : info.fields)
    row_bytes += static_cast<double>(ptet::size_of(field.type) * field.components);
  std::printf("%s: %llu vertices, %llu tets; in memory %.0f bytes a vertex beyond points and fields\n", file.c_str(),
              static_cast<unsigned long long>(info.vertices), static_cast<unsigned long long>(info.tets),
              (resident_bytes() - before) / static_cast<double>(info.vertices) - row_bytes);
  std::printf("%d updates; processor time in milliseconds, splits and collapses, tet slots changed, tets\n", updates);
  std::printf("%-28s %8s %8s %8s %8s %8s %9s %9s %9s\n", "background", "median", "99%", "most", "median", "99%",
              "median", "99%", "median");
  const Motion sphere = moving_sphere(info, path, step), eye = circling_eye(info, step);
  Request none;
  follow("none", data, sphere, none, updates);
  Request vertices;
  vertices.max_vertices = info.vertices / 20;
  follow("5% of the vertices", data, sphere, vertices, updates);
  // Room for the sphere and as much again: what the sphere does not take goes to the rest.
  Request tets;
  tets.max_tets = info.tets / 10;
  follow("10% of the tets, focus in it", data, sphere, tets, updates);
  Request bound;
  bound.field_error.push_back({"", {0.05, true}});
  follow("field error 5%", data, sphere, bound, updates);
  follow("field error 5%, a falloff", data, with_falloff(sphere), bound, updates);

  follow("view, a pixel", data, eye, none, updates);
  tets.max_tets = info.tets * 8 / 100;
  follow("view, 8% of the tets", data, eye, tets, updates);

  std::vector<double> fresh;
  for (int i = 0; i < 15; ++i) {
    const double begin = processor_milliseconds();
    const ptet::Extraction extraction = data->extract(bound);
    fresh.push_back(processor_milliseconds() - begin);
    if (i == 0) std::printf("fresh cut, field error 5%%: %zu tets", extraction.mesh.tets.size());
  }
  std::printf(", median %.2f ms\n", quantile(fresh, 0.5));
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: session_bench FILE.ptet [UPDATES [SIZE_OF_A_STEP]]\n");
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? std::max(1, std::atoi(argv[2])) : 300, argc > 3 ? std::atof(argv[3]) : 0.05);
  } catch (const ptet::Error& error) {
    std::fprintf(stderr, "session_bench: %s\n", error.what());
    return 1;
  }
  return 0;
}
