// Building and validating from arrays.
#include "ptet/build.hpp"

#include "arrays.hpp"
#include "bindings.hpp"
#include "interrupt.hpp"

#include <optional>
#include <tuple>

#include <pybind11/stl.h>

namespace ptet::python {
namespace {

using NamedArrays = std::vector<std::pair<std::string, py::array>>;
using PlainBound = std::pair<double, bool>; ///< value, relative

/// The bytes of a built file, as Python's buffer protocol shows them.
struct Bytes {
  std::vector<std::byte> bytes;
};

TetMesh to_mesh(const py::array& points, const py::array& tets, const NamedArrays& fields) {
  TetMesh mesh;
  mesh.positions = to_point_array("", points);
  if (mesh.positions.components != 3) throw Error(ErrorCode::kBadArgument, "points: not an array of three columns");
  for (const auto& [name, rows] : fields) {
    mesh.point_arrays.push_back(to_point_array(name, rows));
    if (mesh.point_arrays.back().size() != mesh.vertex_count())
      throw Error(ErrorCode::kBadArgument, "field '" + name + "': not a row for each point");
  }
  mesh.tets = to_tets(tets);
  return mesh;
}

/// The one of the first `count` values of the enumeration that has this name.
template <class Choice>
Choice named(const std::string& name, const char* what, int count) {
  for (int number = 0; number < count; ++number)
    if (name_of(static_cast<Choice>(number)) == name) return static_cast<Choice>(number);
  throw Error(ErrorCode::kBadArgument, std::string(what) + " '" + name + "' is not known");
}

py::dict to_dict(const BuildReport& report) {
  py::dict collapses, last_refusals, field_error, dict;
  for (std::size_t i = 0; i < kCollapseStatusCount; ++i) {
    const py::str status(std::string(name_of(static_cast<CollapseStatus>(i))));
    collapses[status] = report.collapses[i];
    if (report.last_refusals[i] > 0) last_refusals[status] = report.last_refusals[i];
  }
  for (const auto& [field, error] : report.field_error)
    field_error[py::str(field)] = error;
  py::list walk;
  for (const RoundReport& round : report.walk)
    walk.append(py::make_tuple(round.vertices, round.cost, round.field_error, round.domain_error));
  dict["input_vertices"] = report.input_vertices;
  dict["input_tets"] = report.input_tets;
  dict["base_vertices"] = report.base_vertices;
  dict["base_tets"] = report.base_tets;
  dict["records"] = report.records;
  dict["rounds"] = report.rounds;
  dict["depth"] = report.depth;
  dict["min_quality"] = report.min_quality;
  dict["collapses"] = collapses;
  dict["stopped_by"] = report.stopped_by;
  dict["last_refusals"] = last_refusals;
  dict["simulations"] = report.simulations;
  dict["exact_evaluations"] = report.exact_evaluations;
  dict["field_error"] = field_error;
  dict["domain_error"] = report.domain_error;
  dict["walk"] = walk;
  dict["notes"] = report.notes;
  dict["cut_dependencies"] = report.cut_dependencies;
  dict["file_bytes"] = report.file_bytes;
  dict["collapse_seconds"] = report.collapse_seconds;
  dict["certify_seconds"] = report.certify_seconds;
  dict["total_seconds"] = report.total_seconds;
  dict["pieces"] = report.pieces;
  dict["piece_records"] = report.piece_records;
  dict["piece_records_dropped"] = report.piece_records_dropped;
  dict["piece_seconds"] = report.piece_seconds;
  dict["follow_seconds"] = report.follow_seconds;
  dict["peak_memory_bytes"] = report.peak_memory_bytes;
  dict["foreseen_memory_bytes"] = report.foreseen_memory_bytes;
  return dict;
}

py::dict to_dict(const MeshReport& report) {
  static constexpr std::array kSeverities{"note", "warning", "error"};
  py::list fields, findings;
  for (const FieldSummary& field : report.fields)
    fields.append(py::make_tuple(field.name, ptet::name_of(field.type), field.components, field.min, field.max,
                                 field.governs_by_default, field.can_govern));
  for (const Finding& finding : report.findings) {
    findings.append(py::make_tuple(finding.code, kSeverities.at(static_cast<std::size_t>(finding.severity)),
                                   finding.count, finding.message, finding.first_ids));
  }
  py::dict dict;
  dict["vertices"] = report.vertices;
  dict["tets"] = report.tets;
  dict["boundary_faces"] = report.boundary_faces;
  dict["boundary_vertices"] = report.boundary_vertices;
  dict["components"] = report.components;
  dict["boundary_components"] = report.boundary_components;
  dict["euler_characteristic"] = report.euler_characteristic;
  dict["boundary_euler_characteristic"] = report.boundary_euler_characteristic;
  dict["volume"] = report.volume;
  dict["boundary_area"] = report.boundary_area;
  dict["box_min"] = py::tuple(py::cast(report.box_min));
  dict["box_max"] = py::tuple(py::cast(report.box_max));
  dict["fields"] = fields;
  dict["findings"] = findings;
  return dict;
}

py::tuple build(const py::array& points, const py::array& tets, const NamedArrays& fields,
                const std::optional<std::string>& out, const std::vector<std::string>& govern,
                const std::vector<std::tuple<std::string, double, bool>>& max_field_error,
                const PlainBound& max_domain_error, double target_vertices, std::optional<double> min_quality,
                const std::string& prediction, const std::string& evaluation, const std::string& objective,
                std::uint32_t max_star, double round_fraction, unsigned threads, std::uint64_t memory_limit,
                std::uint32_t pieces, const std::optional<PlainBound>& weld, bool keep_order,
                const std::string& source_name, const std::string& source_hash, const py::object& progress) {
  BuildOptions options;
  options.fields = govern;
  for (const auto& [field, value, relative] : max_field_error)
    options.max_field_error.push_back({field, {value, relative}});
  options.max_domain_error = {max_domain_error.first, max_domain_error.second};
  options.target_vertices = target_vertices;
  options.min_quality = min_quality;
  options.prediction = named<Prediction>(prediction, "prediction", static_cast<int>(Prediction::kExact) + 1);
  options.evaluation = named<Evaluation>(evaluation, "evaluation", static_cast<int>(Evaluation::kExact) + 1);
  options.objective = named<Objective>(objective, "objective", static_cast<int>(Objective::kBoth) + 1);
  options.max_star = max_star;
  options.round_fraction = round_fraction;
  options.threads = threads;
  options.memory_limit = memory_limit;
  options.pieces = pieces;
  if (weld) options.weld = Bound{weld->first, weld->second};
  options.keep_order = keep_order;

  TetMesh mesh = to_mesh(points, tets, fields);
  BuildReport report;
  Bytes built = without_gil(progress, [&](const ProgressCallback& callback) {
    Bytes bytes;
    if (out) {
      report = build_file(std::move(mesh), *out, options, source_name, source_hash, callback);
    } else {
      bytes.bytes = build_memory(std::move(mesh), options, &report, source_name, source_hash, callback);
    }
    return bytes;
  });
  return py::make_tuple(out ? py::object(py::none()) : py::cast(std::move(built)), to_dict(report));
}

py::dict validate_arrays(const py::array& points, const py::array& tets, const NamedArrays& fields,
                         const py::object& progress) {
  const TetMesh mesh = to_mesh(points, tets, fields);
  return to_dict(without_gil(progress, [&](const ProgressCallback& callback) { return validate(mesh, callback); }));
}

} // namespace

void bind_build(py::module_& module) {
  py::class_<Bytes>(module, "Bytes", py::buffer_protocol())
      .def_buffer([](Bytes& bytes) {
        static std::byte none{};
        return py::buffer_info(bytes.bytes.empty() ? &none : bytes.bytes.data(), 1, "B", 1,
                               {static_cast<py::ssize_t>(bytes.bytes.size())}, {1}, true);
      })
      .def("__len__", [](const Bytes& bytes) { return bytes.bytes.size(); });
  module.def("build", &build, py::arg("points"), py::arg("tets"), py::arg("fields"), py::arg("out"), py::arg("govern"),
             py::arg("max_field_error"), py::arg("max_domain_error"), py::arg("target_vertices"),
             py::arg("min_quality"), py::arg("prediction"), py::arg("evaluation"), py::arg("objective"),
             py::arg("max_star"), py::arg("round_fraction"), py::arg("threads"), py::arg("memory_limit"),
             py::arg("pieces"), py::arg("weld"), py::arg("keep_order"), py::arg("source_name"), py::arg("source_hash"),
             py::arg("progress"));
  module.def("validate", &validate_arrays, py::arg("points"), py::arg("tets"), py::arg("fields"), py::arg("progress"));
}

} // namespace ptet::python
