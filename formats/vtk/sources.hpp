// One function for each format: from a file, through VTK's reader of it, to an Assembler.
#pragma once

#include "formats/vtk/assemble.hpp"
#include "formats/vtk/messages.hpp"

#include <string>

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
};

void read_vtu(const Source& source, Assembler& assembler);
void read_pvtu(const Source& source, Assembler& assembler);
/// What the heads say; adds to `announced`.
void measure_vtu(const Source& source, AnnouncedMesh& announced);
void measure_pvtu(const Source& source, const Assembler& assembler, AnnouncedMesh& announced);
void read_legacy(const Source& source, Assembler& assembler);
void read_exodus(const Source& source, Assembler& assembler);

/// Throws Error(kIo) unless `path` is a regular file that can be opened.
void check_readable(const std::string& path);

/// Walks through a legacy VTK file and throws Error(kBadInput) unless it is an unstructured grid whose tables and
/// attributes are as long as they say: VTK's reader trusts those numbers and would run past its buffers. Notes where a
/// text ends within its last line.
void check_legacy(const Source& source);

} // namespace ptet::vtkio
