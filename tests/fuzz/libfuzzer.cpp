// clang's libFuzzer over the target that the environment variable PTET_FUZZ_TARGET names.
#include "fuzz/targets.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most_bytes);

namespace {

using namespace ptet::fuzz;

const Target& target() {
  static const Target& chosen = []() -> const Target& {
    const char* const name = std::getenv("PTET_FUZZ_TARGET");
    const Target* const found = name == nullptr ? nullptr : find_target(name);
    if (found == nullptr) {
      std::fprintf(stderr, "PTET_FUZZ_TARGET names no target\n");
      std::exit(2);
    }
    return *found;
  }();
  return chosen;
}

/// libFuzzer's own mutations, in place or growing.
void change(Bytes& bytes, std::size_t most_bytes) {
  const std::size_t size = bytes.size();
  bytes.resize(std::max<std::size_t>({most_bytes, size, 1}));
  bytes.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(bytes.data()), size, bytes.size()));
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  target().run(std::as_bytes(std::span(data, size)));
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most_bytes,
                                               unsigned seed) {
  if (target().mutate == nullptr) return LLVMFuzzerMutate(data, size, most_bytes);
  const Input old = std::as_bytes(std::span(data, size));
  Bytes bytes(old.begin(), old.end());
  Mutator mutator{change, std::minstd_rand(seed)};
  target().mutate(bytes, most_bytes, mutator);
  if (bytes.size() > most_bytes) return LLVMFuzzerMutate(data, size, most_bytes);
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<std::byte*>(data));
  return bytes.size();
}
