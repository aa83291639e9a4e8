#include "ptet/build.hpp"

namespace ptet {

std::string_view name_of(Prediction prediction) {
  static constexpr std::array<std::string_view, 7> kNames = {"local",   "gradient", "quadric", "weighted-sum",
                                                             "per-tet", "simulate", "exact"};
  return kNames.at(static_cast<std::size_t>(prediction));
}

std::string_view name_of(Evaluation evaluation) {
  static constexpr std::array<std::string_view, 4> kNames = {"none", "vertices", "samples", "exact"};
  return kNames.at(static_cast<std::size_t>(evaluation));
}

std::string_view name_of(Objective objective) {
  static constexpr std::array<std::string_view, 3> kNames = {"max", "rms", "both"};
  return kNames.at(static_cast<std::size_t>(objective));
}

} // namespace ptet
