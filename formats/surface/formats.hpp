// The formats that hold coordinates as they are: .obj and .off with the fewest decimal digits that give each number
// back, .ply in binary with numbers of the positions' own width.
#pragma once

#include "formats/whole_file.hpp"
#include "ptet/mesh.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace ptet {

/// A surface in rows: what each format lists.
struct SurfaceRows {
  const PointArray* positions = nullptr;           ///< of the mesh
  std::vector<VertexId> vertices;                  ///< by row, whose position it has
  std::vector<std::array<std::uint32_t, 3>> faces; ///< of rows
};

/// Positions of 32-bit floats are written as such, those of other types as doubles. Throw Error(kIo).
void write_obj(WholeFile& file, const SurfaceRows& rows);
void write_off(WholeFile& file, const SurfaceRows& rows);
void write_ply(WholeFile& file, const SurfaceRows& rows);

} // namespace ptet
