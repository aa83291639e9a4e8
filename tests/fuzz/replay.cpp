// Runs a target over inputs, under any compiler:
//
//   fuzz_replay --list                        the targets' names
//   fuzz_replay --seeds TARGET FOLDER         writes the target's seeds into the folder
//   fuzz_replay TARGET MUTATIONS [PATH...]    runs it over its seeds, over the files (of the folders), and over so many
//                                             random mutations of all these, the same in every run
#include "fuzz/targets.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

using namespace ptet::fuzz;

namespace {

constexpr std::size_t kMostBytes = 65536;

Bytes read(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + path.string());
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const Input bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::vector<Bytes> read_all(std::span<char*> paths) {
  std::vector<std::filesystem::path> files;
  for (const char* path : paths) {
    if (std::filesystem::is_directory(path)) {
      for (const auto& entry : std::filesystem::directory_iterator(path))
        files.push_back(entry.path());
    } else {
      files.emplace_back(path);
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<Bytes> inputs;
  inputs.reserve(files.size());
  for (const std::filesystem::path& file : files)
    inputs.push_back(read(file));
  return inputs;
}

/// Runs, and leaves the input behind when the run does not come back.
void run(const Target& target, const Bytes& input) {
  const char* const last = std::getenv("PTET_FUZZ_LAST");
  if (last != nullptr)
    std::ofstream(last, std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
  target.run(input);
}

int replay(const Target& target, std::size_t mutations, std::span<char*> paths) {
  std::vector<Bytes> inputs = target.seeds();
  const std::size_t seeds = inputs.size();
  for (Bytes& input : read_all(paths))
    inputs.push_back(std::move(input));
  for (const Bytes& input : inputs)
    run(target, input);
  Mutator mutator;
  mutator.change = [&](Bytes& bytes, std::size_t most) { change_bytes(bytes, most, mutator.random); };
  for (std::size_t i = 0; i < mutations; ++i) {
    Bytes input = inputs[i % inputs.size()];
    if (target.mutate != nullptr) {
      target.mutate(input, kMostBytes, mutator);
    } else {
      mutator.change(input, kMostBytes);
    }
    run(target, input);
  }
  std::printf("%s: %zu seeds, %zu inputs, %zu mutations\n", std::string(target.name).c_str(), seeds,
              inputs.size() - seeds, mutations);
  return 0;
}

int write_seeds(const Target& target, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::size_t number = 0;
  for (const Bytes& seed : target.seeds())
    std::ofstream(folder / ("seed" + std::to_string(number++)), std::ios::binary)
        .write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
  return 0;
}

int usage() {
  std::fprintf(stderr, "fuzz_replay --list | --seeds TARGET FOLDER | TARGET MUTATIONS [PATH...]\n");
  return 2;
}

} // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--list") == 0) {
    for (const Target& target : targets())
      std::printf("%s\n", std::string(target.name).c_str());
    return 0;
  }
  if (argc < 3) return usage();
  const bool wants_seeds = std::strcmp(argv[1], "--seeds") == 0;
  const Target* const target = find_target(argv[wants_seeds ? 2 : 1]);
  if (target == nullptr || (wants_seeds && argc != 4)) return usage();
  try {
    if (wants_seeds) return write_seeds(*target, argv[3]);
    return replay(*target, std::stoul(argv[2]), {argv + 3, static_cast<std::size_t>(argc - 3)});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
  }
}
