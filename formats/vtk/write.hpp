// Meshes out, through VTK's own writers: VTU (raw appended, zlib unless asked otherwise) and legacy VTK (binary).
#pragma once

#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"

#include <string>
#include <variant>
#include <vector>

namespace ptet {

enum class Compressor { kNone, kZlib };

/// One value per tet, for what is not part of a mesh: an error, the record that made it.
struct CellArray {
  std::string name;
  std::variant<std::vector<float>, std::vector<double>, std::vector<std::uint32_t>> values;
};

struct WriteOptions {
  Compressor compressor = Compressor::kZlib; ///< of VTU; legacy VTK is not compressed
  std::vector<CellArray> cell_arrays;        ///< each of mesh.tets.size() values
};

/// Whether the name ends as one that write_mesh() takes: .vtu or .vtk.
[[nodiscard]] bool is_mesh_name(const std::string& path);

/// Writes `mesh` to `path`, a VTU for the ending .vtu and legacy VTK for .vtk, through a temporary file in the same
/// folder that is synced and then renamed: under `path` there is the old file or the whole new one.
///
/// Point arrays keep their type, name and bits. Headers and ids are 32-bit where the data allow.
/// Throws Error: kBadArgument (another ending, a cell array of the wrong length), kBadInput (a point array of the wrong
/// length, a name that is not UTF-8 or used twice, a tet id out of range), kIo (with the system's reason), kCancelled.
/// Nothing is left behind then. Prints nothing.
/// Thread rule: as read_mesh(). Cost: one copy of the tets' ids; arrays are handed to VTK where they lie.
void write_mesh(const std::string& path, const TetMesh& mesh, const WriteOptions& options = {},
                const ProgressCallback& progress = {});

} // namespace ptet
