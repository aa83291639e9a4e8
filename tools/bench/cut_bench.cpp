// How fast a file that is in memory already gives meshes: cuts by error, by size and by focus, in tets a second; and
// how fast it is decoded.
//
//   cut_bench FILE.ptet [--benchmark_...]
#include "ptet/dataset.hpp"
#include "ptet/error.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

namespace {

using ptet::Dataset;
using ptet::Request;

Request within_field_error(double fraction) {
  Request request;
  request.field_error.push_back({"", {fraction, true}});
  return request;
}

Request of_vertices(const Dataset& data, double fraction) {
  Request request;
  request.max_vertices = static_cast<std::uint64_t>(fraction * static_cast<double>(data.info().vertices));
  return request;
}

/// A box in the middle, of `fraction` of the diagonal.
Request at_focus(const Dataset& data, double fraction) {
  Request request;
  ptet::Box box;
  for (std::size_t i = 0; i < 3; ++i) {
    const double middle = (data.info().box_min[i] + data.info().box_max[i]) / 2;
    const double half = fraction * (data.info().box_max[i] - data.info().box_min[i]) / 2;
    box.min[i] = middle - half;
    box.max[i] = middle + half;
  }
  request.focus.push_back({box, {0, true}, {}});
  return request;
}

void add(const std::string& name, const std::shared_ptr<const Dataset>& data, const Request& request) {
  benchmark::RegisterBenchmark(name.c_str(), [data, request](benchmark::State& state) {
    std::int64_t tets = 0;
    for (auto _ : state) {
      const ptet::Extraction extraction = data->extract(request);
      tets = static_cast<std::int64_t>(extraction.mesh.tets.size());
      benchmark::DoNotOptimize(extraction.mesh.tets.data());
    }
    state.counters["tets"] = static_cast<double>(tets);
    state.SetItemsProcessed(tets * static_cast<std::int64_t>(state.iterations()));
  })->Unit(benchmark::kMillisecond);
}

std::vector<std::byte> bytes_of(const char* path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// From the bytes of the file to the mesh at full resolution.
void add_decoding(const char* path) {
  benchmark::RegisterBenchmark("decode the whole file",
                               [bytes = bytes_of(path)](benchmark::State& state) {
                                 std::int64_t tets = 0;
                                 for (auto _ : state) {
                                   const ptet::Extraction extraction = Dataset::open_memory(bytes)->extract({});
                                   tets = static_cast<std::int64_t>(extraction.mesh.tets.size());
                                   benchmark::DoNotOptimize(extraction.mesh.tets.data());
                                 }
                                 state.SetItemsProcessed(tets * static_cast<std::int64_t>(state.iterations()));
                               })
      ->Unit(benchmark::kMillisecond)
      ->MeasureProcessCPUTime();
}

} // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (argc != 2) {
    std::fprintf(stderr, "usage: cut_bench FILE.ptet [--benchmark_...]\n");
    return 2;
  }
  try {
    const auto data = Dataset::open(argv[1]);
    (void)data->extract({}); // every block is in memory from here on
    add("whole mesh", data, {});
    add("field error 0.1%", data, within_field_error(0.001));
    add("field error 1%", data, within_field_error(0.01));
    add("field error 10%", data, within_field_error(0.1));
    add("10% of the vertices", data, of_vertices(*data, 0.1));
    add("focus box, 20% of each side", data, at_focus(*data, 0.2));
    add_decoding(argv[1]);
    benchmark::RunSpecifiedBenchmarks();
  } catch (const ptet::Error& error) {
    std::fprintf(stderr, "cut_bench: %s\n", error.what());
    return 1;
  }
  return 0;
}
