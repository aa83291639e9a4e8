// Predicted cost of a half-edge collapse by quadrics of field and domain (the paper's QN).
//
// Source: Cignoni et al. 2000, section 5.3; errors combined as in section 4.3.
#pragma once

#include "build/collapse_geometry.hpp"
#include "build/mesh_scales.hpp"
#include "build/normalized_fields.hpp"
#include "build/predictor.hpp"
#include "build/quadric.hpp"
#include "build/working_complex.hpp"
#include "mesh/large_pages.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ptet::build {

/// How much a tet counts in the field quadrics of its vertices.
enum class QuadricWeight {
  kRootOfVolume, ///< between counting tets, good for the maximum, and weighing by volume, good for the mean square
  kVolume,       ///< the quadrics are integrals
};

class QuadricPredictor final : public Predictor {
public:
  /// `field_weight`: one for each governing field, of errors as fractions of its range; `domain_weight`: of errors as
  /// fractions of the diagonal. `whole`: the mesh that the complex is a part of; null: it is all of it.
  QuadricPredictor(const WorkingComplex& complex, const std::vector<Point>& positions, const NormalizedFields& fields,
                   double diagonal, std::vector<double> field_weight, double domain_weight,
                   QuadricWeight weight = QuadricWeight::kRootOfVolume, const MeshScales* whole = nullptr);

  /// Cost of vs -> vd: the growing square max(w_d e_d, w_f e_f), plus a trifle for the length of the edge, so that
  /// where nothing is lost short edges go first.
  [[nodiscard]] inline float cost(Vertex vs, Vertex vd) const;
  /// Growth of the integral of the squared error as the quadrics see it, one a field, in volumes of an average vertex.
  void squared_growth(Vertex vs, Vertex vd, std::span<double> growth) const {
    const Vec3 x = inverse_diagonal_ * (positions_[vd] - positions_[vs]);
    const double* const f_vs = fields_.at(vs);
    const double* const f_vd = fields_.at(vd);
    std::fill(growth.begin(), growth.end(), 0.0);
    for (std::size_t c = 0; c < channels_; ++c) {
      const FieldQuadric& quadric = field_quadrics_[vs * channels_ + c];
      growth[fields_.field_of(c)] += quadric.at(x, f_vd[c] - f_vs[c], weight_[vs]) - quadric.cc;
    }
    for (double& g : growth)
      g *= vertex_share_;
  }
  /// The domain part of the cost.
  [[nodiscard]] double domain_cost(Vertex vs, Vertex vd) const {
    if (plane_index_[vs] == kNone) return 0;
    const Vec3 x = inverse_diagonal_ * (positions_[vd] - positions_[vs]);
    return domain_weight_ * std::sqrt(std::max(0.0, plane_quadrics_[plane_index_[vs]].at(x)));
  }
  /// The trifle.
  [[nodiscard]] double length_cost(Vertex vs, Vertex vd) const {
    const Vec3 x = inverse_diagonal_ * (positions_[vd] - positions_[vs]);
    return kEdgeLengthWeight * std::sqrt(dot(x, x));
  }
  /// vs has been collapsed into vd.
  void merge(Vertex vs, Vertex vd);

  void costs(Vertex vs, std::span<const Vertex> targets, std::span<float> costs) const override;
  void collapse(Vertex vs, Vertex vd, std::span<const SlotId> deleted, std::span<const SlotId> modified) override;
  /// The weighted root mean square, over the tets whose quadrics vs carries, of how far the value at vd is from their
  /// linear fields.
  void field_errors(Vertex vs, Vertex vd, std::span<double> errors) const override;
  /// The root mean square of the distances of vd to the planes whose quadrics vs carries.
  [[nodiscard]] double domain_error(Vertex vs, Vertex vd) const override;

private:
  void add_tet(const Slot& tet, double mean_volume, QuadricWeight weight);
  void add_boundary_face(const Slot& ghost, Vertex dummy);

  const std::vector<Point>& positions_;
  const NormalizedFields& fields_;
  std::size_t channels_;
  double inverse_diagonal_;
  std::vector<double> field_weight_;
  double domain_weight_;
  double vertex_share_ = 0;                  ///< of a tet of average volume, in volumes of an average vertex
  std::vector<double> weight_;               ///< of the tets, by vertex
  LargeVector<FieldQuadric> field_quadrics_; ///< vertex x channel
  std::vector<std::uint32_t> plane_index_;   ///< by vertex, into plane_quadrics_; kNone inside the domain
  std::vector<PlaneQuadric> plane_quadrics_;
};

float QuadricPredictor::cost(Vertex vs, Vertex vd) const {
  const Vec3 x = inverse_diagonal_ * (positions_[vd] - positions_[vs]);
  const double* const f_vs = fields_.at(vs);
  const double* const f_vd = fields_.at(vd);
  const FieldQuadric* const quadrics = field_quadrics_.data() + vs * channels_;
  const double weight = weight_[vs];
  double worst_sq = 0;
  double field_sq = 0;
  for (std::size_t c = 0; c < channels_; ++c) {
    // Channels of one field stand together: their squares add up to that of the vector.
    field_sq += std::max(0.0, quadrics[c].at(x, f_vd[c] - f_vs[c], weight));
    if (!fields_.ends_field(c)) continue;
    const double w = field_weight_[fields_.field_of(c)];
    worst_sq = std::max(worst_sq, w * w * field_sq);
    field_sq = 0;
  }
  if (plane_index_[vs] != kNone)
    worst_sq = std::max(worst_sq, domain_weight_ * domain_weight_ * plane_quadrics_[plane_index_[vs]].at(x));
  return static_cast<float>(std::sqrt(worst_sq) + kEdgeLengthWeight * std::sqrt(dot(x, x)));
}

} // namespace ptet::build
