// The removed vertices, and samples inside the original tets where there are any, each held by the present tet that it
// lies in, and the field errors seen at them.
//
// A removed vertex that a moving boundary has left outside is held by the tet nearest to it, and compared with the
// value at that tet's closest point (linear extension explodes at slivers).
//
// Source: Cignoni et al. 2000, sections 4.1 and 4.4.
#pragma once

#include "build/field_samples.hpp"
#include "build/normalized_fields.hpp"
#include "build/working_complex.hpp"

#include <memory>
#include <span>
#include <vector>

namespace ptet::build {

/// What becomes of a point outside that a moving boundary comes to cover.
enum class CoveredPoints {
  /// The tet that covers it holds it: where errors are seen at these points only, that is how its own are seen. But a
  /// mesh may leave out the collapse that covers the point and have later ones of where it was held before: what it
  /// differs by there nobody has seen.
  kMove,
  /// It stays in the line of tets that hold it outside, and every mesh is within what was seen there.
  kStay,
};

class RemovedVertices {
public:
  RemovedVertices(const std::vector<Point>& positions, const NormalizedFields& fields, double diagonal,
                  CoveredPoints covered);
  ~RemovedVertices();
  RemovedVertices(const RemovedVertices&) = delete;
  RemovedVertices& operator=(const RemovedVertices&) = delete;

  /// From now on `samples` are looked at too; each is held by its original tet, one of `tets`. Before the first
  /// collapse.
  void hold_samples(WorkingComplex& complex, std::span<const Sample> samples, std::span<const Tet> tets);

  /// From now on simulations tell of squared errors. `volumes`: by vertex, in any unit. Before the first collapse.
  void weigh(std::vector<double> volumes);

  /// What a collapse would make of the removed vertices around it; reusable.
  class Simulation {
  public:
    /// Largest error at any of the vertices, one a field, as fractions of the ranges.
    [[nodiscard]] std::span<const double> errors() const { return errors_; }
    /// Likewise at those that lie in a modified tet, and at those that do not.
    [[nodiscard]] std::span<const double> errors_inside() const { return errors_inside_; }
    [[nodiscard]] std::span<const double> errors_outside() const { return errors_outside_; }
    /// By field: what the integral of the squared error, of fractions of the ranges, would grow by over the tets, as
    /// the trapezoidal rule has it at the removed vertices in them; with the unit of their volumes. After weigh().
    [[nodiscard]] std::span<const double> squared_growth() const { return squared_growth_; }
    /// Likewise the largest of any field at those in the tet of modified slot `s`; 0 for others.
    [[nodiscard]] double error_in(SlotId s) const {
      for (const Cell& cell : cells_)
        if (cell.slot == s) return cell.worst;
      return 0;
    }

  private:
    friend class RemovedVertices;
    struct Cell {
      SlotId slot;
      std::array<Vertex, 4> v;
      std::array<Point, 4> x;
      std::array<std::array<double, 3>, 3> row; ///< barycentrics 1..3 of p: row . (p - x[0])
      double shape = 0;                         ///< of the rows, as a fraction of them; see kShapeRounding
      std::array<double, 3> rounding{};         ///< of a barycentric 1..3, per length
      double worst = 0;                         ///< error of any field at what it holds, unless that lies outside
      bool flat = false;
    };
    struct Held {
      Vertex point;
      std::uint32_t cell;
      bool outside;
    };
    std::vector<Cell> cells_;
    std::vector<Held> held_;
    std::size_t captured_begin_ = 0; ///< from here on `held_` are points that tets elsewhere hold so far
    std::vector<double> errors_, errors_inside_, errors_outside_;
    std::vector<double> at_point_;     ///< by field: the errors at the point that was last looked at
    std::vector<double> held_squared_; ///< held x field: volume times squared error, 0 outside; where they are told of
    std::vector<double> squared_growth_;
  };

  /// What the modified tets of vs -> vd would hold, and with which error. Ghosts in the lists are passed over.
  /// `boundary_moves`: the collapse may cover points that lay outside before; only then can it.
  /// Thread rule: const; one simulation a thread.
  void simulate(const WorkingComplex& complex, Vertex vs, Vertex vd, std::span<const SlotId> deleted,
                std::span<const SlotId> modified, bool boundary_moves, Simulation& simulation) const;
  /// A simulation of the present state becomes true; to be called before the complex itself is changed.
  void commit(WorkingComplex& complex, std::span<const SlotId> deleted, const Simulation& simulation);

private:
  struct OutsideIndex;
  using Cell = Simulation::Cell;

  [[nodiscard]] static double least_barycentric(const Cell& cell, const Point& p, std::array<double, 4>& weight);
  [[nodiscard]] static bool is_farther(const Cell& cell, const Point& p, double distance);
  void add_cell(const WorkingComplex& complex, SlotId slot, Vertex vs, Vertex vd, Simulation& simulation) const;
  void hold(Vertex point, Simulation& simulation) const;
  void hold_in(Vertex point, std::uint32_t cell, const std::array<double, 4>& weight, bool is_outside,
               Simulation& simulation) const;
  void see_errors(Vertex point, const Cell& cell, const std::array<double, 4>& weight,
                  std::vector<double>& errors) const;
  void see_squares(Vertex point, bool is_outside, Simulation& simulation) const;
  void hold_outside_points_now_covered(std::span<const SlotId> deleted, Simulation& simulation) const;
  void let_go(WorkingComplex& complex, Vertex point);
  /// Of a vertex, or behind them of a sample.
  [[nodiscard]] const Point& position(Vertex point) const {
    return point < positions_.size() ? positions_[point] : samples_.points[point - positions_.size()];
  }
  [[nodiscard]] const double* values(Vertex point) const {
    return point < positions_.size() ? fields_.exact().at(point)
                                     : &samples_.values[(point - positions_.size()) * fields_.channel_count()];
  }

  const std::vector<Point>& positions_;
  const NormalizedFields& fields_;
  FieldSamples samples_;
  double outside_distance_sq_;
  CoveredPoints covered_;
  std::vector<std::uint32_t> next_; ///< by point (vertices, then samples): the next one that the same tet holds
  std::vector<SlotId> holder_;      ///< by point: the tet that holds it
  std::vector<char> is_outside_;    ///< by point
  std::vector<double> volume_;      ///< by vertex; none where squared errors are not told of
  std::vector<double> squared_;     ///< vertex x field: volume times squared error where a tet holds it inside, else 0
  std::unique_ptr<OutsideIndex> outside_;
};

} // namespace ptet::build
