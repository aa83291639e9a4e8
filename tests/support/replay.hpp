// Plays a record stream backwards through a Refinement, with the oracle that a writer has: it knows what the region
// is. Numbering as in a file: kept vertices ascending, then the removed ones, last collapse first.
#pragma once

#include "ptet/mesh.hpp"
#include "record/refinement.hpp"
#include "record/stream.hpp"
#include "support/versions.hpp"

#include <vector>

namespace ptet::test {

struct Replay {
  Refinement refinement;
  std::vector<VertexId> file_id;     ///< of each vertex of the mesh
  std::vector<VertexId> original_id; ///< of each vertex of the file
  Versions all;                      ///< of the stream
  /// For each record of the refinement its place in the stream: size() - 1 - r.
  [[nodiscard]] std::size_t in_stream(RecordId r) const { return refinement.record_count() - 1 - r.index(); }
};

/// Starts from the base mesh of the stream, no record applied.
[[nodiscard]] Replay start_replay(const TetMesh& mesh, const RecordStream& stream);
/// Applies record `r`, whose parents are applied. Throws std::logic_error when what it makes is not F(r).
void apply(Replay& replay, const RecordStream& stream, RecordId r);
/// Records that consumed a version in C(r), found in the stream alone.
[[nodiscard]] std::vector<std::vector<RecordId>> parents_in_stream(const RecordStream& stream);
/// The versions present, as tets in the mesh's own numbering, each sorted keeping its orientation; ascending.
[[nodiscard]] std::vector<Tet> present(const Replay& replay);

} // namespace ptet::test
