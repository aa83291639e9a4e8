// One function for each format: from a file, through VTK's reader of it, to an Assembler.
#pragma once

#include "formats/vtk/assemble.hpp"
#include "formats/vtk/messages.hpp"

#include <string>
#include <vector>

namespace ptet::vtkio {

/// No compressor that a reader knows makes data smaller than this (lzma of one repeated byte comes near it): what a
/// file announces beyond is not in it.
inline constexpr std::uint64_t kMaxCompression = 8192;

/// What the functions below share. Errors that VTK reports are left in `messages` and thrown.
struct Source {
  std::string path;
  Messages& messages;
  const ProgressCallback& progress;
  ReadReport& report;
  std::uint64_t memory_limit = 0; ///< bytes; 0: none
};

/// What the head of a file says of its size, before its tables are read.
struct AnnouncedMesh {
  std::uint64_t points = 0;
  std::uint64_t cells = 0;
  std::uint64_t ids = 0;     ///< of points, in all cells together; 4 a cell where that is not known
  double point_bytes = 0;    ///< of the positions and point arrays of all points
  std::uint64_t corners = 0; ///< of the faces of polyhedra

  AnnouncedMesh& operator+=(const AnnouncedMesh& other) {
    points += other.points;
    cells += other.cells;
    ids += other.ids;
    point_bytes += other.point_bytes;
    corners += other.corners;
    return *this;
  }
  /// The most that read_mesh() has at a time: VTK's grid (64-bit ids) beside the mesh that is made of it, or beside
  /// cells that are yet to be split, or these beside their tets. Cells of more than four points are taken for
  /// hexahedra, or for quadratic cells where they have more than eight.
  [[nodiscard]] std::uint64_t bytes_to_read() const;
};

/// Throws Error(kLimit) when reading takes more than the limit allows.
void check_memory(const Source& source, const AnnouncedMesh& announced);

void read_vtu(const Source& source, Assembler& assembler);
void read_pvtu(const Source& source, Assembler& assembler);
/// Of a PVTU, as it names them; none where it cannot be read.
std::vector<std::string> pieces_of_pvtu(const std::string& path);
void read_legacy(const Source& source, Assembler& assembler);
void read_exodus(const Source& source, Assembler& assembler);

/// Throws Error(kIo) unless `path` is a regular file that can be opened.
void check_readable(const std::string& path);

/// Walks through a legacy VTK file and throws Error(kBadInput) unless it is an unstructured grid whose tables and
/// attributes are as long as they say: VTK's reader trusts those numbers and would run past its buffers. Notes where a
/// text ends within its last line. Returns the sizes that it has seen.
AnnouncedMesh check_legacy(const Source& source);

} // namespace ptet::vtkio
