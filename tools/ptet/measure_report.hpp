// What `ptet measure` says of two meshes.
#pragma once

#include "error/mesh_comparison.hpp"
#include "error/surface_distance.hpp"
#include "formats/vtk/read.hpp"
#include "mesh/examination.hpp"
#include "ptet/validate.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ptet::cli {

/// One of the two meshes, as it was read and found.
struct MeasuredMesh {
  std::string path;
  TetMesh mesh;
  ReadReport read;
  Examination found; ///< its points and boundary
  MeshReport report;
  std::uint64_t boundary_intersections = 0;
  double volume = 0;
};

struct ComparedField {
  std::string name;
  std::string simplified_name; ///< what the simplified mesh calls it
  std::uint32_t components = 1;
  double range = 0; ///< of the original
};

/// Everything there is to say after the measurements.
struct MeasureOutcome {
  MeasuredMesh original, simplified;
  std::optional<std::uint64_t> samples; ///< nothing: exact
  std::vector<ComparedField> fields;
  std::vector<std::string> notes;
  InsideDifference inside;
  OutsideDifference outside;
  VertexDifference vertices;
  DistanceBounds there, back; ///< original to simplified boundary, and the reverse
  double seconds = 0;
};

/// How often a mesh has the defect. Findings of severity kNote are none: all tets inverted is another convention of
/// order.
[[nodiscard]] std::uint64_t count_of(const MeshReport& report, const char* code);

/// `errors`: the file with the errors at vertices and in tets that was written.
void print_json(const MeasureOutcome& outcome, const std::optional<std::string>& errors);
void print_text(const MeasureOutcome& outcome, const std::optional<std::string>& errors);

} // namespace ptet::cli
