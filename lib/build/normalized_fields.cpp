#include "build/normalized_fields.hpp"

#include "error/channels.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>

namespace ptet::build {
namespace {

std::vector<std::uint32_t> governing_arrays(const TetMesh& mesh, const std::vector<std::string>& names) {
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
  if (!names.empty()) return chosen;
  for (std::uint32_t i = 0; i < arrays.size(); ++i)
    if (arrays[i].type == ScalarType::kFloat32 || arrays[i].type == ScalarType::kFloat64) chosen.push_back(i);
  if (chosen.empty())
    for (std::uint32_t i = 0; i < arrays.size(); ++i)
      chosen.push_back(i);
  return chosen;
}

/// Diagonal of the box of values over the used vertices; for one component the range.
double range_of(const PointArray& array, const PreparedMesh& prepared) {
  double range = 0;
  for (std::uint32_t component = 0; component < array.components; ++component) {
    double low = 0;
    double high = 0;
    for (std::uint32_t v = 0; v < prepared.used_vertex_count; ++v) {
      const double value = array.value(v, component);
      if (!std::isfinite(value))
        throw Error(ErrorCode::kBadInput, "field '" + array.name + "' is not finite at vertex " +
                                              std::to_string(prepared.original_vertex[v].index()) +
                                              ": leave it out of the governing fields by naming the "
                                              "others, or mend it");
      low = v == 0 ? value : std::min(low, value);
      high = v == 0 ? value : std::max(high, value);
    }
    range = std::hypot(range, high - low);
  }
  if (!std::isfinite(range))
    throw Error(ErrorCode::kBadInput, "the range of field '" + array.name + "' passes what a double can hold");
  return range;
}

} // namespace

NormalizedFields::NormalizedFields(const PreparedMesh& prepared, const std::vector<std::string>& names,
                                   const std::vector<double>* ranges) {
  const TetMesh& mesh = prepared.mesh;
  for (const std::uint32_t index : governing_arrays(mesh, names)) {
    const PointArray& array = mesh.point_arrays[index];
    const double range = ranges != nullptr ? ranges->at(fields_.size()) : range_of(array, prepared);
    // A constant field has no errors; any scale will do.
    fields_.push_back({index, range > 0 ? range : 1.0});
    for (std::uint32_t component = 0; component < array.components; ++component)
      channel_field_.push_back(fields_.size() - 1);
  }
  const std::size_t channels = channel_field_.size();
  values_.resize(channels * prepared.used_vertex_count);
  std::size_t channel = 0;
  for (const GoverningField& field : fields_) {
    const PointArray& array = mesh.point_arrays[field.array];
    for (std::uint32_t component = 0; component < array.components; ++component, ++channel)
      write_channel(array, component, prepared.used_vertex_count, field.range, values_.data() + channel, channels);
  }
}

} // namespace ptet::build
