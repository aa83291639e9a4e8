#include "mesh/governing.hpp"

#include "mesh/value_offset.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace ptet {

std::vector<std::uint32_t> governing_by_default(const std::vector<PointArray>& arrays) {
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < arrays.size(); ++i)
    if (arrays[i].type == ScalarType::kFloat32 || arrays[i].type == ScalarType::kFloat64) chosen.push_back(i);
  if (!chosen.empty()) return chosen;
  chosen.resize(arrays.size());
  std::iota(chosen.begin(), chosen.end(), 0U);
  return chosen;
}

double range_of(const PointArray& array, const std::vector<char>& used) {
  const auto first = std::find(used.begin(), used.end(), 1);
  if (first == used.end()) return 0;
  double diagonal = 0;
  for (std::uint32_t component = 0; component < array.components; ++component) {
    const ValueOffset offset(array, static_cast<std::size_t>(first - used.begin()), component);
    double least = std::numeric_limits<double>::infinity(), greatest = -least;
    for (std::size_t row = 0; row < used.size(); ++row) {
      if (used[row] == 0) continue;
      const double value = offset.value(array, row, component);
      if (!std::isfinite(value)) continue;
      least = std::min(least, value);
      greatest = std::max(greatest, value);
    }
    if (least > greatest) continue; // none is finite
    if (spans_too_far(array, greatest - least)) return std::numeric_limits<double>::infinity();
    diagonal = std::hypot(diagonal, greatest - least);
  }
  return diagonal;
}

} // namespace ptet
