// What of a tetrahedral mesh is drawn, as polygons: its boundary, its cells cut open along a plane, and where a
// function that is linear in each tet takes a value (a slice, an isosurface). Knows nothing of windows, nor of VTK.
//
//   boundary       cut open, whole cells      level set
//    ______           ______                   one polygon a tet:   3 crossings       4 crossings
//   /     /|         /_/\/\/                                           /\                ____
//  /_____/ |        |/\ /\|    plane ->                               /__\              |____|
#pragma once

#include "face_table.hpp"
#include "ptet/mesh.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ptet::view {

inline constexpr std::uint32_t kUnusedRow = 0xFFFFFFFF; ///< as Session::kUnused

/// A mesh in rows as a session holds it. Unused tets and faces are kUnusedRow throughout.
struct MeshRows {
  std::span<const Point> positions;
  std::span<const double> values; ///< by vertex, what colours it
  std::span<const std::array<std::uint32_t, 4>> tets;
  std::span<const std::array<std::uint32_t, 3>> faces; ///< of the boundary, outward oriented
  std::span<const double> tet_values;                  ///< by tet, what colours it instead; empty: `values` does
  /// By face the tet behind it, see BoundaryTets; where there are tet_values.
  std::span<const std::uint32_t> behind = {};
};

/// The rows in which a mesh may differ from what it was.
struct Changes {
  std::span<const std::uint32_t> tets, faces, vertices;
};

/// The points x with dot(normal, x) <= offset are behind the plane.
struct Plane {
  Point normal{0, -1, 0};
  double offset = 0;

  friend bool operator==(const Plane&, const Plane&) = default;
  [[nodiscard]] double distance(const Point& p) const {
    return normal[0] * p[0] + normal[1] * p[1] + normal[2] * p[2] - offset;
  }
  /// Which one it lies across; none: it is askew.
  [[nodiscard]] std::optional<std::size_t> axis() const;
  /// Where on that axis, whichever way the normal points; of one that is askew, the offset.
  [[nodiscard]] double place() const;
  void move_to(double place);
};

/// Convex polygons: `corners` from offsets[i] up to offsets[i + 1] are rows of `points`.
struct Polygons {
  std::vector<Point> points;
  std::vector<double> point_values; ///< by point, or
  std::vector<double> cell_values;  ///< by polygon: one of the two is empty
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int64_t> corners;

  [[nodiscard]] std::size_t count() const { return offsets.size() - 1; }
  void clear();
};

/// Makes polygons; keeps its memory from call to call, so that a viewer allocates nothing while it follows a mesh.
///
/// Where `changes` are given, the last call was the same one, with the same plane, or function and value, for the mesh
/// as it was before these changes: only they are looked at, and what is drawn.
///
/// Thread rule: one thread at a time.
class Geometry {
public:
  /// The boundary faces.
  void boundary(const MeshRows& mesh, Polygons& out);
  /// The faces of all tets whose centre is behind the plane that no other such tet shares. Cost: a look at each tet,
  /// and at the faces of those that the plane cuts.
  void cut_open(const MeshRows& mesh, const Plane& plane, Polygons& out, const Changes* changes = nullptr);
  /// Where `function`, by vertex and linear in each tet, is `value`. Points are not shared between polygons. Tets where
  /// it is not finite are left out. Cost: a look at each tet.
  void level_set(const MeshRows& mesh, std::span<const double> function, double value, Polygons& out,
                 const Changes* changes = nullptr);

private:
  using Face = std::array<std::uint32_t, 3>;
  using Corners = std::array<std::uint32_t, 4>;
  /// A tet with corners on both sides, as it was when it came.
  struct Mixed {
    std::uint32_t tet;
    Corners corners;
  };

  template <class IsThere>
  void find_sides(const MeshRows& mesh, const Changes* changes, IsThere&& is_there);
  template <class Enters, class Leaves>
  void find_mixed(const MeshRows& mesh, const Changes* changes, Enters&& enters, Leaves&& leaves);
  void emit(const MeshRows& mesh, const Face& face, std::uint32_t tet, Polygons& out);
  template <class IsKept>
  void emit_by_tet(const MeshRows& mesh, std::span<const Face> wanted, IsKept&& is_kept, Polygons& out);

  std::vector<std::uint32_t> row_; ///< by vertex: its point in the polygons made now
  // What the last call found, for the next one.
  std::vector<double> distance_;           ///< by vertex, from the plane
  std::vector<char> side_;                 ///< by vertex
  std::vector<Mixed> mixed_;               ///< in no order
  std::vector<std::uint32_t> mixed_place_; ///< by tet, in mixed_, or kUnusedRow
  FaceTable cut_faces_;                    ///< of mixed tets
  std::vector<char> is_kept_;              ///< by tet, of mixed ones
  // Scratch.
  std::vector<char> is_done_;   ///< by entry of cut_faces_
  std::vector<char> on_mixed_;  ///< by vertex, a corner of one of them
  std::vector<Face> unowned_;   ///< faces to be drawn whose tet is not known yet
  std::vector<Face> wanted_;    ///< ascending
  std::vector<char> on_wanted_; ///< by vertex
};

} // namespace ptet::view
