// The methods of a build by name.
#pragma once

#include "ptet/build.hpp"

#include <array>

namespace ptet::cli {

struct Method {
  const char* name;
  Prediction prediction;
  Evaluation evaluation;
};
/// The paper's names, what is compared with it, and ours.
inline constexpr std::array<Method, 8> kMethods{{
    {"exact", Prediction::kExact, Evaluation::kExact},
    {"LN", Prediction::kLocal, Evaluation::kNone},
    {"GN", Prediction::kGradient, Evaluation::kNone},
    {"QN", Prediction::kQuadric, Evaluation::kNone},
    {"BF", Prediction::kSimulate, Evaluation::kVertices},
    {"BFS", Prediction::kSimulate, Evaluation::kSamples},
    {"staadt-gross", Prediction::kWeightedSum, Evaluation::kNone},
    {"trotts", Prediction::kPerTet, Evaluation::kNone},
}};

/// The name of the method that predicts and evaluates so; null for a mixture of one's own.
[[nodiscard]] inline const char* method_of(const BuildOptions& options) {
  for (const Method& method : kMethods)
    if (method.prediction == options.prediction && method.evaluation == options.evaluation) return method.name;
  return nullptr;
}

/// Whether collapses are tried to tell what they cost; only then does the objective matter.
[[nodiscard]] inline bool simulates(const BuildOptions& options) {
  return options.prediction == Prediction::kSimulate || options.prediction == Prediction::kExact;
}

} // namespace ptet::cli
