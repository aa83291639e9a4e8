// Opening files, requests and extractions.
#include "ptet/dataset.hpp"

#include "arrays.hpp"
#include "bindings.hpp"
#include "handles.hpp"
#include "source.hpp"

#include <map>
#include <optional>
#include <span>

#include <pybind11/stl.h>

namespace ptet::python {
namespace {

using Ids = py::array_t<std::uint32_t, py::array::c_style>;
using PlainBound = std::pair<double, bool>; ///< value, relative

Bound to_bound(const PlainBound& bound) {
  return {bound.first, bound.second};
}

void add_focus(Request& request, const Region& region, const PlainBound& error,
               const std::optional<PlainBound>& falloff) {
  Focus focus{region, to_bound(error), std::nullopt};
  if (falloff) focus.falloff = to_bound(*falloff);
  request.focus.push_back(focus);
}

OpenOptions to_options(std::uint64_t memory_limit, bool background, std::uint64_t max_gap,
                       const std::optional<std::uint64_t>& max_bytes, const std::optional<std::uint64_t>& max_vertices,
                       const std::optional<std::uint64_t>& max_tets) {
  OpenOptions options;
  options.memory_limit = memory_limit;
  options.background = background;
  options.max_gap = max_gap;
  options.limits.max_bytes = max_bytes.value_or(options.limits.max_bytes);
  options.limits.max_vertices = max_vertices.value_or(options.limits.max_vertices);
  options.limits.max_tets = max_tets.value_or(options.limits.max_tets);
  return options;
}

std::unique_ptr<OpenFile> open_source(std::shared_ptr<ByteSource> source, std::shared_ptr<PendingError> pending,
                                      const OpenOptions& options) {
  auto data = without_gil(py::none(), *pending,
                          [&](const ProgressCallback&) { return Dataset::open(std::move(source), options); });
  return std::make_unique<OpenFile>(std::move(data), std::move(pending));
}

py::array origin_values(const OpenFile& file, const Ids& made_by, const std::string& what, std::size_t field) {
  const std::map<std::string, OriginValue> kinds{{"field error", OriginValue::kFieldError},
                                                 {"domain error", OriginValue::kDomainError},
                                                 {"level", OriginValue::kLevel},
                                                 {"generation", OriginValue::kGeneration}};
  std::vector<RecordId> records;
  for (py::ssize_t i = 0; i < made_by.size(); ++i)
    records.emplace_back(made_by.data()[i]);
  py::array_t<double> values(made_by.size());
  const std::span<double> into(values.mutable_data(), records.size());
  without_gil(py::none(), file.pending(),
              [&](const ProgressCallback&) { file.data()->origin_values(records, kinds.at(what), field, into); });
  return values;
}

/// (name, error) by field, for the governing ones; empty when nothing was measured.
py::dict by_field(const DatasetInfo& info, const std::vector<double>& errors) {
  py::dict dict;
  std::size_t at = 0;
  for (const FieldInfo& field : info.fields)
    if (field.governing && at < errors.size()) dict[to_str(field.name)] = errors[at++];
  return dict;
}

py::dict to_dict(const DatasetInfo& info) {
  py::list fields;
  for (const FieldInfo& field : info.fields)
    fields.append(
        py::make_tuple(to_str(field.name), dtype_of(field.type), field.components, field.governing, field.range));
  py::dict dict;
  dict["vertices"] = info.vertices;
  dict["tets"] = info.tets;
  dict["base_vertices"] = info.base_vertices;
  dict["base_tets"] = info.base_tets;
  dict["records"] = info.records;
  dict["blocks"] = info.blocks;
  dict["file_bytes"] = info.file_bytes;
  dict["memory_for_all"] = info.memory_for_all;
  dict["point_dtype"] = dtype_of(info.position_type);
  dict["has_input_order"] = info.has_input_order;
  dict["errors_are_bounds"] = info.errors_are_bounds;
  dict["overlaps_itself"] = info.overlaps_itself;
  dict["fields"] = fields;
  dict["box_min"] = py::tuple(py::cast(info.box_min));
  dict["box_max"] = py::tuple(py::cast(info.box_max));
  dict["diagonal"] = info.diagonal;
  dict["max_field_error"] = by_field(info, info.max_field_error);
  dict["max_domain_error"] = info.max_domain_error;
  dict["base_rms_error"] = by_field(info, info.base_rms_error);
  dict["base_covered"] = info.base_covered;
  dict["provenance_json"] = to_str(info.provenance_json);
  return dict;
}

py::list to_list(const std::vector<PartErrors>& parts) {
  py::list list;
  for (const PartErrors& part : parts)
    list.append(py::make_tuple(part.field_error, part.domain_error));
  return list;
}

void bind_request(py::module_& module) {
  py::class_<Request>(module, "Request")
      .def(py::init<>())
      .def("add_field_error",
           [](Request& request, const std::string& field, const PlainBound& bound) {
             request.field_error.push_back({field, to_bound(bound)});
           })
      .def("set_domain_error",
           [](Request& request, const PlainBound& bound) { request.domain_error = to_bound(bound); })
      .def_readwrite("max_tets", &Request::max_tets)
      .def_readwrite("max_vertices", &Request::max_vertices)
      .def_readwrite("max_bytes", &Request::max_bytes)
      .def_readwrite("max_milliseconds", &Request::max_milliseconds)
      .def_readwrite("origins", &Request::origins)
      .def_readwrite("input_order", &Request::input_order)
      .def("add_box",
           [](Request& request, const Point& min, const Point& max, const PlainBound& error,
              const std::optional<PlainBound>& falloff) {
             add_focus(request, Box{min, max}, error, falloff);
           })
      .def("add_oriented_box",
           [](Request& request, const Point& centre, const std::array<Point, 3>& half_axes, const PlainBound& error,
              const std::optional<PlainBound>& falloff) {
             add_focus(request, OrientedBox{centre, half_axes}, error, falloff);
           })
      .def("add_sphere",
           [](Request& request, const Point& centre, double radius, const PlainBound& error,
              const std::optional<PlainBound>& falloff) {
             add_focus(request, Sphere{centre, radius}, error, falloff);
           })
      .def("add_half_space",
           [](Request& request, const Point& normal, double offset, const PlainBound& error,
              const std::optional<PlainBound>& falloff) {
             add_focus(request, HalfSpace{normal, offset}, error, falloff);
           })
      .def("add_values",
           [](Request& request, const std::string& field, double min, double max) {
             request.values.push_back({field, min, max});
           })
      .def("set_view",
           [](Request& request, const Point& eye, const Point& direction, const Point& up, double vertical_angle,
              std::uint32_t width, std::uint32_t height, double max_pixels, double outside) {
             request.view = View{eye, direction, up, vertical_angle, width, height, max_pixels, outside};
           });
}

void bind_extraction(py::module_& module) {
  // Arrays are views of the object, which they keep alive.
  const auto points = [](const py::object& self) { return view(self.cast<const Extraction&>().mesh.positions, self); };
  const auto fields = [](const py::object& self) {
    py::dict arrays;
    for (const PointArray& array : self.cast<const Extraction&>().mesh.point_arrays)
      arrays[to_str(array.name)] = view(array, self);
    return arrays;
  };
  const auto tets = [](const py::object& self) { return view_ids(self.cast<const Extraction&>().mesh.tets, self); };
  const auto faces = [](const py::object& self) {
    return view_ids(self.cast<const Extraction&>().boundary_faces, self);
  };
  const auto vertices = [](const py::object& self) {
    return view_ids(self.cast<const Extraction&>().vertex_in_file, self);
  };
  const auto input_vertex = [](const py::object& self) {
    return view_ids(self.cast<const Extraction&>().input_vertex, self);
  };
  const auto made_by = [](const py::object& self) { return view_ids(self.cast<const Extraction&>().made_by, self); };
  py::class_<Extraction>(module, "Extraction")
      .def_property_readonly("points", points)
      .def_property_readonly("fields", fields)
      .def_property_readonly("tets", tets)
      .def_property_readonly("boundary_faces", faces)
      .def_property_readonly("vertex_ids", vertices)
      .def_property_readonly("input_vertex", input_vertex)
      .def_property_readonly("made_by", made_by)
      .def_readonly("field_error", &Extraction::field_error)
      .def_readonly("rms_error", &Extraction::rms_error)
      .def_readonly("covered", &Extraction::covered)
      .def_readonly("domain_error", &Extraction::domain_error)
      .def_property_readonly("in_focus", [](const Extraction& cut) { return to_list(cut.in_focus); })
      .def_property_readonly("at_values", [](const Extraction& cut) { return to_list(cut.at_values); })
      .def_property_readonly("in_view",
                             [](const Extraction& cut) {
                               return to_list(cut.in_view ? std::vector<PartErrors>{*cut.in_view}
                                                          : std::vector<PartErrors>{});
                             })
      .def_readonly("pixels_in_view", &Extraction::pixels_in_view)
      .def_property_readonly("limited_by", [](const Extraction& cut) { return name_of(cut.limited_by); })
      .def_readonly("complete", &Extraction::complete)
      .def_property_readonly("failures", [](const Extraction& cut) { return failures_as_list(cut.failures); })
      .def_readonly("bytes_read", &Extraction::bytes_read)
      .def_readonly("read_requests", &Extraction::read_requests)
      .def_readonly("seconds", &Extraction::seconds);
}

} // namespace

void bind_dataset(py::module_& module) {
  bind_request(module);
  bind_extraction(module);
  py::class_<OpenOptions>(module, "OpenOptions")
      .def(py::init(&to_options), py::arg("memory_limit"), py::arg("background"), py::arg("max_gap"),
           py::arg("max_bytes"), py::arg("max_vertices"), py::arg("max_tets"));
  py::class_<OpenFile>(module, "OpenFile")
      .def_property_readonly("info", [](const OpenFile& file) { return to_dict(file.data()->info()); })
      .def("extract",
           [](const OpenFile& file, const Request& request, const py::object& progress) {
             return without_gil(progress, file.pending(), [&](const ProgressCallback& callback) {
               return file.data()->extract(request, callback);
             });
           })
      .def("origin_values", &origin_values)
      .def("wait_until_loaded", [](const OpenFile& file, const py::object& progress) {
        without_gil(progress, file.pending(),
                    [&](const ProgressCallback& callback) { file.data()->wait_until_loaded(callback); });
      });
  module.def("unmet_wishes", [](const Request& request, const Extraction& extraction) {
    const UnmetWishes unmet =
        without_gil(py::none(), [&](const ProgressCallback&) { return unmet_wishes(request, extraction); });
    return std::tuple(unmet.focus, unmet.values, unmet.view);
  });
  module.def("open_path", [](const std::string& path, const OpenOptions& options) {
    auto pending = std::make_shared<PendingError>();
    auto data = without_gil(py::none(), [&](const ProgressCallback&) { return Dataset::open(path, options); });
    return std::make_unique<OpenFile>(std::move(data), std::move(pending));
  });
  module.def("open_buffer", [](const py::buffer& buffer, const OpenOptions& options) {
    return open_source(over_buffer(buffer), std::make_shared<PendingError>(), options);
  });
  module.def("open_reader", [](const py::object& read, std::uint64_t size, const OpenOptions& options) {
    auto pending = std::make_shared<PendingError>();
    return open_source(over_reader(read, size, pending), pending, options);
  });
}

} // namespace ptet::python
