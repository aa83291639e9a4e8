#include "formats/vtk/mean_point.hpp"

#include "mesh/scalar_dispatch.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace ptet::vtkio {
namespace {

/// a - b, exact where it is small.
template <class T>
double difference(T a, T b) {
  if constexpr (std::is_integral_v<T> && sizeof(T) == 8) {
    using Unsigned = std::make_unsigned_t<T>; // the difference may pass a T
    return a >= b ? static_cast<double>(static_cast<Unsigned>(a) - static_cast<Unsigned>(b))
                  : -static_cast<double>(static_cast<Unsigned>(b) - static_cast<Unsigned>(a));
  } else {
    return static_cast<double>(a) - static_cast<double>(b);
  }
}

/// first + difference, which lies between 0 and that of another value.
template <class T>
T moved_by(T first, double by) {
  if constexpr (std::is_integral_v<T>) {
    using Unsigned = std::make_unsigned_t<T>;
    const auto steps = static_cast<Unsigned>(std::abs(std::round(by)));
    return static_cast<T>(by < 0 ? static_cast<Unsigned>(first) - steps : static_cast<Unsigned>(first) + steps);
  } else {
    return static_cast<T>(static_cast<double>(first) + by);
  }
}

/// Of the rows of one component, from the first on: of equal numbers it is that number, in every bit of an integer.
template <class T>
T mean_of(const PointArray& array, std::uint32_t component, const MeanPoint& mean) {
  const auto value = [&](std::size_t i) {
    return load<T>(array.bytes.data() + mean.points[i].index() * array.row_bytes() + component * sizeof(T));
  };
  const T first = value(0);
  T least = first, greatest = first;
  double sum = 0;
  for (std::size_t i = 0; i < mean.points.size(); ++i) {
    least = std::min(least, value(i));
    greatest = std::max(greatest, value(i));
    sum += mean.weights[i] * difference(value(i), first);
  }
  if constexpr (std::is_floating_point_v<T>) {
    if (least == greatest) return first;
    if (!std::isfinite(sum)) { // infinities, or numbers too far apart
      double all = 0;
      for (std::size_t i = 0; i < mean.points.size(); ++i)
        if (mean.weights[i] > 0) all += mean.weights[i] * static_cast<double>(value(i));
      return static_cast<T>(all);
    }
  }
  if (sum >= difference(greatest, first)) return greatest;
  if (sum <= difference(least, first)) return least;
  return std::clamp(moved_by(first, sum), least, greatest);
}

} // namespace

Point position_of(const MeanPoint& mean, const PointArray& positions) {
  Point at{};
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    at[axis] = dispatch(positions.type,
                        [&](auto type) { return static_cast<double>(mean_of<decltype(type)>(positions, axis, mean)); });
  return at;
}

void append_mean(PointArray& array, const MeanPoint& mean) {
  const std::size_t row = array.bytes.size();
  array.bytes.resize(row + array.row_bytes());
  for (std::uint32_t c = 0; c < array.components; ++c)
    dispatch(array.type, [&](auto type) {
      using T = decltype(type);
      store<T>(array.bytes.data() + row + c * sizeof(T), mean_of<T>(array, c, mean));
    });
}

} // namespace ptet::vtkio
