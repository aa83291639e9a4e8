#include "error/field_values.hpp"

#include "mesh/value_offset.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {
namespace {

/// Below this range what is lost of a value is less than 2^-1074 times this, and far below what any error code tells.
constexpr int kHarmlessExponent = 500;

} // namespace

FieldValues::FieldValues(const TetMesh& mesh, std::span<const std::uint32_t> arrays, std::span<const double> ranges,
                         std::uint32_t vertices)
    : first_losing_digits_(arrays.size()) {
  for (std::size_t f = 0; f < arrays.size(); ++f)
    field_of_.insert(field_of_.end(), mesh.point_arrays[arrays[f]].components, f);
  const std::size_t channels = field_of_.size();
  values_.resize(channels * vertices);
  std::size_t channel = 0;
  for (std::size_t f = 0; f < arrays.size(); ++f) {
    const PointArray& array = mesh.point_arrays[arrays[f]];
    const int exponent = std::ilogb(ranges[f]);
    scale_.push_back(std::ldexp(1.0, exponent) / ranges[f]);
    for (std::uint32_t component = 0; component < array.components; ++component, ++channel) {
      if (vertices == 0) continue;
      const ValueOffset offset(array, 0, component);
      for (std::uint32_t v = 0; v < vertices; ++v) {
        const double value = offset.value(array, v, component);
        const double scaled = std::ldexp(value, -exponent);
        values_[v * channels + channel] = scaled;
        if ((exponent > kHarmlessExponent && std::ldexp(scaled, exponent) != value) || !std::isfinite(scaled))
          first_losing_digits_ = std::min(first_losing_digits_, f);
      }
    }
  }
}

} // namespace ptet
