// The faces of polyhedra as VTU has them, in either of its layouts, to PolyhedronFaces. Nothing in the arrays is
// trusted.
#pragma once

#include "formats/vtk/polyhedron.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace ptet::vtkio {

using Integers = std::vector<std::int64_t>;

/// By VTK up to 9.3: `faceoffsets` has for each cell where in `faces` its faces end, or -1; there stand their number,
/// then for each its number of corners and these.
struct FaceStream {
  Integers faceoffsets, faces;
};
/// By VTK from 9.4 on: each cell's faces end in `polyhedron_to_faces` at its polyhedron_offsets, each face's corners in
/// `face_connectivity` at its face_offsets.
struct FaceTables {
  Integers polyhedron_offsets, polyhedron_to_faces, face_offsets, face_connectivity;
};

/// How many values `faces` must have.
[[nodiscard]] std::int64_t length_of_faces(const Integers& faceoffsets);
/// How many values must stand in an array by the offsets into it.
[[nodiscard]] std::int64_t length_by(const Integers& offsets);

/// The cells of a piece of a file.
struct PieceCells {
  std::span<const unsigned char> types; ///< VTK's
  std::uint64_t first = 0;              ///< cells of the file before, for messages
};

/// Fills `to`, and returns what is wrong where that cannot be; empty otherwise.
/// Memory: what `from` has; a face that two polyhedra have is there twice.
[[nodiscard]] std::string faces_of(const PieceCells& cells, const FaceStream& from, PolyhedronFaces& to);
[[nodiscard]] std::string faces_of(const PieceCells& cells, const FaceTables& from, PolyhedronFaces& to);

} // namespace ptet::vtkio
