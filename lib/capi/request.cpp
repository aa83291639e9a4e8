// ptet.h: requests.
#include "capi/guard.hpp"
#include "capi/handles.hpp"
#include "ptet/dataset.hpp"

#include <functional>
#include <new>
#include <optional>
#include <utility>

using namespace ptet;
using namespace ptet::capi;

namespace {

template <class Change>
ptet_status change(ptet_request* request, ptet_error** error, Change&& apply) noexcept {
  return guarded(error, [&] { apply(required(request, "the request").request); });
}

ptet_status add_region(ptet_request* request, ptet_error** error, const std::function<Region()>& region) noexcept {
  return guarded(error, [&] {
    ptet_request& to = required(request, "the request");
    to.request.focus.push_back({region(), to.focus_error, to.falloff});
  });
}

template <class Change>
ptet_status change_region(ptet_request* request, std::uint32_t region, ptet_error** error, Change&& apply) noexcept {
  return change(request, error, [&](Request& asked) {
    if (region >= asked.focus.size())
      refuse("there is no focus region " + std::to_string(region) + ": there are " +
             std::to_string(asked.focus.size()));
    apply(asked.focus[region]);
  });
}

Point point_at(const double* coordinates, const char* what) {
  (void)required(coordinates, what);
  return {coordinates[0], coordinates[1], coordinates[2]};
}

} // namespace

ptet_request* ptet_request_new(void) {
  return new (std::nothrow) ptet_request{};
}

void ptet_request_free(ptet_request* request) {
  delete request;
}

ptet_status ptet_request_clear(ptet_request* request, ptet_error** error) {
  return guarded(error, [&] { required(request, "the request") = {}; });
}

ptet_status ptet_request_add_field_error(ptet_request* request, const char* field, double value, int32_t relative,
                                         ptet_error** error) {
  return change(request, error, [&](Request& asked) {
    asked.field_error.push_back({text_or_empty(field), {value, relative != 0}});
  });
}

ptet_status ptet_request_set_domain_error(ptet_request* request, double value, int32_t relative, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.domain_error = Bound{value, relative != 0}; });
}

ptet_status ptet_request_set_max_tets(ptet_request* request, uint64_t tets, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.max_tets = tets; });
}

ptet_status ptet_request_set_max_vertices(ptet_request* request, uint64_t vertices, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.max_vertices = vertices; });
}

ptet_status ptet_request_set_max_milliseconds(ptet_request* request, double milliseconds, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.max_milliseconds = milliseconds; });
}

ptet_status ptet_request_set_max_bytes(ptet_request* request, uint64_t bytes, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.max_bytes = bytes; });
}

ptet_status ptet_request_add_focus_box(ptet_request* request, const double* min, const double* max,
                                       ptet_error** error) {
  return add_region(request, error, [&] {
    return Box{point_at(min, "the least corner"), point_at(max, "the greatest corner")};
  });
}

ptet_status ptet_request_add_focus_oriented_box(ptet_request* request, const double* centre, const double* half_axes,
                                                ptet_error** error) {
  return add_region(request, error, [&] {
    OrientedBox box;
    box.centre = point_at(centre, "the centre");
    (void)required(half_axes, "the half axes");
    for (std::size_t axis = 0; axis < 3; ++axis)
      box.half_axes[axis] = point_at(half_axes + 3 * axis, "a half axis");
    return box;
  });
}

ptet_status ptet_request_add_focus_sphere(ptet_request* request, const double* centre, double radius,
                                          ptet_error** error) {
  return add_region(request, error, [&] { return Sphere{point_at(centre, "the centre"), radius}; });
}

ptet_status ptet_request_add_focus_half_space(ptet_request* request, const double* normal, double offset,
                                              ptet_error** error) {
  return add_region(request, error, [&] { return HalfSpace{point_at(normal, "the normal"), offset}; });
}

ptet_status ptet_request_set_focus_error(ptet_request* request, double value, int32_t relative, ptet_error** error) {
  return guarded(error, [&] {
    ptet_request& of = required(request, "the request");
    of.focus_error = {value, relative != 0};
    for (Focus& focus : of.request.focus)
      focus.error = of.focus_error;
  });
}

ptet_status ptet_request_set_focus_falloff(ptet_request* request, double value, int32_t relative, ptet_error** error) {
  return guarded(error, [&] {
    ptet_request& of = required(request, "the request");
    of.falloff = Bound{value, relative != 0};
    for (Focus& focus : of.request.focus)
      focus.falloff = of.falloff;
  });
}

ptet_status ptet_request_set_region_error(ptet_request* request, uint32_t region, double value, int32_t relative,
                                          ptet_error** error) {
  return change_region(request, region, error, [&](Focus& focus) { focus.error = {value, relative != 0}; });
}

ptet_status ptet_request_set_region_falloff(ptet_request* request, uint32_t region, double value, int32_t relative,
                                            ptet_error** error) {
  return change_region(request, region, error, [&](Focus& focus) { focus.falloff = Bound{value, relative != 0}; });
}

ptet_status ptet_request_add_values(ptet_request* request, const char* field, double min, double max,
                                    ptet_error** error) {
  return change(request, error, [&](Request& asked) {
    asked.values.push_back({std::string(&required(field, "the name of the field")), min, max});
  });
}

ptet_status ptet_request_set_view(ptet_request* request, const ptet_view* view, ptet_error** error) {
  return change(request, error, [&](Request& asked) {
    const ptet_view given = take(view, "the view");
    View seen;
    seen.eye = point_at(given.eye, "the eye");
    seen.direction = point_at(given.direction, "the direction");
    seen.up = point_at(given.up, "the direction upwards");
    seen.vertical_angle = given.vertical_angle;
    seen.width = given.width;
    seen.height = given.height;
    seen.max_pixels = given.max_pixels;
    if (given.outside != 0) seen.outside = given.outside; // what a struct of zeros has
    asked.view = seen;
  });
}

ptet_status ptet_request_set_origins(ptet_request* request, int32_t origins, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.origins = origins != 0; });
}

ptet_status ptet_request_set_input_order(ptet_request* request, int32_t input_order, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.input_order = input_order != 0; });
}
