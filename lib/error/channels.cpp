#include "error/channels.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {
namespace {

/// Values that are so many times their spread away from 0 count from the least. Subtracting that is exact then.
constexpr double kFar = 16;

} // namespace

void write_channel(const PointArray& array, std::uint32_t component, std::uint32_t vertices, double range, double* out,
                   std::size_t stride) {
  double low = 0, high = 0;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const double value = array.value(v, component);
    low = v == 0 ? value : std::min(low, value);
    high = v == 0 ? value : std::max(high, value);
  }
  const double origin = std::min(std::abs(low), std::abs(high)) >= kFar * (high - low) ? low : 0;
  for (std::uint32_t v = 0; v < vertices; ++v, out += stride)
    *out = (array.value(v, component) - origin) / range;
}

} // namespace ptet
