#include "build/choose_predictor.hpp"

#include "build/gradient_predictor.hpp"
#include "build/local_predictor.hpp"
#include "build/per_tet_predictor.hpp"
#include "build/quadric_predictor.hpp"
#include "build/weighted_sum_predictor.hpp"

#include <type_traits>
#include <utility>

namespace ptet::build {

ChosenPredictor choose_predictor(Prediction prediction, const WorkingComplex& complex,
                                 const std::vector<Point>& positions, const NormalizedFields& fields, double diagonal,
                                 std::vector<double> field_weight, double domain_weight, const MeshScales* whole) {
  const auto make = [&]<class P, class... Rest>(std::type_identity<P>, Rest... rest) {
    return std::make_unique<P>(complex, positions, fields, diagonal, std::move(field_weight), domain_weight, rest...);
  };
  const auto make_quadrics = [&](QuadricWeight weight) {
    auto quadrics = make(std::type_identity<QuadricPredictor>{}, weight, whole);
    const QuadricPredictor* const same = quadrics.get();
    return ChosenPredictor{std::move(quadrics), same};
  };
  switch (prediction) {
  case Prediction::kLocal: return {make(std::type_identity<LocalPredictor>{})};
  case Prediction::kGradient: return {make(std::type_identity<GradientPredictor>{})};
  case Prediction::kWeightedSum:
    return {make(std::type_identity<WeightedSumPredictor>{}, WeightedSumPredictor::Weights{}, whole)};
  case Prediction::kPerTet: return {make(std::type_identity<PerTetPredictor>{})};
  case Prediction::kQuadric: return make_quadrics(QuadricWeight::kRootOfVolume);
  case Prediction::kSimulate:
  case Prediction::kExact: break;
  }
  return make_quadrics(QuadricWeight::kVolume);
}

} // namespace ptet::build
