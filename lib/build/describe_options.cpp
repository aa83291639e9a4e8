#include "build/describe_options.hpp"

#include "mesh/number_text.hpp"
#include "mesh/shape.hpp"

#include <algorithm>

namespace ptet::build {
namespace {

/// At most; see BuildOptions::min_quality.
constexpr double kMinQuality = 1e-3;
/// Flat layers, as along walls in a flow, are a small part of many meshes: a floor by the tets in the middle would keep
/// what is in them. On one of 92,000 tets, a third of them flatter than .02, the mean square errors of coarse meshes
/// are then 5 times as large. What is flatter yet is most often by chance, and nothing to go by. Where more are flatter
/// than a thousandth of the median, they are so by chance, too, and that thousandth stands for them.
constexpr std::size_t kFlattestPart = 20;
constexpr double kOfMedian = 1e-3;
constexpr double kOfFlatQuality = 1.0 / 20;
/// The quality is that of so many tets, or some more, spread over the mesh.
constexpr std::size_t kTetsForQuality = 20'000;

/// That all tets have but the flattest twentieth; a thousandth of the median at least.
double flat_quality(const PreparedMesh& prepared) {
  const std::vector<Tet>& tets = prepared.mesh.tets;
  std::vector<double> qualities;
  for (std::size_t t = 0; t < tets.size(); t += std::max<std::size_t>(1, tets.size() / kTetsForQuality)) {
    const auto at = [&](std::size_t i) -> const Point& { return prepared.points[tets[t][i].index()]; };
    qualities.push_back(shape_quality(at(0), at(1), at(2), at(3)));
  }
  const auto all_above_part = [&](std::size_t part) {
    const auto at = qualities.begin() + static_cast<std::ptrdiff_t>(qualities.size() / part);
    std::nth_element(qualities.begin(), at, qualities.end());
    return *at;
  };
  // Of flat tets rounding makes less than 0.
  return std::max({0.0, all_above_part(kFlattestPart), kOfMedian * all_above_part(2)});
}

std::string text_of(const Bound& bound) {
  return bound.relative ? number_text(bound.value * 100) + "%" : number_text(bound.value);
}

} // namespace

std::vector<std::pair<std::string, std::string>>
describe_options(const BuildOptions& options, const PreparedMesh& prepared, const std::vector<GoverningField>& fields) {
  std::vector<std::pair<std::string, std::string>> described;
  described.reserve(fields.size() + options.max_field_error.size() + 8);
  for (const GoverningField& field : fields)
    described.emplace_back("field", prepared.mesh.point_arrays[field.array].name);
  for (const FieldBound& bound : options.max_field_error)
    described.emplace_back("max-field-error", (bound.field.empty() ? "" : bound.field + "=") + text_of(bound.bound));
  described.emplace_back("max-domain-error", text_of(options.max_domain_error));
  described.emplace_back("target-vertices", number_text(options.target_vertices));
  described.emplace_back("min-quality", number_text(min_quality_of(options, prepared)));
  described.emplace_back("predict", name_of(options.prediction));
  described.emplace_back("evaluate", name_of(options.evaluation));
  // Other predictions do not ask for it.
  if (options.prediction == Prediction::kSimulate || options.prediction == Prediction::kExact)
    described.emplace_back("objective", name_of(options.objective));
  described.emplace_back("max-star", std::to_string(options.max_star));
  described.emplace_back("round-fraction", number_text(options.round_fraction));
  if (options.weld) described.emplace_back("weld", "yes");
  // As it is used, so that the same points are welded once more: what a percentage says differs by its rounding.
  if (options.weld && options.weld->value > 0)
    described.emplace_back("weld-within",
                           number_text(options.weld->value) + (options.weld->relative ? " of the diagonal" : ""));
  if (options.keep_order) described.emplace_back("keep-order", "yes");
  if (options.pieces > 1) described.emplace_back("pieces", std::to_string(options.pieces));
  return described;
}

double min_quality_of(const BuildOptions& options, const PreparedMesh& prepared) {
  if (options.min_quality) return *options.min_quality;
  return std::min(kMinQuality, kOfFlatQuality * flat_quality(prepared));
}

} // namespace ptet::build
