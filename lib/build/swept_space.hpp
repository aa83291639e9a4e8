// What the faces around a boundary vertex sweep when it goes to a neighbour.
#pragma once

#include "build/working_complex.hpp"
#include "mesh/box_tree.hpp"

#include <array>
#include <vector>

namespace ptet::build {

/// Each face around vs sweeps the tet of its corners and vd.
class SweptSpace {
public:
  using Face = std::array<Vertex, 3>;

  void begin(Vertex vs, Vertex vd);
  /// A face around vs that is left.
  void add(const Face& face, const std::vector<Point>& positions);

  /// Whether a vertex, not vs, is one of the tets'.
  [[nodiscard]] bool has_corner(Vertex x) const { return x == vd_ || faces_at(x) > 0; }
  /// Whether a point is inside, where there is surface neither before nor after: not on the outer sides, but on those
  /// between two tets. By exact predicates.
  [[nodiscard]] bool contains(const Point& p, const std::vector<Point>& positions) const;

private:
  struct Swept {
    Face face;
    BoundingBox box; ///< of the tet
  };
  [[nodiscard]] std::ptrdiff_t faces_at(Vertex x) const;
  [[nodiscard]] bool is_in(const Face& face, const Point& p, const std::vector<Point>& positions) const;

  Vertex vs_ = 0, vd_ = 0;
  std::vector<Swept> tets_;
};

} // namespace ptet::build
