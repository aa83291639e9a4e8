// Predicted cost of a half-edge collapse by local error accumulation (the paper's LN): the value that is lost with vs
// against what the mesh would say in its place, added to what was lost there before.
//
//     f(vs) --- value of the tet that would contain vs     field, as a fraction of the range
//     vs    --- nearest boundary face that would remain    domain, as a fraction of the diagonal
//
// A vertex that a moving boundary leaves outside is compared with the closest point of the tets that remain.
//
// Source: Cignoni et al. 2000, section 5.1.
#pragma once

#include "build/accumulating_predictor.hpp"

namespace ptet::build {

class LocalPredictor final : public AccumulatingPredictor {
public:
  /// Arguments as for the base.
  LocalPredictor(const WorkingComplex& complex, const std::vector<Point>& positions, const NormalizedFields& fields,
                 double diagonal, std::vector<double> field_weight, double domain_weight);

private:
  void added_field_errors(Vertex vs, Vertex vd, std::span<double> errors) const override;
};

} // namespace ptet::build
