// What is fuzzed: functions that take any bytes and come back. Whatever must hold of the result is checked inside;
// a broken promise ends the program.
//
//   libfuzzer.cpp   runs one target for as long as asked, with clang's libFuzzer (run.sh)
//   replay.cpp      runs a target over inputs kept in corpus/, and over its seeds, under any compiler
#pragma once

#include "fuzz/mutate_file.hpp"

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace ptet::fuzz {

struct Target {
  std::string_view name;
  void (*run)(Input input);
  /// Inputs to begin with, made by the writer as it is now.
  std::vector<Bytes> (*seeds)();
  /// None: any change of bytes is as good as another.
  void (*mutate)(Bytes& input, std::size_t most_bytes, Mutator& mutator) = nullptr;
};

[[nodiscard]] std::span<const Target> targets();
/// The target of that name, or nullptr.
[[nodiscard]] const Target* find_target(std::string_view name);

// The .ptet reader: open, decode everything, extract the original.
void run_reader(Input input);
// The same after a mutation that leaves all hashes right.
void mutate_decoded(Bytes& input, std::size_t most_bytes, Mutator& mutator);
// The manifest and its archive.
void run_manifest(Input input);
std::vector<Bytes> manifest_seeds();
// One block in an otherwise sound file. The first byte chooses file and block.
void run_block(Input input);
std::vector<Bytes> block_seeds();
// Any requests to extract() and a session of any file: a byte n, n bytes of requests, the file.
void run_cut(Input input);
std::vector<Bytes> cut_seeds();
void mutate_cut(Bytes& input, std::size_t most_bytes, Mutator& mutator);
// Error bounds, asked of a session one after the other, against the cut found record by record. Input as for cuts.
void run_differential(Input input);
// The annotated dump.
void run_dump(Input input);
// A mesh file, read and prepared for a build.
void run_import(Input input);
std::vector<Bytes> import_seeds();

} // namespace ptet::fuzz
