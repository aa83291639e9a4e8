#include "arrays.hpp"

#include "ptet/error.hpp"

#include <cstring>
#include <optional>

namespace ptet::python {
namespace {

std::optional<ScalarType> scalar_type_of(const py::dtype& type) {
  for (auto number = static_cast<int>(ScalarType::kInt8); number <= static_cast<int>(ScalarType::kFloat64); ++number) {
    const auto candidate = static_cast<ScalarType>(number);
    const char* const name = name_of(candidate);
    if (type.kind() == name[0] && static_cast<std::size_t>(type.itemsize()) == size_of(candidate)) return candidate;
  }
  return std::nullopt;
}

void require(bool holds, const std::string& what) {
  if (!holds) throw Error(ErrorCode::kBadArgument, what);
}

void require_plain(const py::array& rows, const std::string& what) {
  require((rows.flags() & py::array::c_style) != 0, what + ": the array is not contiguous");
  require(rows.dtype().attr("isnative").cast<bool>(), what + ": the array is not in the machine's byte order");
}

} // namespace

py::dtype dtype_of(ScalarType type) {
  return py::dtype(name_of(type));
}

py::str to_str(const std::string& text) {
  auto* const made = PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "backslashreplace");
  if (made == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(made);
}

PointArray to_point_array(const std::string& name, const py::array& rows) {
  const std::string what = name.empty() ? "points" : "field '" + name + "'";
  require_plain(rows, what);
  const std::optional<ScalarType> type = scalar_type_of(rows.dtype());
  require(type.has_value(), what + ": there is no such type of numbers in a .ptet file");
  require(rows.ndim() == 1 || rows.ndim() == 2,
          what + ": the array has " + std::to_string(rows.ndim()) + " dimensions");
  const py::ssize_t components = rows.ndim() == 1 ? 1 : rows.shape(1);
  require(components >= 1 && components <= 0xFFFF, what + ": the array has " + std::to_string(components) + " columns");
  PointArray array{name, *type, static_cast<std::uint32_t>(components), {}};
  array.bytes.resize(static_cast<std::size_t>(rows.nbytes()));
  if (!array.bytes.empty()) std::memcpy(array.bytes.data(), rows.data(), array.bytes.size());
  return array;
}

std::vector<Tet> to_tets(const py::array& rows) {
  require_plain(rows, "tets");
  require(rows.dtype().kind() == 'u' && rows.itemsize() == sizeof(std::uint32_t), "tets: not an array of uint32");
  require(rows.ndim() == 2 && rows.shape(1) == 4, "tets: not an array of four columns");
  std::vector<Tet> tets(static_cast<std::size_t>(rows.shape(0)));
  static_assert(sizeof(Tet) == 4 * sizeof(std::uint32_t) && std::is_trivially_copyable_v<Tet>);
  if (!tets.empty()) std::memcpy(static_cast<void*>(tets.data()), rows.data(), tets.size() * sizeof(Tet));
  return tets;
}

py::array view(const py::dtype& type, const void* data, std::size_t rows, std::size_t columns, py::handle owner) {
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(rows)};
  if (columns > 0) shape.push_back(static_cast<py::ssize_t>(columns));
  py::array array = rows == 0 ? py::array(type, shape) : py::array(type, shape, {}, data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

py::array view(const PointArray& array, py::handle owner) {
  return view(dtype_of(array.type), array.bytes.data(), array.size(), array.components == 1 ? 0 : array.components,
              owner);
}

} // namespace ptet::python
