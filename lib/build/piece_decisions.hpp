// A build over pieces: what is collapsed in each piece by itself, and how that comes together.
//
//   first pass    decide   every piece, here or elsewhere, in any order: collapsed by a builder of its own, the rest of
//                          the mesh frozen, until a small part of what may move is left. What it decided is some bytes
//   second pass   merge    all that, by rounds: collapses of different pieces do not touch. Each piece is followed up
//                          to the same cost
//                 builder  makes the collapses again in the whole mesh, without searching, then goes on with the seams
//                          and all that is left
//
// So the same pieces make the same records, however the first pass was spread over threads or machines.
#pragma once

#include "build/checkpoint.hpp"
#include "build/field_samples.hpp"
#include "build/mesh_pieces.hpp"
#include "build/mesh_scales.hpp"
#include "ptet/build.hpp"
#include "record/stream.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace ptet::build {

/// Collapses that were decided in pieces of the mesh, in an order in which they can be made in it.
struct Decisions {
  /// What the pieces know: removed, target, round, the errors of fields, what is uncovered. The other tables are empty.
  RecordStream records;
  std::vector<std::uint32_t> piece; ///< by record
  /// Of the rounds that have records, in their order: the most that one of their collapses might cost.
  std::vector<double> round_cost;
  std::array<std::uint64_t, kCollapseStatusCount> collapses{}; ///< tries by CollapseStatus, over all pieces
  std::uint64_t simulations = 0;
  std::uint64_t exact_evaluations = 0;
};

class PieceDecisions {
public:
  /// Cuts `prepared` in options.pieces pieces. Both must outlive the object. Throws Error as build_records does.
  PieceDecisions(const PreparedMesh& prepared, const BuildOptions& options);

  [[nodiscard]] std::uint32_t piece_count() const { return pieces_.count(); }
  /// What is decided in a piece. `progress` sees the collapses in it.
  /// Thread rule: const; uses options.threads threads. Throws Error as build_records does.
  [[nodiscard]] std::vector<std::byte> decide(std::uint32_t piece, const ProgressCallback& progress) const;
  /// All together, but for the costliest. `decided`: by piece. Throws Error: kBadArgument when some are of another
  /// build, kCorruptFile when they are damaged.
  [[nodiscard]] Decisions merge(std::span<const std::vector<std::byte>> decided) const;

private:
  struct OfPiece;
  [[nodiscard]] std::vector<Sample> samples_in(const MeshPiece& piece) const;
  [[nodiscard]] OfPiece read(std::uint32_t piece, std::span<const std::byte> bytes) const;

  const PreparedMesh& prepared_;
  const BuildOptions& options_;
  MeshPieces pieces_;
  BuildIdentity identity_;
  std::vector<std::uint32_t> arrays_; ///< the governing ones
  MeshScales scales_;
  std::vector<Sample> samples_; ///< of the whole mesh, where the evaluation looks at samples
};

} // namespace ptet::build
