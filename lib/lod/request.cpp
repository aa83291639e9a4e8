#include "lod/request.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {
namespace {

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::kBadArgument, why);
}

void check_bound(const Bound& bound, const std::string& what) {
  if (!(bound.value >= 0) || !std::isfinite(bound.value))
    refuse("the bound on " + what + " is " + std::to_string(bound.value) +
           "; it must be a number that is not negative");
}

void check_region(const Box& box) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!std::isfinite(box.min[i]) || !std::isfinite(box.max[i])) refuse("a corner of a focus box is not finite");
    if (box.min[i] > box.max[i])
      refuse("a focus box is empty: its least " + std::string(1, "xyz"[i]) + " is above its greatest");
  }
}

void check_region(const Sphere& sphere) {
  for (const double x : sphere.centre)
    if (!std::isfinite(x)) refuse("the centre of a focus sphere is not finite");
  if (!(sphere.radius >= 0) || !std::isfinite(sphere.radius))
    refuse("the radius of a focus sphere is " + std::to_string(sphere.radius) +
           "; it must be a number that is not negative");
}

std::vector<const file::ArrayInfo*> governing_arrays(const file::Header& header) {
  std::vector<const file::ArrayInfo*> governing;
  for (const file::ArrayInfo& array : header.arrays)
    if (array.governing) governing.push_back(&array);
  return governing;
}

void apply_field_bound(const FieldBound& asked, const file::Header& header, CodeLimits& limits) {
  check_bound(asked.bound, asked.field.empty() ? "the fields" : "field '" + asked.field + "'");
  const auto governing = governing_arrays(header);
  bool found = asked.field.empty();
  for (std::size_t i = 0; i < governing.size(); ++i) {
    if (!asked.field.empty() && governing[i]->name != asked.field) continue;
    found = true;
    limits[i] = std::min(limits[i], limit_of(asked.bound.absolute(governing[i]->range), governing[i]->range));
  }
  if (found) return;
  for (const file::ArrayInfo& array : header.arrays)
    if (array.name == asked.field)
      refuse("field '" + asked.field + "' has no errors in this file: it did not govern the build");
  refuse("there is no field '" + asked.field + "' in this file");
}

CodeLimits focus_limits(const Bound& bound, const file::Header& header) {
  check_bound(bound, "the error in the focus");
  if (bound.value == 0) return {};
  CodeLimits limits;
  // What an absolute bound is as a fraction differs from field to field; the domain takes the least.
  double domain_fraction = bound.relative ? bound.value : INFINITY;
  for (const file::ArrayInfo* array : governing_arrays(header)) {
    limits.push_back(limit_of(bound.absolute(array->range), array->range));
    if (!bound.relative && array->range > 0) domain_fraction = std::min(domain_fraction, bound.value / array->range);
  }
  limits.push_back(std::isfinite(domain_fraction) ? limit_of(domain_fraction * header.diagonal, header.diagonal)
                                                  : ErrorCode16{0});
  return limits;
}

} // namespace

ErrorCode16 limit_of(double bound, double scale) {
  const ErrorCode16 code = encode_error(bound, scale);
  return code > 0 && decode_error(code, scale) > bound ? static_cast<ErrorCode16>(code - 1) : code;
}

ResolvedRequest resolve(const Request& request, const file::Header& header) {
  ResolvedRequest resolved;
  if (!request.field_error.empty() || request.domain_error) {
    resolved.limits.assign(governing_arrays(header).size() + 1, kMaxErrorCode);
    for (const FieldBound& bound : request.field_error)
      apply_field_bound(bound, header, resolved.limits);
    if (request.domain_error) {
      check_bound(*request.domain_error, "the domain error");
      resolved.limits.back() = limit_of(request.domain_error->absolute(header.diagonal), header.diagonal);
    }
  }
  for (const FocusRegion& region : request.focus)
    std::visit([](const auto& shape) { check_region(shape); }, region);
  resolved.focus = request.focus;
  resolved.focus_limits = focus_limits(request.focus_error, header);
  resolved.max_tets = request.max_tets;
  resolved.max_vertices = request.max_vertices;
  resolved.origins = request.origins;
  return resolved;
}

} // namespace ptet
