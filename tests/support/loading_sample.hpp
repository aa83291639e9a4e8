// A file to be read in part, the answers that all of it gives, and what must hold of every answer that part of it
// gives: a closed cut, conforming, with errors that are true.
#pragma once

#include "formats/ptet/reader.hpp"
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"
#include "record/stream.hpp"
#include "support/mesh_checks.hpp"

#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

namespace ptet::test {

struct LoadingSample {
  TetMesh mesh;
  RecordStream stream;
  std::vector<std::byte> bytes; ///< of the file
  MeshFacts facts;
  std::uint32_t base_vertices = 0;
  std::vector<file::BlockInfo> blocks;
  std::uint64_t decoded_bytes = 0;
  std::vector<VertexId> to_original; ///< by vertex of the file
  std::vector<Request> requests;
  std::vector<Extraction> answers; ///< of the whole file, one a request
};

/// Made once, in some seconds.
[[nodiscard]] const LoadingSample& sample();

/// The same of a bar so long that its ends are in blocks of their own: what one end needs leaves no room for what the
/// other does. The last two requests are for the ends.
[[nodiscard]] const LoadingSample& long_sample();

/// Every field within `bound` of its range.
[[nodiscard]] Request error_request(double bound);

/// Points, fields, tets, ids and errors, all the same.
[[nodiscard]] bool same_mesh(const Extraction& a, const Extraction& b);

/// By block of the sample: 1 for those that are left when those of `lost` and all that need them, directly or not, are
/// gone.
[[nodiscard]] std::vector<char> left_without(const std::set<std::uint32_t>& lost);

/// Checks that the mesh is that of a closed cut of the sample's records, sound, and that its errors are no less than
/// theirs that made its tets.
void check_sound(const Extraction& extraction, const LoadingSample& of = sample());

/// Checks that each tet of the session's mesh was made by the record that replaying all records finds, or by one that
/// is not there. Returns how many of these there are.
[[nodiscard]] std::size_t check_origins(const Session& session);

/// Checks an answer to the sample's request `i` where the whole of `left` can be had and nothing else: what bounds ask
/// for and is there; in a focus not more, since what is there only for the sake of records that are not is not wanted.
void check_answer_without(std::size_t i, const Extraction& extraction, const std::vector<char>& left);

} // namespace ptet::test
