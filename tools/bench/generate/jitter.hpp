// What the shapes have in common: numbers that look random and are the same everywhere, and progress.
#pragma once

#include "ptet/error.hpp"
#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"

#include <cstdint>
#include <string_view>

namespace ptet::bench {

/// Three numbers in [-1, 1), by a hash of `seed` (splitmix64). Without them the vertices of a lattice lie in planes and
/// on spheres by the thousand, which no mesh of a simulation does.
[[nodiscard]] inline Point jitter(std::uint64_t seed) {
  Point move;
  for (double& x : move) {
    seed += 0x9E3779B97F4A7C15;
    std::uint64_t z = seed;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9;
    z = (z ^ z >> 27) * 0x94D049BB133111EB;
    x = static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-52 - 1;
    seed ^= z;
  }
  return move;
}

inline void tell(const ProgressCallback& progress, std::string_view stage, std::uint64_t done, std::uint64_t total) {
  if (progress && !progress({stage, done, total})) throw Error(ErrorCode::kCancelled, "interrupted");
}

} // namespace ptet::bench
