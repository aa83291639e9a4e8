// The predictor that belongs to a build's prediction.
#pragma once

#include "build/mesh_scales.hpp"
#include "build/normalized_fields.hpp"
#include "build/predictor.hpp"
#include "build/working_complex.hpp"
#include "ptet/build.hpp"

#include <memory>
#include <vector>

namespace ptet::build {

class QuadricPredictor;

struct ChosenPredictor {
  std::unique_ptr<Predictor> predictor;
  const QuadricPredictor* quadrics = nullptr; ///< the same, where it is one of quadrics
};

/// Predictions that simulate get quadrics, which choose what is simulated.
/// `field_weight`: one a field, of errors as fractions of its range; `domain_weight`: of errors as fractions of the
/// diagonal. `whole`: the mesh that the complex, which must still be the original one, is a part of; null: it is all of
/// it. The predictor keeps references to the complex, the positions and the fields.
[[nodiscard]] ChosenPredictor choose_predictor(Prediction prediction, const WorkingComplex& complex,
                                               const std::vector<Point>& positions, const NormalizedFields& fields,
                                               double diagonal, std::vector<double> field_weight, double domain_weight,
                                               const MeshScales* whole);

} // namespace ptet::build
