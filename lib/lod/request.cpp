#include "lod/request.hpp"

#include "mesh/number_text.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {
namespace {

using namespace vec;

[[noreturn]] void refuse_request(const std::string& why) {
  throw Error(ErrorCode::kBadArgument, why);
}

/// `what` is said of a bound that is none; `name` may follow it.
void check_bound(const Bound& bound, const char* what, const std::string& name = {}) {
  if (!(bound.value >= 0) || !std::isfinite(bound.value))
    refuse_request("the bound on " + std::string(what) + (name.empty() ? "" : " '" + name + "'") + " is " +
                   number_text(bound.value) + "; it must be finite and not negative");
}

// ---- regions ----

Region checked(const Box& box) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!std::isfinite(box.min[i]) || !std::isfinite(box.max[i]))
      refuse_request("a corner of a focus box is not finite");
    if (box.min[i] > box.max[i])
      refuse_request("a focus box is empty: its least " + std::string(1, "xyz"[i]) + " is above its greatest");
  }
  return box;
}

Region checked(const OrientedBox& box) {
  if (!is_finite(box.centre)) refuse_request("the centre of an oriented focus box is not finite");
  constexpr double kAskew = 1e-6;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!is_finite(box.half_axes[i])) refuse_request("a half axis of an oriented focus box is not finite");
    const auto a = direction_of(box.half_axes[i]), b = direction_of(box.half_axes[(i + 1) % 3]);
    if (a && b && std::fabs(dot(*a, *b)) > kAskew)
      refuse_request("the half axes of an oriented focus box are not perpendicular to one another");
  }
  return box;
}

Region checked(const Sphere& sphere) {
  if (!is_finite(sphere.centre)) refuse_request("the centre of a focus sphere is not finite");
  if (!(sphere.radius >= 0) || !std::isfinite(sphere.radius))
    refuse_request("the radius of a focus sphere is " + number_text(sphere.radius) +
                   "; it must be finite and not negative");
  return sphere;
}

/// With a normal of length 1.
Region checked(const HalfSpace& half_space) {
  const auto normal = direction_of(half_space.normal);
  if (!normal) refuse_request("the normal of a focus half-space has no direction");
  // By a power of two, so that the length of the normal is a number, and nothing else changes.
  const double largest =
      std::max({std::abs(half_space.normal[0]), std::abs(half_space.normal[1]), std::abs(half_space.normal[2])});
  const int exponent = std::ilogb(largest);
  const Point scaled{std::ldexp(half_space.normal[0], -exponent), std::ldexp(half_space.normal[1], -exponent),
                     std::ldexp(half_space.normal[2], -exponent)};
  const double offset = std::ldexp(half_space.offset, -exponent) / dot(scaled, *normal);
  if (!std::isfinite(offset)) refuse_request("the offset of a focus half-space is not finite");
  return HalfSpace{*normal, offset};
}

// ---- fields ----

/// The fields with errors, in the order of the codes; the file's array each is.
PerCode<std::size_t> governing_arrays(const file::Header& header) {
  PerCode<std::size_t> governing;
  for (std::size_t i = 0; i < header.arrays.size(); ++i)
    if (header.arrays[i].governing) governing.push_back(i);
  return governing;
}

/// By code what it is a fraction of: the fields' ranges and the diagonal.
PerCode<double> scales(const file::Header& header) {
  PerCode<double> all;
  for (const std::size_t array : governing_arrays(header))
    all.push_back(header.arrays[array].range);
  all.push_back(header.diagonal);
  return all;
}

/// The place of a field among the codes.
std::size_t code_of(const std::string& field, const file::Header& header) {
  const auto governing = governing_arrays(header);
  for (std::size_t i = 0; i < governing.size(); ++i)
    if (header.arrays[governing[i]].name == field) return i;
  for (const file::ArrayInfo& array : header.arrays)
    if (array.name == field)
      refuse_request("field '" + field + "' has no errors in this file: it did not govern the build");
  std::string known;
  for (const std::size_t i : governing)
    known += (known.empty() ? "'" : ", '") + header.arrays[i].name + "'";
  refuse_request("there is no field '" + field + "' in this file; " +
                 (known.empty() ? "none has errors" : "those with errors are " + known));
}

void apply_field_bound(const FieldBound& asked, double factor, const file::Header& header, CodeLimits& limits) {
  check_bound(asked.bound, asked.field.empty() ? "the fields" : "field", asked.field);
  const PerCode<double> scale = scales(header);
  const std::size_t begin = asked.field.empty() ? 0 : code_of(asked.field, header);
  const std::size_t end = asked.field.empty() ? scale.size() - 1 : begin + 1;
  for (std::size_t i = begin; i < end; ++i)
    limits[i] = std::min(limits[i], limit_of(asked.bound.absolute(scale[i]) * factor, scale[i]));
}

/// The bounds over the whole domain, each so many times as large.
CodeLimits global_limits(const Request& request, double factor, const file::Header& header) {
  CodeLimits limits(scales(header).size(), kMaxErrorCode);
  for (const FieldBound& bound : request.field_error)
    apply_field_bound(bound, factor, header, limits);
  if (request.domain_error) {
    check_bound(*request.domain_error, "the domain error");
    limits.back() = limit_of(request.domain_error->absolute(header.diagonal) * factor, header.diagonal);
  }
  return limits;
}

/// A bound for every field brought to absolute numbers by code. What an absolute one is as a fraction differs from
/// field to field; the domain takes the least.
PerCode<double> absolute_by_code(const Bound& bound, const file::Header& header) {
  PerCode<double> by_code;
  double domain_fraction = bound.relative ? bound.value : INFINITY;
  const PerCode<double> scale = scales(header);
  for (std::size_t i = 0; i + 1 < scale.size(); ++i) {
    by_code.push_back(bound.absolute(scale[i]));
    if (!bound.relative && scale[i] > 0) domain_fraction = std::min(domain_fraction, bound.value / scale[i]);
  }
  by_code.push_back(std::isfinite(domain_fraction) ? domain_fraction * header.diagonal : 0);
  return by_code;
}

// ---- what is wanted ----

WantInside inside(const Region& region, const Focus& focus, const file::Header& header) {
  check_bound(focus.error, "the error in the focus");
  WantInside want{region, {}, header.diagonal};
  if (focus.error.value == 0) return want;
  const PerCode<double> allowed = absolute_by_code(focus.error, header), scale = scales(header);
  for (std::size_t i = 0; i < allowed.size(); ++i)
    want.limits.push_back(limit_of(allowed[i], scale[i]));
  return want;
}

WantNear near(const Region& region, const Focus& focus, const file::Header& header) {
  check_bound(*focus.falloff, "the falloff of the focus");
  WantNear want{region, absolute_by_code(focus.error, header), absolute_by_code(*focus.falloff, header),
                scales(header)};
  for (double& slope : want.per_distance)
    slope = header.diagonal > 0 ? slope / header.diagonal : 0;
  return want;
}

Interval interval(const ValuesOfInterest& values, const file::Header& header) {
  const std::size_t code = code_of(values.field, header);
  if (std::isnan(values.min) || std::isnan(values.max))
    refuse_request("a value of interest of '" + values.field + "' is not a number");
  if (values.min > values.max || values.min == INFINITY || values.max == -INFINITY)
    refuse_request("the interval of values of '" + values.field + "' is empty: " + number_text(values.min) + " to " +
                   number_text(values.max));
  return {governing_arrays(header)[code], code, scales(header)[code], values.min, values.max};
}

Camera camera(const View& view) {
  if (!is_finite(view.eye)) refuse_request("the eye of the view is not finite");
  const auto direction = direction_of(view.direction), up = direction_of(view.up);
  if (!direction || !up)
    refuse_request(std::string(direction ? "the up" : "the viewing") + " direction of the view has none");
  constexpr double kParallel = 1e-9;
  if (norm(cross(*direction, *up)) < kParallel) refuse_request("the view's up is parallel to its direction");
  if (!(view.vertical_angle > 0 && view.vertical_angle < M_PI))
    refuse_request("the vertical angle of the view is " + number_text(view.vertical_angle) +
                   " radians; it must be above 0 and below pi");
  if (view.width == 0 || view.height == 0) refuse_request("the picture of the view has no pixels");
  if (!(view.max_pixels >= 0) || !std::isfinite(view.max_pixels))
    refuse_request("the error of the view is " + number_text(view.max_pixels) +
                   " pixels; it must be finite and not negative");
  if (!(view.outside >= 1))
    refuse_request("the factor outside the view is " + number_text(view.outside) + "; it must be at least 1");
  return Camera(view);
}

WantBounded bounded(const Request& request, const ResolvedRequest& resolved, const file::Header& header) {
  WantBounded want;
  if (!request.field_error.empty() || request.domain_error || request.view)
    want.limits = global_limits(request, 1, header);
  want.values = resolved.values;
  want.camera = resolved.camera;
  want.domain_scale = header.diagonal;
  if (request.view) {
    want.max_pixels = request.view->max_pixels;
    if (std::isfinite(request.view->outside)) {
      want.max_pixels_unseen = request.view->max_pixels * request.view->outside;
      want.limits_unseen = global_limits(request, request.view->outside, header);
    }
  }
  return want;
}

void add_focus(const Focus& focus, const file::Header& header, ResolvedRequest& resolved) {
  const Region region = std::visit([](const auto& shape) { return checked(shape); }, focus.region);
  resolved.focus.push_back({region, focus.error.value == 0});
  resolved.demand.promised.add(inside(region, focus, header));
  if (focus.falloff) resolved.demand.wished.add(near(region, focus, header));
}

Budgets budgets(const Request& request) {
  Budgets budgets{request.max_tets, request.max_vertices, request.max_bytes, {}};
  if (request.max_milliseconds) {
    if (!(*request.max_milliseconds >= 0) || !std::isfinite(*request.max_milliseconds))
      refuse_request("the time allowed is " + number_text(*request.max_milliseconds) +
                     " milliseconds; it must be finite and not negative");
    budgets.max_seconds = *request.max_milliseconds / 1000;
  }
  return budgets;
}

} // namespace

ErrorCode16 limit_of(double bound, double scale) {
  ErrorCode16 least = 0, most = kMaxErrorCode;
  while (least < most) {
    const auto middle = static_cast<ErrorCode16>(least + (most - least + 1) / 2);
    if (decode_error(middle, scale) <= bound)
      least = middle;
    else
      most = static_cast<ErrorCode16>(middle - 1);
  }
  return least;
}

ResolvedRequest resolve(const Request& request, const file::Header& header) {
  ResolvedRequest resolved;
  resolve(request, header, resolved);
  return resolved;
}

void resolve(const Request& request, const file::Header& header, ResolvedRequest& resolved) {
  resolved.budgets = budgets(request);
  resolved.origins = request.origins;
  Demand& demand = resolved.demand;
  demand.promised.clear();
  demand.wished.clear();
  resolved.focus.clear();
  for (std::size_t i = 0; i < request.focus.size(); ++i) {
    try {
      add_focus(request.focus[i], header, resolved);
    } catch (const Error& error) {
      if (request.focus.size() == 1) throw;
      refuse_request("focus[" + std::to_string(i) + "]: " + error.what());
    }
  }
  resolved.values.clear();
  for (const ValuesOfInterest& values : request.values)
    resolved.values.push_back(interval(values, header));
  resolved.camera.reset();
  if (request.view) resolved.camera = camera(*request.view);

  const bool has_bounds =
      !request.field_error.empty() || request.domain_error || !request.values.empty() || request.view;
  if (has_bounds) demand.wished.add(bounded(request, resolved, header));
  // A budget is spent on what is asked outside the focus, and where nothing is, on everything.
  if (demand.wished.empty() && (resolved.budgets.limits_size() || request.focus.empty())) demand.wished.add(WantAll{});
  resolved.when_met = has_bounds ? LimitedBy::kError : LimitedBy::kFocus;
}

} // namespace ptet
