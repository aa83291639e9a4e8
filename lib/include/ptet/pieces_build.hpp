// A build over pieces, step by step: for who collapses the pieces in several places, such as the ranks of MPI.
//
//   everywhere     PiecesBuild build(mesh, options);             the same mesh, options and program
//   anywhere       bytes[p] = build.decide(p);                   for every piece, in any order
//   in one place   build.write(path, bytes);                     the same file as build_file(mesh, path, options)
//   writes
#pragma once

#include "ptet/build.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace ptet {

class PiecesBuild {
public:
  /// Examines the mesh and cuts it in options.pieces pieces. Throws Error as build_file does.
  explicit PiecesBuild(TetMesh mesh, const BuildOptions& options = {}, const ProgressCallback& progress = {});
  ~PiecesBuild();
  PiecesBuild(const PiecesBuild&) = delete;
  PiecesBuild& operator=(const PiecesBuild&) = delete;

  [[nodiscard]] std::uint32_t piece_count() const;
  /// Collapses one piece (0 .. piece_count()-1) with its seams frozen, and returns what was decided: some 20 bytes a
  /// collapse, and 8 for each error of it. To be given to write() of this program, on a machine of the same kind; not
  /// for keeping. Same mesh, options and piece: same bytes.
  /// Memory for the piece is gone when it returns. Thread rule: const; uses options.threads threads.
  /// Throws Error: kBadArgument (no such piece), kCancelled, and as build_file does.
  [[nodiscard]] std::vector<std::byte> decide(std::uint32_t piece, const ProgressCallback& progress = {}) const;
  /// Worker threads from now on; as options.threads.
  void set_threads(unsigned threads);
  /// Makes the collapses of all pieces, goes on with what is left, and writes the file as build_file does. `decided`:
  /// by piece, what decide() returned there. To be called once: the mesh goes with it.
  /// Throws Error as build_file does; besides kBadArgument when something of `decided` is of another build, and
  /// kCorruptFile when it is damaged.
  BuildReport write(const std::string& path, std::vector<std::vector<std::byte>> decided,
                    const std::string& source_name = {}, const std::string& source_hash = {},
                    const ProgressCallback& progress = {});
  /// The same without a file.
  [[nodiscard]] std::vector<std::byte> write_memory(std::vector<std::vector<std::byte>> decided,
                                                    BuildReport* report = nullptr, const std::string& source_name = {},
                                                    const std::string& source_hash = {},
                                                    const ProgressCallback& progress = {});

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace ptet
