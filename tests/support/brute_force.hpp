// The errors of a cut found by looking at everything: every removed vertex against every tet, every sample of the
// boundary against every boundary face. No index, no lists that are handed on, nothing of the builder's geometry.
#pragma once

#include "ptet/mesh.hpp"
#include "record/stream.hpp"
#include "support/versions.hpp"

#include <array>
#include <optional>
#include <vector>

namespace ptet::test {

/// The mesh of one cut: the versions that are there, and the record that made each.
struct CutMesh {
  static constexpr std::size_t kOriginal = static_cast<std::size_t>(-1);
  std::vector<Tet> tets;
  std::vector<std::size_t> tet_maker; ///< by tet: a record, or kOriginal
  std::vector<Tet> ghosts;
  std::vector<std::size_t> ghost_maker;
  std::vector<VertexId> removed; ///< vertices that are not there
};

/// `is_split` by record, closed: with a record every consumer of what it made, and the others that it needs.
[[nodiscard]] CutMesh cut_mesh(const RecordStream& stream, const std::vector<char>& is_split);
/// The cut with the first `count` collapses done.
[[nodiscard]] std::vector<char> after_collapses(const RecordStream& stream, std::size_t count);
/// For each record how many come before it where budgets undo collapses, by PTET.md's words, pair by pair.
[[nodiscard]] std::vector<std::size_t> places_in_budgets(const RecordStream& stream);
/// Adds to the split records all that must be split with them.
void close_cut(const RecordStream& stream, std::vector<char>& is_split);

/// Largest recorded domain error over the makers of the ghosts.
[[nodiscard]] double largest_domain_error(const RecordStream& stream, const CutMesh& cut);

/// Barycentric coordinates of p; nothing for a flat tet.
[[nodiscard]] std::optional<std::array<double, 4>> barycentrics(const Point& p, const std::array<Point, 4>& tet);
struct Nearest {
  double distance = 0;
  std::array<double, 3> weight{};
};
/// The closest point of a triangle: its plane if the foot is inside, else the best of its sides.
[[nodiscard]] Nearest nearest_on_triangle(const Point& p, const std::array<Point, 3>& triangle);

struct NearestOnTet {
  double distance = 0; ///< 0 inside
  std::array<double, 4> weight{};
};
[[nodiscard]] NearestOnTet nearest_on_tet(const Point& p, const std::array<Point, 4>& tet);

/// Barycentric coordinates above this count as inside, here and (somewhat closer to 0) in the builder.
inline constexpr double kTouching = -1e-9;

/// For each of `vertices` the versions in the cut that it may be held by: as long as it is there none; then a tet that
/// its own collapse made, and whenever that one is consumed the tet made in its place that contains the vertex or is
/// nearest to it. All of them where rounding decides.
[[nodiscard]] std::vector<std::vector<VersionId>> possible_holders(const RecordStream& stream,
                                                                   const std::vector<Point>& points,
                                                                   const std::vector<char>& is_split,
                                                                   const std::vector<VertexId>& vertices);
/// By version: the record that made it, or CutMesh::kOriginal.
[[nodiscard]] std::vector<std::size_t> makers(const RecordStream& stream);

/// |field(v) - sum of weight[i] field(corner[i])|, Euclidean over the components.
[[nodiscard]] double interpolation_error(const PointArray& field, VertexId v, const Tet& corner,
                                         const std::array<double, 4>& weight);

/// Over the part of a tet of the mesh in another: cones over the faces of each that lie in the other.
struct OverlapIntegrals {
  std::vector<double> squared; ///< of |original field - field of `version`|^2, by component
  double volume = 0;
};
/// Neither tet is flat.
[[nodiscard]] OverlapIntegrals integrals_over_overlap(const std::vector<Point>& points, const PointArray& field,
                                                      const Tet& original, const Tet& version);

} // namespace ptet::test
