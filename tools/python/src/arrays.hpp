// Between NumPy's arrays and the library's tables: copies on the way in, views on the way out.
#pragma once

#include "ptet/mesh.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include <pybind11/numpy.h>

namespace ptet::python {

namespace py = pybind11;

/// A copy of `rows`, of shape (n,) or (n, components): contiguous, of one of the numeric types, native byte order.
/// Throws Error(kBadArgument) for any other array.
[[nodiscard]] PointArray to_point_array(const std::string& name, const py::array& rows);

/// A copy of `rows`: contiguous, uint32, of shape (m, 4). Throws Error(kBadArgument) for any other array.
[[nodiscard]] std::vector<Tet> to_tets(const py::array& rows);

/// A read-only view of shape (rows,) or (rows, columns) of `data`, which `owner` keeps alive. columns 0: (rows,).
[[nodiscard]] py::array view(const py::dtype& type, const void* data, std::size_t rows, std::size_t columns,
                             py::handle owner);

/// The same of a point array: (rows,) when it has one component.
[[nodiscard]] py::array view(const PointArray& array, py::handle owner);

[[nodiscard]] py::dtype dtype_of(ScalarType type);

/// What a file says, which need not be UTF-8.
[[nodiscard]] py::str to_str(const std::string& text);

/// How many 32-bit ids a row is made of: 0 for the id itself.
template <class Row>
struct IdColumns : std::integral_constant<std::size_t, 0> {};
template <class Row, std::size_t N>
struct IdColumns<std::array<Row, N>> : std::integral_constant<std::size_t, N> {};

/// Rows of ids as rows of uint32, which they are.
template <class Row>
py::array view_ids(const std::vector<Row>& rows, py::handle owner) {
  constexpr std::size_t kColumns = IdColumns<Row>::value;
  static_assert(sizeof(Row) == sizeof(std::uint32_t) * (kColumns == 0 ? 1 : kColumns));
  static_assert(std::is_standard_layout_v<Row>);
  return view(py::dtype::of<std::uint32_t>(), rows.data(), rows.size(), kColumns, owner);
}

} // namespace ptet::python
