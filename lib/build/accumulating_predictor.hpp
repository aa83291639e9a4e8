// What the predictors have in common that estimate the error of one collapse and add it to that of all before it.
//
//   a(v)             error so far of the tets around vertex v, an upper estimate; 0 at first
//   error(vs -> vd)  a(vs) plus the error that this collapse alone adds
//   afterwards       a(x) is at least error(vs -> vd) at all vertices x of the modified tets, whose error it is now
//
// kept for each field and, with the boundary faces for tets, for the domain. A cost is the growing square: the largest
// of the weighted errors.
//
// Handing the error on to vd alone orders worse: the largest sampled error at 10% of the vertices, in % of the range,
// was 18 / 8.3 / 22 / .94 by local errors on four meshes, against 14 / 8.1 / 15 / .97.
//
// Source: Cignoni et al. 2000, section 5.1 (accumulation), 4.3 (combination).
#pragma once

#include "build/normalized_fields.hpp"
#include "build/predictor.hpp"

#include <vector>

namespace ptet::build {

class AccumulatingPredictor : public Predictor {
public:
  void costs(Vertex vs, std::span<const Vertex> targets, std::span<float> costs) const final;
  void collapse(Vertex vs, Vertex vd, std::span<const SlotId> deleted, std::span<const SlotId> modified) final;
  void field_errors(Vertex vs, Vertex vd, std::span<double> errors) const final;
  [[nodiscard]] double domain_error(Vertex vs, Vertex vd) const final;

protected:
  /// `field_weight`: one for each governing field, of errors as fractions of its range; `domain_weight`: of errors as
  /// fractions of the diagonal. Keeps references to the first three.
  AccumulatingPredictor(const WorkingComplex& complex, const std::vector<Point>& positions,
                        const NormalizedFields& fields, double diagonal, std::vector<double> field_weight,
                        double domain_weight);

  /// The field errors that vs -> vd alone adds, one a field as fractions of its range.
  virtual void added_field_errors(Vertex vs, Vertex vd, std::span<double> errors) const = 0;

  [[nodiscard]] const WorkingComplex& complex() const { return complex_; }
  [[nodiscard]] const std::vector<Point>& positions() const { return positions_; }
  [[nodiscard]] const NormalizedFields& fields() const { return fields_; }
  [[nodiscard]] double inverse_diagonal() const { return inverse_diagonal_; }

private:
  const WorkingComplex& complex_;
  const std::vector<Point>& positions_;
  const NormalizedFields& fields_;
  double inverse_diagonal_;
  std::vector<double> field_weight_;
  double domain_weight_;
  std::vector<double> field_error_;  ///< vertex x field
  std::vector<double> domain_error_; ///< by vertex
};

} // namespace ptet::build
