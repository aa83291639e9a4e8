#include "error/field_values.hpp"

#include "error/power_of_two.hpp"
#include "mesh/value_offset.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {
namespace {

/// Up to this unit what is lost of a value is at most 2^-1074 times this, and far below what any error code tells.
constexpr double kHarmlessUnit = 0x1p500;

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
    const double unit = power_of_two_below(ranges[f]);
    scale_.push_back(unit / ranges[f]);
    for (std::uint32_t component = 0; component < array.components; ++component, ++channel) {
      if (vertices == 0) continue;
      const ValueOffset offset(array, 0, component);
      for (std::uint32_t v = 0; v < vertices; ++v) {
        const double value = offset.value(array, v, component);
        const double scaled = value / unit;
        values_[v * channels + channel] = scaled;
        if ((unit > kHarmlessUnit && scaled * unit != value) || !std::isfinite(scaled))
          first_losing_digits_ = std::min(first_losing_digits_, f);
      }
    }
  }
}

} // namespace ptet
