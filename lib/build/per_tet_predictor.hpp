// Predicted cost of a half-edge collapse by an error bound that every tet carries, as a baseline.
//
//   E(t)   error so far of tet t; 0 at first
//   t -> t' a modified tet, with vd in the place of vs:
//          E(t') = max(E(t), largest E of the deleted tets) + largest |old linear field - new one| over t and t'
//          together
//
// The cost is the largest E(t') that the collapse would leave. Both linear fields agree on the face opposite vs, so
// their difference grows with the distance from it, and is largest at the lower one of vs and vd. Boundary faces carry
// the distances of their removed vertices in the same manner.
//
// Source: after Trotts, Hamann, Joy, Wiley, Simplification of Tetrahedral Meshes, 1998, and Trotts, Hamann, Joy,
// Simplification of Tetrahedral Meshes with Error Bounds, 1999: bounds by tet, added up over collapses. There a tet is
// taken away by three collapses, here it is single half-edges; the weights are those of Cignoni et al. 2000, section
// 4.3.
#pragma once

#include "build/normalized_fields.hpp"
#include "build/predictor.hpp"

#include <vector>

namespace ptet::build {

class PerTetPredictor final : public Predictor {
public:
  /// `field_weight`: one for each governing field, of errors as fractions of its range; `domain_weight`: of errors as
  /// fractions of the diagonal. Keeps references to the first three.
  PerTetPredictor(const WorkingComplex& complex, const std::vector<Point>& positions, const NormalizedFields& fields,
                  double diagonal, std::vector<double> field_weight, double domain_weight);

  void costs(Vertex vs, std::span<const Vertex> targets, std::span<float> costs) const override;
  void collapse(Vertex vs, Vertex vd, std::span<const SlotId> deleted, std::span<const SlotId> modified) override;
  void field_errors(Vertex vs, Vertex vd, std::span<double> errors) const override;
  [[nodiscard]] double domain_error(Vertex vs, Vertex vd) const override;

  /// E of the tet in a slot, one a field, as fractions of the ranges.
  [[nodiscard]] std::span<const double> tet_errors(SlotId slot) const {
    return {field_error_.data() + slot * fields_.field_count(), fields_.field_count()};
  }
  /// E of the boundary face in a ghost's slot, as a fraction of the diagonal.
  [[nodiscard]] double face_error(SlotId ghost) const { return domain_error_[ghost]; }

private:
  void deleted_errors(Vertex vs, Vertex vd, std::span<double> errors) const;
  template <class Visit>
  void for_each_tet_error(Vertex vs, Vertex vd, std::span<const double> deleted, Visit&& visit) const;
  template <class Visit>
  void for_each_face_error(Vertex vs, Vertex vd, Visit&& visit) const;

  const WorkingComplex& complex_;
  const std::vector<Point>& positions_;
  const NormalizedFields& fields_;
  double inverse_diagonal_;
  std::vector<double> field_weight_;
  double domain_weight_;
  std::vector<double> field_error_;  ///< slot x field
  std::vector<double> domain_error_; ///< by slot; of ghosts
};

} // namespace ptet::build
