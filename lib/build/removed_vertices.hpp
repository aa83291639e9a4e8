// The removed vertices, each held by the present tet that it lies in, and the field errors seen at them.
//
// A removed vertex that a moving boundary has left outside is held by the tet nearest to it, and compared with the
// value at that tet's closest point (linear extension explodes at slivers).
//
// Source: Cignoni et al. 2000, sections 4.1 and 4.4.
#pragma once

#include "build/normalized_fields.hpp"
#include "build/working_complex.hpp"

#include <span>
#include <vector>

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>

namespace ptet::build {

class RemovedVertices {
public:
  RemovedVertices(const std::vector<Point>& positions, const NormalizedFields& fields, double diagonal);

  /// What the modified tets of vs -> vd would hold, and with which error. Ghosts in the lists are passed over.
  /// `boundary_moves`: the collapse may cover points that lay outside before; only then can it.
  void simulate(const WorkingComplex& complex, Vertex vs, Vertex vd, std::span<const SlotId> deleted,
                std::span<const SlotId> modified, bool boundary_moves);
  /// Largest error at any vertex of the last simulation, one per field, as fractions of the ranges.
  [[nodiscard]] std::span<const double> errors() const { return errors_; }
  /// The last simulation becomes true; to be called before the complex itself is changed.
  void commit(WorkingComplex& complex, std::span<const SlotId> deleted);

private:
  using IndexPoint = boost::geometry::model::point<double, 3, boost::geometry::cs::cartesian>;
  using OutsideIndex = boost::geometry::index::rtree<std::pair<IndexPoint, Vertex>, boost::geometry::index::linear<16>>;

  struct Cell {
    SlotId slot;
    std::array<Vertex, 4> v;
    std::array<Point, 4> x;
    std::array<std::array<double, 3>, 3> row; ///< barycentrics 1..3 of p: row . (p - x[0])
    bool flat;
  };
  struct Held {
    Vertex point;
    std::uint32_t cell;
    bool outside;
  };

  [[nodiscard]] static double least_barycentric(const Cell& cell, const Point& p, std::array<double, 4>& weight);
  void add_cell(const WorkingComplex& complex, SlotId slot, Vertex vs, Vertex vd);
  void hold(Vertex point);
  void see_error(Vertex point, const Cell& cell, const std::array<double, 4>& weight);
  void hold_outside_points_now_covered(std::span<const SlotId> deleted);
  void let_go(WorkingComplex& complex, Vertex point);

  const std::vector<Point>& positions_;
  const NormalizedFields& fields_;
  double outside_distance_sq_;
  std::vector<std::uint32_t> next_; ///< by vertex: the next one that the same tet holds
  std::vector<SlotId> holder_;      ///< by vertex: the tet that holds it
  std::vector<char> is_outside_;    ///< by vertex
  OutsideIndex outside_;            ///< the vertices that lie outside

  // The last simulation.
  std::vector<Cell> cells_;
  std::vector<Held> held_;
  std::size_t captured_begin_ = 0; ///< from here on `held_` are points that tets elsewhere hold so far
  std::vector<double> errors_;
};

} // namespace ptet::build
