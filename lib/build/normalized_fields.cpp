#include "build/normalized_fields.hpp"

#include "mesh/governing.hpp"
#include "mesh/number_text.hpp"
#include "mesh/value_offset.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>

namespace ptet::build {
namespace {

/// Values that are so many times their spread away from 0 count from the least of them, which is exact there: products
/// of them, as quadrics have, would lose the digits of their differences.
constexpr double kFar = 16;

std::vector<std::uint32_t> governing_arrays(const TetMesh& mesh, const std::vector<std::string>& names) {
  if (names.empty()) return governing_by_default(mesh.point_arrays);
  std::vector<std::uint32_t> chosen;
  const auto& arrays = mesh.point_arrays;
  for (const std::string& name : names) {
    const PointArray* found = mesh.find(name);
    if (found == nullptr) {
      std::string known;
      for (const PointArray& array : arrays)
        known += (known.empty() ? "" : ", ") + ("'" + array.name + "'");
      throw Error(ErrorCode::kBadArgument,
                  "there is no field '" + name + "'; the mesh has " + (known.empty() ? "no point array" : known));
    }
    const auto index = static_cast<std::uint32_t>(found - arrays.data());
    if (std::find(chosen.begin(), chosen.end(), index) == chosen.end()) chosen.push_back(index);
  }
  return chosen;
}

/// Of one component over the used vertices. `note` gets what is odd about its values, where nothing is in it yet.
double spread_of(const PointArray& array, const PreparedMesh& prepared, std::uint32_t component, std::string& note) {
  std::vector<double> values(prepared.used_vertex_count);
  if (values.empty()) return 0;
  const ValueOffset offset(array, 0, component);
  for (std::uint32_t v = 0; v < values.size(); ++v) {
    values[v] = offset.value(array, v, component);
    if (!std::isfinite(values[v]))
      throw Error(ErrorCode::kBadInput, "field '" + array.name + "' is not finite at vertex " +
                                            std::to_string(prepared.original_vertex[v].index()) +
                                            ": leave it out of the governing fields by naming the "
                                            "others, or mend it");
  }
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double range = *high - *low;
  if (spans_too_far(array, range))
    throw Error(ErrorCode::kBadInput, "the integers of field '" + array.name +
                                          "' span 2^53 or more, its errors cannot be measured: leave it out of the "
                                          "governing fields by naming the others, or give it as float64");
  if (note.empty() && !has_wide_integers(array)) // those are without their offset
    if (const auto odd = odd_range(values)) note = fill_values_note(array.name, *odd);
  return range;
}

/// range_of() the used vertices, or an Error that says why errors of this field cannot be measured.
double checked_range(const PointArray& array, const PreparedMesh& prepared, std::vector<std::string>& notes) {
  double range = 0;
  std::string note; // one for all components
  for (std::uint32_t component = 0; component < array.components; ++component)
    range = std::hypot(range, spread_of(array, prepared, component, note));
  if (!note.empty()) notes.push_back(std::move(note));
  if (!std::isfinite(range))
    throw Error(ErrorCode::kBadInput,
                "the range of field '" + array.name +
                    "' passes what a double can hold: give its values in another unit, or build with other "
                    "fields");
  return range;
}

} // namespace

NormalizedFields::NormalizedFields(const PreparedMesh& prepared, const std::vector<std::string>& names,
                                   const std::vector<double>* ranges) {
  const TetMesh& mesh = prepared.mesh;
  for (const std::uint32_t index : governing_arrays(mesh, names)) {
    const PointArray& array = mesh.point_arrays[index];
    fields_.push_back({index, ranges != nullptr ? ranges->at(fields_.size()) : checked_range(array, prepared, notes_)});
  }
  std::vector<std::uint32_t> arrays;
  std::vector<double> scales;
  for (const GoverningField& field : fields_) {
    arrays.push_back(field.array);
    scales.push_back(field.scale());
  }
  exact_ = FieldValues(mesh, arrays, scales, prepared.used_vertex_count);
  if (const std::size_t f = exact_.first_losing_digits(); f < fields_.size())
    throw Error(ErrorCode::kBadInput, "the values of field '" + mesh.point_arrays[fields_[f].array].name +
                                          "' range over " + short_number(fields_[f].range) +
                                          ", and some are too small or too great beside that to be computed with: "
                                          "take a common offset off, or replace fill values");
  const std::size_t channels = channel_count();
  values_.resize(channels * prepared.used_vertex_count);
  std::size_t channel = 0;
  for (const GoverningField& field : fields_) {
    const PointArray& array = mesh.point_arrays[field.array];
    for (std::uint32_t component = 0; component < array.components; ++component, ++channel) {
      if (prepared.used_vertex_count == 0) continue;
      const ValueOffset offset(array, 0, component);
      double low = offset.value(array, 0, component), high = low;
      for (std::uint32_t v = 0; v < prepared.used_vertex_count; ++v) {
        const double value = values_[v * channels + channel] = offset.value(array, v, component);
        low = std::min(low, value);
        high = std::max(high, value);
      }
      const double origin = std::min(std::abs(low), std::abs(high)) >= kFar * (high - low) ? low : 0;
      for (std::uint32_t v = 0; v < prepared.used_vertex_count; ++v) {
        double& value = values_[v * channels + channel];
        value = (value - origin) / field.scale();
      }
    }
  }
}

} // namespace ptet::build
