// Predicted cost of a half-edge collapse as a weighted sum of unlike terms, as a baseline.
//
//     cost(vs -> vd) = w1 E_grad + w2 E_vol + w3 E_equi
//
//   E_grad   the change of the field along the edge, |f(vs) - f(vd)|
//   E_vol    the volume that the domain gains or loses
//   E_equi   how unequal the edges at vd of the modified tets would become: the mean of |length - mean length|, an edge
//            once for each tet that has it
//
// Nothing is accumulated: each cost knows the mesh as it is and nothing of what was lost before.
//
// Source: Staadt and Gross, Progressive Tetrahedralizations, 1998, section 3. Theirs are the three terms and their sum;
// the units, chosen so that neither scaling the mesh nor the fields matters, are not.
#pragma once

#include "build/mesh_scales.hpp"
#include "build/normalized_fields.hpp"
#include "build/predictor.hpp"

#include <vector>

namespace ptet::build {

class WeightedSumPredictor final : public Predictor {
public:
  /// Of E_grad as a fraction of the range; E_vol over the area of a face of mean size, as a length in fractions of the
  /// diagonal; E_equi as a fraction of the diagonal.
  struct Weights {
    double gradient = 1;
    double volume = 1;
    double edge_length = 1;
  };

  /// `field_weight`: one for each governing field, of errors as fractions of its range, the largest of them counts;
  /// `domain_weight`: of E_vol, on top of its own. Keeps references to the first three. The complex must still be the
  /// original one. `whole`: the mesh that it is a part of; null: it is all of it.
  WeightedSumPredictor(const WorkingComplex& complex, const std::vector<Point>& positions,
                       const NormalizedFields& fields, double diagonal, std::vector<double> field_weight,
                       double domain_weight, const Weights& weights, const MeshScales* whole = nullptr);

  void costs(Vertex vs, std::span<const Vertex> targets, std::span<float> costs) const override;
  /// Does nothing: there is nothing to remember.
  void collapse(Vertex vs, Vertex vd, std::span<const SlotId> deleted, std::span<const SlotId> modified) override;
  /// E_grad.
  void field_errors(Vertex vs, Vertex vd, std::span<double> errors) const override;
  /// How far vs is from the faces that are left: E_vol is no length.
  [[nodiscard]] double domain_error(Vertex vs, Vertex vd) const override;

private:
  [[nodiscard]] double volume_term(Vertex vs, Vertex vd) const;
  [[nodiscard]] double edge_length_term(Vertex vs, Vertex vd) const;

  const WorkingComplex& complex_;
  const std::vector<Point>& positions_;
  const NormalizedFields& fields_;
  double inverse_diagonal_;
  std::vector<double> field_weight_;
  double domain_weight_;
  Weights weights_;
  double face_area_; ///< mean volume of the original tets to the power 2/3
};

} // namespace ptet::build
