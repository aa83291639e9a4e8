// The processes that build together, where mpirun (or another starter of MPI programs) started the program: they share
// the pieces of a mesh. Every one of them reads the mesh; what was decided in the pieces comes together at the first.
//
//   rank 0   pieces 0, R, 2R, ...     ]
//   rank 1   pieces 1, R + 1, ...     ]-> all decisions at rank 0, which makes the file and speaks; the others are done
//   rank 2   pieces 2, R + 2, ...     ]
//
// What goes wrong anywhere is said once, by rank 0, with its exit code: the others tell rank 0 and wait for the end.
#pragma once

#include "ptet/pieces_build.hpp"
#include "ptet/progress.hpp"

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace ptet::cli {

/// How many processes were started together, and which of them this is, by what the starter says in the environment.
struct StartedProcesses {
  int count = 1;
  int rank = 0;
};
[[nodiscard]] StartedProcesses started_processes();

/// Whether this program can build together with others: it was built with MPI.
[[nodiscard]] bool can_meet();

/// Runs a command that all processes work on together. In one that is not the first nothing is printed, and what goes
/// wrong is kept until the first process has ended, or is told to it; returns the exit code.
int as_a_rank(const std::function<int()>& run);

/// From a process that failed to the first: its exit code and what it would have printed. Does nothing where they have
/// not met.
void tell_first(int exit_code, const std::string& message);

/// What PiecesBuild::decide() returns.
using Decided = std::vector<std::byte>;

class Ranks {
public:
  /// Meets the others; alone where nobody started several processes. Throws Error(kBadArgument) where somebody did, but
  /// the program was built without MPI. One object at a time.
  Ranks();
  /// Parts from them, unless an exception is on its way.
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] int count() const;
  [[nodiscard]] int rank() const;
  [[nodiscard]] bool is_first() const { return rank() == 0; }
  /// How many worker threads the first process may have when the others on its machine are done: with `threads` (0: one
  /// for each core) in each process before. To be asked after decide().
  [[nodiscard]] unsigned threads_afterwards(unsigned threads) const;
  /// `progress`, which also throws what went wrong elsewhere.
  [[nodiscard]] ProgressCallback watching(ProgressCallback progress) const;
  /// Collapses this process's share of the pieces. At the first process returns what was decided in all of them, by
  /// piece; elsewhere nothing.
  [[nodiscard]] std::vector<Decided> decide(const PiecesBuild& pieces, const ProgressCallback& progress);

private:
  /// `own`: of this process's pieces, in their order. At the first process returns all; then the processes have parted.
  std::vector<Decided> gather(std::vector<Decided> own, std::uint32_t piece_count);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace ptet::cli
