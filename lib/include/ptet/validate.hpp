// What a mesh is: counts, defects with examples, topology of the domain. Nothing is repaired here. In
// ptet::build.
#pragma once

#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace ptet {

/// How bad a finding is for a build.
enum class Severity {
  kNote,    ///< handled without any loss
  kWarning, ///< handled; part of the mesh is treated with care (frozen, reoriented)
  kError,   ///< the mesh cannot be built from
};

/// One kind of defect: how often it occurs, and the ids of the first few.
struct Finding {
  std::string code; ///< stable, for programs: "inverted-tets"
  Severity severity = Severity::kNote;
  std::uint64_t count = 0;
  std::string message; ///< one sentence with the count, the first ids, and what is done about it
  /// Up to 8 ids of tets or vertices, whichever the message names; an edge or a face is its 2 or 3 vertices in turn.
  std::vector<std::uint64_t> first_ids;
};

struct FieldSummary {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::uint32_t components = 1;
  /// Least and greatest finite value; of the Euclidean norm for vectors; over vertices used by tets. NaN: there is
  /// none.
  double min = std::numeric_limits<double>::quiet_NaN();
  double max = std::numeric_limits<double>::quiet_NaN();
  std::uint64_t not_finite = 0; ///< at so many of these vertices
  /// Whether a build takes it that is told of no field: the floating-point ones, or all where there are none.
  bool governs_by_default = false;
  /// Whether errors of it can be measured: every value is finite, the range is, and 64-bit integers span less than
  /// 2^53. A build refuses to be governed by others.
  bool can_govern = false;
};

struct MeshReport {
  std::uint64_t vertices = 0;
  std::uint64_t tets = 0;
  std::uint64_t boundary_faces = 0;
  std::uint64_t boundary_vertices = 0;
  std::uint64_t components = 0;          ///< of tets joined by faces
  std::uint64_t boundary_components = 0; ///< of boundary faces joined by edges
  std::int64_t euler_characteristic = 0; ///< of the complex: V - E + F - T, used vertices only
  std::int64_t boundary_euler_characteristic = 0;
  double volume = 0; ///< sum of |volume| of the tets, those there twice once, mesh units cubed
  double boundary_area = 0;
  /// Whether parts that overlap were looked for: not where faces are folded or of more than two tets, or tets there
  /// twice, for then no boundary tells inside from outside.
  bool overlaps_examined = false;
  Point box_min{};
  Point box_max{};
  std::vector<FieldSummary> fields;
  std::vector<Finding> findings;

  [[nodiscard]] double diagonal() const;
  /// The first finding of severity kError, or nullptr.
  [[nodiscard]] const Finding* first_error() const;
};

/// Examines the mesh: ids in range, finite positions and values, repeated vertices in a tet, duplicate tets, faces of
/// more than two tets, folded faces (both tets on the same side), inverted and flat tets (exact orientation
/// predicate), parts that overlap, unused and coincident points, non-manifold boundary edges and vertices, components,
/// Euler characteristic.
///
/// Returns a report that holds every finding, not only the first.
/// Throws Error: kCancelled when `progress` returns false, kLimit for more than 2^28 tets or 2^32 - 2 vertices,
/// kBadArgument for a ScalarType that is none; nothing else for any contents of `mesh`.
/// Thread rule: const on `mesh`; concurrent calls are fine; on the calling thread alone. Cost: O(tets log tets).
[[nodiscard]] MeshReport validate(const TetMesh& mesh, const ProgressCallback& progress = {});

} // namespace ptet
