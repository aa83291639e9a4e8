// One of each way to predict, and of each to evaluate.
#pragma once

#include "ptet/build.hpp"

#include <array>
#include <utility>

namespace ptet::test {

inline constexpr std::array<std::pair<Prediction, Evaluation>, 9> kMethods = {
    {{Prediction::kExact, Evaluation::kExact},
     {Prediction::kQuadric, Evaluation::kNone},
     {Prediction::kQuadric, Evaluation::kExact},
     {Prediction::kSimulate, Evaluation::kVertices},
     {Prediction::kSimulate, Evaluation::kSamples},
     {Prediction::kLocal, Evaluation::kVertices},
     {Prediction::kGradient, Evaluation::kNone},
     {Prediction::kPerTet, Evaluation::kNone},
     {Prediction::kWeightedSum, Evaluation::kVertices}}};

} // namespace ptet::test
