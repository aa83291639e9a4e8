#include "mesh/governing.hpp"

#include "mesh/number_text.hpp"
#include "mesh/value_offset.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

namespace ptet {

namespace {

/// A range so many times the distance between the quartiles is rather that of a fill value than that of the field.
constexpr double kOddRange = 1e6;
/// A value that several vertices have and that is so much of the range away from all others, which differ; of values
/// that stand for none as a rule less will do.
constexpr double kOddGap = 0.98, kOddGapOfUsual = 0.75;

bool is_usual_fill_value(double x) {
  constexpr std::array kUsual = {99.0, 999.0, 9999.0, 99999.0, 999999.0, 32767.0, 32768.0, 1e10, 1e20, 1e30};
  return std::find(kUsual.begin(), kUsual.end(), std::abs(x)) != kUsual.end();
}

/// How the first value by an order stands apart from the others, where it does.
template <class Before>
std::optional<std::string> far_first(const std::vector<double>& values, Before before) {
  const double first = *std::min_element(values.begin(), values.end(), before);
  const double last = *std::max_element(values.begin(), values.end(), before);
  std::size_t count = 0;
  double second = last;
  for (const double x : values) {
    if (x == first)
      ++count;
    else if (before(x, second))
      second = x;
  }
  const double gap = is_usual_fill_value(first) ? kOddGapOfUsual : kOddGap;
  if (count < 2 || second == last || !(std::abs(second - first) > gap * std::abs(last - first))) return std::nullopt;
  return grouped(count) + " are " + number_text(first) + ", all others from " + short_number(std::min(second, last)) +
         " to " + short_number(std::max(second, last));
}

} // namespace

std::optional<std::string> odd_range(std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  if (auto low = far_first(values, std::less<>())) return low;
  if (auto high = far_first(values, std::greater<>())) return high;
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  const double range = *greatest - *least;
  const auto quartile = [&](std::size_t quarters) {
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) * quarters / 4);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
  };
  const double first = quartile(1), between_quartiles = quartile(3) - first;
  if (!(between_quartiles > 0) || !(range > kOddRange * between_quartiles)) return std::nullopt;
  return "they range over " + short_number(range) + ", half of them within " + short_number(between_quartiles);
}

std::string fill_values_note(const std::string& name, const std::string& odd) {
  return "the values of '" + name + "' may have fill values among them (" + odd +
         "): fractions of the range mean nothing then; give errors in the units of the field, or replace these values";
}

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
