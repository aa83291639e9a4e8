// Which part of the original boundary each face of the collapsing boundary stands for, and upper bounds on how far the
// two are apart, both ways.
//
//   original -> face   Pieces (convex polygons, each in one original triangle) cover the original boundary, each held
//                      by one present face. A collapse hands the pieces of the faces around vs to the faces that it
//                      leaves there, divided where one face is not near all of a piece. In any cut the present faces
//                      hold all of the original boundary between them, so their largest distance to what they hold is a
//                      bound on the one-sided Hausdorff distance, whatever the cut.
//   face -> original   The largest distance of a point of the face to the original triangles near by, or to the faces
//                      that the collapse replaces plus their own distance. A property of the face alone.
//
// Source: Cignoni et al. 2000, section 4.2 (domain error; there at removed vertices only).
#pragma once

#include "build/patch_division.hpp"
#include "error/surface_distance.hpp"
#include "mesh/clearable_set.hpp"

namespace ptet::build {

class BoundaryPieces {
public:
  /// `triangles`: all of the original boundary.
  BoundaryPieces(const std::vector<Point>& positions, std::span<const std::array<Vertex, 3>> triangles,
                 double diagonal);

  /// Original triangle, held whole by the face of that number.
  void add(std::uint32_t face, const std::array<Vertex, 3>& triangle);

  /// What the faces around a vertex held, as it is handed over to those that a collapse leaves there.
  struct Handover {
    struct Placed {
      std::uint32_t triangle;
      std::uint32_t target; ///< coarse triangle
      Part part;
    };
    std::vector<Placed> placed;
    std::vector<double> away; ///< by coarse triangle: bound on the distance of its points to the original boundary
  };
  class Division;
  /// A division becomes true. `faces`: numbers of the coarse triangles, in their order.
  void commit(std::span<const std::uint32_t> fine, std::span<const std::uint32_t> faces, const Handover& handover);

  /// What a face holds: original triangle and part of it.
  struct Held {
    std::array<Vertex, 3> triangle;
    Part part;
  };
  [[nodiscard]] std::vector<Held> held(std::uint32_t face) const;

private:
  struct Piece {
    std::uint32_t triangle;
    std::uint32_t part; ///< kNone: all of the triangle
    std::uint32_t next;
  };
  struct Face {
    std::uint32_t first_piece = kNone;
    double away = 0; ///< bound on the distance of its points to the original boundary
  };
  [[nodiscard]] std::array<Point, 3> corners(std::uint32_t triangle) const;
  void push(Face& face, std::uint32_t triangle, const Part& part);

  const std::vector<Point>& positions_;
  TriangleSurface original_;
  double rounding_;
  std::vector<std::array<Vertex, 3>> triangles_;
  std::vector<std::uint32_t> parts_of_; ///< by triangle: the pieces of it that are held
  std::vector<Face> faces_;
  std::vector<Piece> pieces_;
  std::vector<std::uint32_t> free_pieces_;
  std::vector<Part> parts_;
  std::vector<std::uint32_t> free_parts_;
};

/// One thread's division of what faces hold. The pieces must outlive it, and not change while it is made.
class BoundaryPieces::Division {
public:
  explicit Division(const BoundaryPieces& pieces);

  /// Divides what the faces `fine` hold among the triangles `coarse`. Returns an upper bound on the distances between
  /// each of these and what it would hold, and from it to the original boundary; mesh units, 0 when it is rounding. A
  /// value above `limit` may come early: then it is a lower bound, and not to be committed.
  /// `fine_triangles`: the faces `fine`, in their order.
  /// Thread rule: reads the pieces only. What is divided depends on the faces `fine` and what they hold alone.
  [[nodiscard]] double hand_over(std::span<const std::uint32_t> fine, std::span<PatchTriangle> fine_triangles,
                                 std::span<const PatchTriangle> coarse, double limit);
  /// A lower bound on what hand_over() would return, from corners of what the faces hold alone; it stops looking at a
  /// value above `enough`. Thread rule: as hand_over().
  [[nodiscard]] double at_least(std::span<const std::uint32_t> fine, std::span<const PatchTriangle> coarse,
                                double enough);
  /// The last division.
  [[nodiscard]] const Handover& handover() const { return handover_; }

private:
  using Placed = Handover::Placed;
  struct Gathered {
    std::uint32_t triangle;
    Part part;
  };

  void gather(std::span<const std::uint32_t> fine);
  void begin(std::span<const PatchTriangle> coarse);
  double divide(std::span<const PatchTriangle> coarse, double limit);
  double merge_placed(std::size_t first, bool all);
  double away(std::uint32_t target, const PatchTriangle& face, std::span<const PatchTriangle> fine, double enough);
  double away_from(const PatchTriangle& face, std::span<const PatchTriangle> targets, double enough);
  void add_rows(std::uint32_t triangle, const Part& part);

  const BoundaryPieces& of_;
  Handover handover_;
  PatchDivision division_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> found_; ///< triangle, part
  std::vector<Gathered> gathered_;
  std::vector<std::uint32_t> rows_;
  std::vector<std::uint32_t> row_of_; ///< by vertex
  ClearableSet has_row_;              ///< vertices
  std::vector<PatchDivision::Placed> divided_;
  std::vector<PatchTriangle> near_;
  std::vector<Part> scratch_;
};

} // namespace ptet::build
