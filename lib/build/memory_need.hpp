// How much memory a build will take, from what is known before it takes it; and the limit that it keeps to.
//
//   prepare     the mesh given, its copy that is examined, the table of its faces
//   collapse    the prepared mesh, slots and stars, quadrics, candidates; the records as they come; where errors are
//               measured the original's topology, besides what each thread measures with
//   write       the records, and the refinement that is coded beside them
//
// Each is a sum over what the phase holds, counted as the structures are laid out, with the numbers of versions and
// star entries that builds of meshes of all kinds have come to. It is meant as an upper bound that is not far off:
// 1 to 1.4 times what was measured.
#pragma once

#include "mesh/prepare.hpp"
#include "ptet/build.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace ptet::build {

struct BuildCounts {
  std::uint64_t vertices = 0;
  std::uint64_t tets = 0;
  std::uint64_t boundary_faces = 0; ///< 0 before they are known
  std::uint64_t row_bytes = 0;      ///< of a vertex: position and arrays as they are stored
  std::uint64_t fields = 0;         ///< governing
  std::uint64_t channels = 0;       ///< their components
  std::uint64_t contexts = 0;       ///< of the file's range coder
};
[[nodiscard]] BuildCounts count(const TetMesh& mesh, const BuildOptions& options);
[[nodiscard]] BuildCounts count(const PreparedMesh& prepared, const BuildOptions& options);

/// Bytes, of each phase.
struct MemoryNeed {
  std::uint64_t prepare = 0;
  std::uint64_t collapse = 0;
  std::uint64_t write = 0;
  [[nodiscard]] std::uint64_t most() const;
};
[[nodiscard]] MemoryNeed memory_need(const BuildCounts& counts, const BuildOptions& options);

/// Holds a build to BuildOptions::memory_limit, where there is one.
class MemoryWatch {
public:
  /// When nothing of the build is there yet but `mesh`: all else that is resident is somebody else's and stays.
  MemoryWatch(const TetMesh& mesh, const BuildOptions& options);

  /// What is foreseen for such a mesh, of the whole process; at least so much before its boundary is known.
  /// Throws Error(kLimit) when it passes the limit, with what would help.
  std::uint64_t check(const BuildCounts& counts) const;

private:
  const BuildOptions& options_;
  std::uint64_t others_ = 0; ///< bytes that are not of the build
};

/// Whether the process is so near the limit of `options` that the next round may pass it.
[[nodiscard]] bool near_memory_limit(const BuildOptions& options);
/// "1.23 GB": what is needed is rounded up, what there is down.
[[nodiscard]] std::string bytes_text(std::uint64_t needed);
[[nodiscard]] std::string limit_text(std::uint64_t limit);

} // namespace ptet::build
