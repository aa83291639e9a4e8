#include "build/describe_options.hpp"

#include "mesh/number_text.hpp"

namespace ptet::build {
namespace {

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
  described.emplace_back("min-quality", number_text(options.min_quality));
  described.emplace_back("predict", name_of(options.prediction));
  described.emplace_back("evaluate", name_of(options.evaluation));
  // Other predictions do not ask for it.
  if (options.prediction == Prediction::kSimulate || options.prediction == Prediction::kExact)
    described.emplace_back("objective", name_of(options.objective));
  described.emplace_back("max-star", std::to_string(options.max_star));
  described.emplace_back("round-fraction", number_text(round_fraction_of(options)));
  if (options.weld) described.emplace_back("weld", "yes");
  if (options.keep_order) described.emplace_back("keep-order", "yes");
  if (options.pieces > 1) described.emplace_back("pieces", std::to_string(options.pieces));
  return described;
}

double round_fraction_of(const BuildOptions& options) {
  // Rounds half as large have better mean squares. They are paid for where few of the candidates that are measured are
  // put back.
  return options.round_fraction.value_or(options.prediction == Prediction::kExact ? 0.15 : 0.3);
}

} // namespace ptet::build
