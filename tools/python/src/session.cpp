// Sessions. Their arrays are handed out as copies of the rows asked for: a view would dangle after the next update.
#include "ptet/session.hpp"

#include "arrays.hpp"
#include "bindings.hpp"
#include "handles.hpp"

#include <cstring>
#include <optional>

#include <pybind11/stl.h>

namespace ptet::python {
namespace {

using Slots = py::array_t<std::uint32_t, py::array::c_style>;

class OpenSession {
public:
  explicit OpenSession(const OpenFile& file) : pending_(&file.pending()) {
    const GilReleased released; // the dataset's lock may be held by who waits for the GIL
    session_.emplace(file.data());
  }
  ~OpenSession() {
    const GilReleased released;
    session_.reset();
  }
  OpenSession(const OpenSession&) = delete;
  OpenSession& operator=(const OpenSession&) = delete;

  py::dict update(const Request& request, const py::object& progress) {
    const SessionUpdate* const done = without_gil(
        progress, *pending_, [&](const ProgressCallback& callback) { return &session_->update(request, callback); });
    py::dict dict;
    dict["changed_tets"] = copy(done->changed_tets);
    dict["changed_faces"] = copy(done->changed_faces);
    dict["changed_vertices"] = copy(done->changed_vertices);
    dict["tets"] = done->tets;
    dict["boundary_faces"] = done->boundary_faces;
    dict["vertices"] = done->vertices;
    dict["tets_added"] = done->tets_added;
    dict["tets_removed"] = done->tets_removed;
    dict["vertices_added"] = done->vertices_added;
    dict["vertices_removed"] = done->vertices_removed;
    dict["splits"] = done->splits;
    dict["collapses"] = done->collapses;
    dict["field_error"] = std::vector<double>(done->field_error.begin(), done->field_error.end());
    dict["rms_error"] = std::vector<double>(done->rms_error.begin(), done->rms_error.end());
    dict["covered"] = done->covered;
    dict["domain_error"] = done->domain_error;
    dict["limited_by"] = name_of(done->limited_by);
    dict["complete"] = done->complete;
    dict["failures"] = failures_as_list(done->failures);
    dict["seconds"] = done->seconds;
    dict["renumbered"] = done->renumbered;
    return dict;
  }

  /// How many there are of tets, boundary faces, vertices.
  [[nodiscard]] py::tuple slots() const {
    return py::make_tuple(session_->tets().size(), session_->boundary_faces().size(),
                          session_->vertex_in_file().size());
  }
  [[nodiscard]] py::array tets(const std::optional<Slots>& slots) const { return rows(session_->tets(), 4, slots); }
  [[nodiscard]] bool has_origins() const { return !session_->made_by().empty(); }
  /// Empty unless the last request asked for it.
  [[nodiscard]] py::array made_by(const std::optional<Slots>& slots) const {
    return rows(session_->made_by(), 0, slots);
  }
  [[nodiscard]] py::array boundary_faces(const std::optional<Slots>& slots) const {
    return rows(session_->boundary_faces(), 3, slots);
  }
  [[nodiscard]] py::array vertices(const std::optional<Slots>& slots) const {
    return rows(session_->vertex_in_file(), 0, slots);
  }
  [[nodiscard]] py::array points(const std::optional<Slots>& slots) const { return rows(session_->positions(), slots); }
  [[nodiscard]] py::array field(std::size_t number, const std::optional<Slots>& slots) const {
    if (number >= session_->point_arrays().size()) throw py::index_error("there is no such field");
    return rows(session_->point_arrays()[number], slots);
  }
  [[nodiscard]] Extraction extraction() const {
    return without_gil(py::none(), *pending_, [&](const ProgressCallback&) { return session_->extraction(); });
  }

private:
  static py::array copy(std::span<const std::uint32_t> numbers) {
    return py::array_t<std::uint32_t>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
  }

  /// The rows at `slots`, or all.
  static py::array gather(const py::dtype& type, const std::byte* data, std::size_t row_count, std::size_t row_bytes,
                          std::size_t columns, const std::optional<Slots>& slots) {
    const std::size_t count = slots ? static_cast<std::size_t>(slots->size()) : row_count;
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(count)};
    if (columns > 0) shape.push_back(static_cast<py::ssize_t>(columns));
    py::array gathered(type, shape);
    auto* const to = static_cast<std::byte*>(gathered.mutable_data());
    if (!slots) {
      if (count > 0) std::memcpy(to, data, count * row_bytes);
      return gathered;
    }
    const std::uint32_t* const from = slots->data();
    for (std::size_t i = 0; i < count; ++i) {
      if (from[i] >= row_count) throw py::index_error("there is no such slot");
      std::memcpy(to + i * row_bytes, data + from[i] * row_bytes, row_bytes);
    }
    return gathered;
  }

  template <class Row>
  static py::array rows(std::span<const Row> all, std::size_t columns, const std::optional<Slots>& slots) {
    static_assert(sizeof(Row) % sizeof(std::uint32_t) == 0 && std::is_trivially_copyable_v<Row>);
    return gather(py::dtype::of<std::uint32_t>(), reinterpret_cast<const std::byte*>(all.data()), all.size(),
                  sizeof(Row), columns, slots);
  }
  static py::array rows(const PointArray& all, const std::optional<Slots>& slots) {
    return gather(dtype_of(all.type), all.bytes.data(), all.size(), all.row_bytes(),
                  all.components == 1 ? 0 : all.components, slots);
  }

  std::optional<Session> session_;
  PendingError* pending_; ///< the file's, which Python keeps alive
};

} // namespace

void bind_session(py::module_& module) {
  py::class_<OpenSession>(module, "OpenSession")
      .def(py::init<const OpenFile&>(), py::keep_alive<1, 2>())
      .def("update", &OpenSession::update)
      .def_property_readonly("slots", &OpenSession::slots)
      .def("tets", &OpenSession::tets)
      .def_property_readonly("has_origins", &OpenSession::has_origins)
      .def("made_by", &OpenSession::made_by)
      .def("boundary_faces", &OpenSession::boundary_faces)
      .def("vertices", &OpenSession::vertices)
      .def("points", &OpenSession::points)
      .def("field", &OpenSession::field)
      .def("extraction", &OpenSession::extraction);
}

} // namespace ptet::python
