#include "build/error_limits.hpp"

#include "mesh/number_text.hpp"
#include "mesh/vec3.hpp"
#include "ptet/error.hpp"
#include "record/error_code.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ptet::build {
namespace {

/// Without thresholds from the user, a domain error of this fraction of the diagonal weighs as much as a field error
/// of the whole range.
constexpr double kDomainPerField = 1;
/// The same of a domain error that is measured: predictors see several times as much. What makes it large is most often
/// that faces stand for what they are far from, and others are nearer to: with less weight such collapses come early,
/// and what is stated of the boundary in coarse meshes is some times the truth; with more, fields pay for it, most of
/// all where they are smooth and the boundary is curved or thin.
constexpr double kMeasuredDomainPerField = 1.0 / 10;

/// The largest error that a file states as no more than `limit`, both in units of the scale: it rounds errors up.
double statable(double limit) {
  if (!std::isfinite(limit)) return limit;
  const ErrorCode16 code = encode_error(limit, 1);
  return std::min(limit, decode_error(decode_error(code, 1) > limit ? static_cast<ErrorCode16>(code - 1) : code, 1));
}

std::vector<double> field_limits(const PreparedMesh& prepared, const NormalizedFields& fields,
                                 const std::vector<FieldBound>& bounds) {
  std::vector<double> limits(fields.field_count(), std::numeric_limits<double>::infinity());
  for (const FieldBound& bound : bounds) {
    bool found = false;
    for (std::size_t f = 0; f < limits.size(); ++f) {
      const GoverningField& field = fields.fields()[f];
      if (!bound.field.empty() && prepared.mesh.point_arrays[field.array].name != bound.field) continue;
      limits[f] = std::min(limits[f], statable(bound.bound.absolute(field.range) / field.scale()));
      found = true;
    }
    if (!found && !bound.field.empty())
      throw Error(ErrorCode::kBadArgument, "a limit was given for '" + bound.field + "', which is no governing field");
  }
  return limits;
}

} // namespace

ErrorLimits::ErrorLimits(const PreparedMesh& prepared, const NormalizedFields& fields, const BuildOptions& options,
                         double diagonal)
    : field_(field_limits(prepared, fields, options.max_field_error)),
      domain_(diagonal > 0 ? statable(options.max_domain_error.absolute(diagonal) / diagonal) * diagonal : 0),
      diagonal_(diagonal) {}

bool ErrorLimits::bounds_fields() const {
  return std::any_of(field_.begin(), field_.end(), [](double x) { return std::isfinite(x); });
}

std::vector<double> ErrorLimits::field_weights() const {
  std::vector<double> weights;
  for (const double limit : field_)
    weights.push_back(std::isfinite(limit) && limit > 0 ? 1 / limit : 1.0);
  return weights;
}

double ErrorLimits::domain_weight() const {
  // With thresholds for fields, the corner of the growing square is (field limits, domain limit).
  return bounds_fields() && domain_ > 0 ? diagonal_ / domain_ : 1 / kDomainPerField;
}

double ErrorLimits::measured_domain_weight() const {
  if (bounds_fields() && domain_ > 0) return 1 / domain_;
  return diagonal_ > 0 ? 1 / (kMeasuredDomainPerField * diagonal_) : 0;
}

std::optional<std::string> flat_domain_note(const PreparedMesh& prepared, const MeshScales& scales,
                                            const BuildOptions& options) {
  double area = 0;
  for (const Face& face : prepared.boundary_faces) {
    using namespace vec;
    const Point a = prepared.points[face[0].index()];
    area += norm(cross(prepared.points[face[1].index()] - a, prepared.points[face[2].index()] - a)) / 2;
  }
  const double limit = options.max_domain_error.absolute(scales.diagonal);
  const double thickness = area > 0 ? 2 * scales.volume / area : 0;
  if (!(thickness > 0) || !(limit > thickness)) return std::nullopt;
  return "the boundary may move by up to " + short_number(limit) +
         " (--max-domain-error), and on the whole the domain is " + short_number(thickness) +
         " thick (twice its volume by the area of its boundary): a smaller limit, such as " +
         short_number(thickness / 4) + ", keeps the shape of coarse meshes, often at no cost";
}

} // namespace ptet::build
