// Checks of .ptet files against the meshes and records they were made from.
#pragma once

#include "formats/ptet/reader.hpp"
#include "ptet/mesh.hpp"
#include "record/stream.hpp"

#include <cstdint>
#include <vector>

namespace ptet::test {

/// Encodes, reads back and compares: every vertex with all its values, every tet with its orientation, the errors of
/// every record (never below what they were, the monotone ones a closed order), squared ones too, and its parents.
/// Fails the running test otherwise.
void check_round_trip(const TetMesh& mesh, const RecordStream& records);
/// The blocks that must be loaded together with `blocks`, these included; ascending.
[[nodiscard]] std::vector<std::uint32_t> closed_under_needs(const file::Reader& reader,
                                                            std::vector<std::uint32_t> blocks);
/// The records applied in `some` are the same as in `all`: values, errors, tets, parents.
void check_same_records(const file::Reader& reader, const file::Content& all, const file::Content& some);
/// The mesh of everything that is loaded, vertices in file order, used or not.
[[nodiscard]] TetMesh present_mesh(const file::Content& content);

} // namespace ptet::test
