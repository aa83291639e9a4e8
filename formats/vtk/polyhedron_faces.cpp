#include "formats/vtk/polyhedron_faces.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include <vtkCellType.h>

namespace ptet::vtkio {
namespace {

std::string wrong(const PieceCells& cells, std::size_t cell, const std::string& what) {
  return "the faces of cell " + std::to_string(cells.first + cell) + ", a polyhedron, " + what;
}

/// Whether offsets go up from 0 to the length of what they are in.
bool are_ends(const Integers& offsets, std::size_t length) {
  return std::is_sorted(offsets.begin(), offsets.end()) &&
         (offsets.empty() ? length == 0 : offsets.front() >= 0 && static_cast<std::uint64_t>(offsets.back()) == length);
}

/// Returns the first corner that is no point, of a face that is then there in part.
std::optional<std::int64_t> add_face(std::span<const std::int64_t> corners, PolyhedronFaces& to) {
  for (const std::int64_t id : corners) {
    if (id < 0 || id > std::int64_t{std::numeric_limits<std::uint32_t>::max()}) return id;
    to.corners.push_back(static_cast<std::uint32_t>(id));
  }
  to.corner_begin.push_back(to.corners.size());
  return std::nullopt;
}

void begin(PolyhedronFaces& to) {
  to = {};
  to.face_begin.push_back(0);
  to.corner_begin.push_back(0);
}

} // namespace

std::int64_t length_of_faces(const Integers& faceoffsets) {
  return faceoffsets.empty() ? 0 : std::max<std::int64_t>(0, *std::max_element(faceoffsets.begin(), faceoffsets.end()));
}

std::int64_t length_by(const Integers& offsets) {
  return offsets.empty() ? 0 : offsets.back();
}

std::string faces_of(const PieceCells& cells, const FaceStream& from, PolyhedronFaces& to) {
  begin(to);
  const Integers& stream = from.faces;
  std::size_t at = 0;
  for (std::size_t cell = 0; cell < cells.types.size(); ++cell) {
    const std::int64_t stated = from.faceoffsets[cell];
    if (cells.types[cell] == VTK_POLYHEDRON) {
      // What is left of the stream bounds all that it says.
      const auto left = [&] { return static_cast<std::int64_t>(stream.size() - at); };
      if (stated < 0 || left() < 1) return wrong(cells, cell, "are not there");
      const std::int64_t faces = stream[at++];
      for (std::int64_t f = 0; f < faces; ++f) {
        if (left() < 1 || stream[at] < 0 || stream[at] >= left())
          return wrong(cells, cell, "run past the end of their table");
        const auto corners = static_cast<std::size_t>(stream[at]);
        if (const auto id = add_face(std::span(stream).subspan(at + 1, corners), to))
          return wrong(cells, cell, "use point " + std::to_string(*id));
        at += 1 + corners;
      }
      if (static_cast<std::int64_t>(at) != stated) return wrong(cells, cell, "do not end where their offset says");
    } else if (stated > static_cast<std::int64_t>(at)) {
      at = static_cast<std::size_t>(stated); // faces of another cell, which needs none; within the table
    }
    to.face_begin.push_back(to.corner_begin.size() - 1);
  }
  return {};
}

std::string faces_of(const PieceCells& cells, const FaceTables& from, PolyhedronFaces& to) {
  begin(to);
  if (!are_ends(from.polyhedron_offsets, from.polyhedron_to_faces.size()) ||
      !are_ends(from.face_offsets, from.face_connectivity.size()))
    return "the offsets of the faces of polyhedra do not go up from 0 to the lengths of their tables";
  std::vector<std::uint8_t> uses(from.face_offsets.size());
  std::int64_t at = 0;
  for (std::size_t cell = 0; cell < cells.types.size(); ++cell) {
    for (; at < from.polyhedron_offsets[cell]; ++at) {
      if (cells.types[cell] != VTK_POLYHEDRON) continue;
      const std::int64_t face = from.polyhedron_to_faces[static_cast<std::size_t>(at)];
      if (face < 0 || face >= static_cast<std::int64_t>(from.face_offsets.size()))
        return wrong(cells, cell, "are not there");
      const auto f = static_cast<std::size_t>(face);
      if (++uses[f] > 2) return wrong(cells, cell, "are those of two others, too");
      const auto first = static_cast<std::size_t>(f == 0 ? 0 : from.face_offsets[f - 1]);
      const auto end = static_cast<std::size_t>(from.face_offsets[f]);
      if (const auto id = add_face(std::span(from.face_connectivity).subspan(first, end - first), to))
        return wrong(cells, cell, "use point " + std::to_string(*id));
    }
    to.face_begin.push_back(to.corner_begin.size() - 1);
  }
  return {};
}

} // namespace ptet::vtkio
