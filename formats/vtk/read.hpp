// Meshes in, through VTK's own readers: VTU, PVTU, legacy VTK, Exodus. Cells that are not tetrahedra are
// tetrahedralised so that neighbours agree; points and point arrays keep their order, type and bits.
#pragma once

#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace ptet {

/// What was read, for the user: nothing that was left out or renamed goes unsaid.
struct ReadReport {
  std::string format;                   ///< "VTU", "PVTU", "legacy VTK" or "Exodus"
  std::vector<std::string> more_files;  ///< the pieces of a PVTU
  std::vector<std::string> cell_arrays; ///< names of those that hold values: they are not carried, as the notes say
  std::vector<std::string> notes;       ///< one sentence each: cells split or skipped, arrays renamed or not carried
};

/// Reads the mesh in `path`: VTU, PVTU, legacy VTK or Exodus, told apart by the contents and not by the ending.
///
/// Returns every point of the file, used or not, in the file's order; every numeric point array; and the volume cells
/// as tets in the file's cell order and orientation (vertices of a tet in the file's order). Hexahedra, voxels, wedges,
/// pyramids, the quadratic cells of 10, 13, 15, 18, 20 and 27 points, and Lagrange's tetrahedra, hexahedra and wedges
/// of orders up to 64 are split conformingly without new points; prisms over pentagons and hexagons, and polyhedra of
/// VTU, around a point in the middle of each, which come behind those of their piece, with the mean of the values
/// around. The tets' ids are in range; nothing else about the mesh is checked (see validate()). `report` may be null.
/// `memory_limit`: the most bytes that reading may take; 0: no limit. What the head of the file says of its size is
/// held against it, before any of its tables is read. Throws Error, messages beginning with the path: kIo (cannot be
/// opened or read), kBadInput (contents: damaged, no volume cells, a cell type or a dataset that cannot be handled),
/// kLimit (more than 2^32 - 2 points or tets, or more than memory holds or `memory_limit` allows); and kCancelled.
/// Prints nothing. Thread rule: calls wait for one another and for write_mesh() (VTK's messages go through one global
/// window). Cost: VTK's reading, plus one copy of every array, and up to 290 bytes a hexahedron that has to be split,
/// 1,200 of 27 points.
[[nodiscard]] TetMesh read_mesh(const std::string& path, ReadReport* report = nullptr,
                                const ProgressCallback& progress = {}, std::uint64_t memory_limit = 0);

/// The files that a PVTU names as its pieces, in its order; none of another file, or of one that cannot be read.
/// Thread rule: that of read_mesh(). Cost: reading the PVTU.
[[nodiscard]] std::vector<std::string> piece_files(const std::string& path);

/// The XXH64 of the bytes of a file and of ReadReport::more_files behind it, as "xxh64:0123456789abcdef", for
/// provenance. Throws Error: kIo, kCancelled.
[[nodiscard]] std::string hash_input(const std::string& path, const std::vector<std::string>& more_files = {},
                                     const ProgressCallback& progress = {});

} // namespace ptet
