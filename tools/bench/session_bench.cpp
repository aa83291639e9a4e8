// How fast a session follows a viewer: a sphere of 1% of the volume, the original inside it, moves through the domain
// in small steps over a background of 5% of the vertices, or within an error bound. One thread; a line for each case.
//
//   session_bench FILE.ptet [UPDATES [SIZE_OF_A_STEP]]     a step is a fraction of the sphere's diameter
#include "ptet/error.hpp"
#include "ptet/session.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

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

/// Where the sphere is at a step: on a path that bends through the middle of the box.
ptet::Point position_at(const ptet::DatasetInfo& info, double way) {
  ptet::Point p{};
  const double turn = way / info.diagonal;
  const ptet::Point wave = {std::sin(2.1 * turn), std::sin(3.3 * turn + 1), std::sin(2.7 * turn + 2)};
  for (std::size_t i = 0; i < 3; ++i)
    p[i] = (info.box_min[i] + info.box_max[i]) / 2 + 0.35 * wave[i] * (info.box_max[i] - info.box_min[i]);
  return p;
}

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

void follow(const std::string& name, const std::shared_ptr<const Dataset>& data, Request request, int updates,
            double step) {
  const ptet::DatasetInfo& info = data->info();
  const double radius = radius_of(info, 0.01);
  Session session(data);
  std::vector<double> milliseconds, splits, collapses, changed, tets;
  for (int i = 0; i <= updates; ++i) {
    request.focus.assign(1, ptet::Sphere{position_at(info, i * 2 * radius * step), radius});
    const double begin = processor_milliseconds();
    const ptet::SessionUpdate& update = session.update(request);
    const double end = processor_milliseconds();
    if (i == 0) continue; // from the base to the first mesh
    milliseconds.push_back(end - begin);
    splits.push_back(static_cast<double>(update.splits));
    collapses.push_back(static_cast<double>(update.collapses));
    changed.push_back(static_cast<double>(update.changed_tets.size()));
    tets.push_back(static_cast<double>(update.tets));
  }
  std::printf("%-28s %8.2f %8.2f %8.2f %8.0f %8.0f %9.0f %9.0f\n", name.c_str(), quantile(milliseconds, 0.5),
              quantile(milliseconds, 0.99), quantile(milliseconds, 1), quantile(splits, 0.5), quantile(collapses, 0.5),
              quantile(changed, 0.5), quantile(tets, 0.5));
}

void run(const std::string& path, int updates, double step) {
  const double before = resident_bytes();
  const auto data = Dataset::open(path);
  {
    Session session(data);
    (void)session.update({}); // every block is in memory from here on
  }
  const ptet::DatasetInfo& info = data->info();
  double row_bytes = 3 * static_cast<double>(ptet::size_of(info.position_type));
  for (const ptet::FieldInfo& field : info.fields)
    row_bytes += static_cast<double>(ptet::size_of(field.type) * field.components);
  std::printf("%s: %llu vertices, %llu tets; in memory %.0f bytes a vertex beyond points and fields\n", path.c_str(),
              static_cast<unsigned long long>(info.vertices), static_cast<unsigned long long>(info.tets),
              (resident_bytes() - before) / static_cast<double>(info.vertices) - row_bytes);
  std::printf("%d updates, processor time in milliseconds; median changes\n", updates);
  std::printf("%-28s %8s %8s %8s %8s %8s %9s %9s\n", "background", "median", "99%", "most", "splits", "collaps.",
              "changed", "tets");
  Request none;
  follow("none", data, none, updates, step);
  Request vertices;
  vertices.max_vertices = info.vertices / 20;
  follow("5% of the vertices", data, vertices, updates, step);
  // Room for the sphere and as much again: what the sphere does not take goes to the rest.
  Request tets;
  tets.max_tets = info.tets / 10;
  follow("10% of the tets, focus in it", data, tets, updates, step);
  Request bound;
  bound.field_error.push_back({"", {0.05, true}});
  follow("field error 5%", data, bound, updates, step);

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
