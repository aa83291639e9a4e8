// Builds as the property tests make them, and what must hold of the mesh after any number of their collapses.
#pragma once

#include "build/builder.hpp"
#include "support/brute_force.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"

#include <cstring>
#include <vector>

namespace ptet::test {

struct Built {
  PreparedMesh prepared;
  RecordStream stream;
  BuildReport report;
};

[[nodiscard]] Built build_all(PreparedMesh prepared, const BuildOptions& options);
[[nodiscard]] Built build_all(const TetMesh& mesh, const BuildOptions& options);
/// As far as it goes.
[[nodiscard]] BuildOptions to_the_end();
/// The sample meshes, and grids with random shapes and random, rough fields.
[[nodiscard]] std::vector<NamedMesh> meshes_to_build();

[[nodiscard]] CutMesh mesh_after(const Built& built, std::size_t collapses);
[[nodiscard]] std::size_t vertices_left(const Built& built);
/// The array of governing field `f`.
[[nodiscard]] const PointArray& field_array(const Built& built, std::size_t f);
/// The boundary faces that the ghosts stand for, outward, as `examine` gives them.
[[nodiscard]] std::vector<Face> faces_of(const std::vector<Tet>& ghosts);

/// CHECKs: no inverted tet, no crowded or folded face, the topology of the original, ghosts that are the boundary.
void check_sound(const Built& built, const CutMesh& cut, const MeshFacts& original);
/// CHECKs: no record consumes what a record of its own round made.
void check_rounds(const RecordStream& stream);

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
/// But for the errors.
[[nodiscard]] bool same_collapses(const RecordStream& a, const RecordStream& b);

/// Multiplies all values of an array of floats or doubles.
void scale(PointArray& array, double factor);

} // namespace ptet::test
