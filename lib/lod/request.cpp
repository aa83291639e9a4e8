#include "lod/request.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {
namespace {

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::kBadArgument, why);
}

bool is_valid(const Bound& bound) {
  return bound.value >= 0 && std::isfinite(bound.value);
}

void check_bound(const Bound& bound, const char* what) {
  if (!is_valid(bound))
    refuse("the bound on " + std::string(what) + " is " + std::to_string(bound.value) +
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

template <class F>
void for_each_governing(const file::Header& header, F&& f) {
  std::size_t i = 0;
  for (const file::ArrayInfo& array : header.arrays)
    if (array.governing) f(array, i++);
}

std::size_t governing_count(const file::Header& header) {
  return static_cast<std::size_t>(
      std::count_if(header.arrays.begin(), header.arrays.end(), [](const auto& array) { return array.governing; }));
}

void apply_field_bound(const FieldBound& asked, const file::Header& header, CodeLimits& limits) {
  if (!is_valid(asked.bound))
    check_bound(asked.bound, asked.field.empty() ? "the fields" : ("field '" + asked.field + "'").c_str());
  bool found = asked.field.empty();
  for_each_governing(header, [&](const file::ArrayInfo& array, std::size_t i) {
    if (!asked.field.empty() && array.name != asked.field) return;
    found = true;
    limits[i] = std::min(limits[i], limit_of(asked.bound.absolute(array.range), array.range));
  });
  if (found) return;
  for (const file::ArrayInfo& array : header.arrays)
    if (array.name == asked.field)
      refuse("field '" + asked.field + "' has no errors in this file: it did not govern the build");
  refuse("there is no field '" + asked.field + "' in this file");
}

void find_focus_limits(const Bound& bound, const file::Header& header, CodeLimits& limits) {
  check_bound(bound, "the error in the focus");
  limits.clear();
  if (bound.value == 0) return;
  // What an absolute bound is as a fraction differs from field to field; the domain takes the least.
  double domain_fraction = bound.relative ? bound.value : INFINITY;
  for_each_governing(header, [&](const file::ArrayInfo& array, std::size_t) {
    limits.push_back(limit_of(bound.absolute(array.range), array.range));
    if (!bound.relative && array.range > 0) domain_fraction = std::min(domain_fraction, bound.value / array.range);
  });
  limits.push_back(std::isfinite(domain_fraction) ? limit_of(domain_fraction * header.diagonal, header.diagonal)
                                                  : ErrorCode16{0});
}

} // namespace

ErrorCode16 limit_of(double bound, double scale) {
  const ErrorCode16 code = encode_error(bound, scale);
  return code > 0 && decode_error(code, scale) > bound ? static_cast<ErrorCode16>(code - 1) : code;
}

ResolvedRequest resolve(const Request& request, const file::Header& header) {
  ResolvedRequest resolved;
  resolve(request, header, resolved);
  return resolved;
}

void resolve(const Request& request, const file::Header& header, ResolvedRequest& resolved) {
  resolved.limits.clear();
  if (!request.field_error.empty() || request.domain_error) {
    resolved.limits.assign(governing_count(header) + 1, kMaxErrorCode);
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
  find_focus_limits(request.focus_error, header, resolved.focus_limits);
  resolved.max_tets = request.max_tets;
  resolved.max_vertices = request.max_vertices;
  resolved.origins = request.origins;
}

} // namespace ptet
