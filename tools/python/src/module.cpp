// ptet._core: the C++ interface for Python.
#include "arrays.hpp"
#include "bindings.hpp"
#include "gil.hpp"
#include "ptet/error.hpp"
#include "ptet/version.hpp"
#include "source.hpp"

#include <exception>

namespace ptet::python {
namespace {

const char* name_of(ErrorCode code) {
  switch (code) {
  case ErrorCode::kBadArgument: return "ArgumentError";
  case ErrorCode::kBadInput: return "InputError";
  case ErrorCode::kCorruptFile: return "FormatError";
  case ErrorCode::kLimit: return "LimitError";
  case ErrorCode::kIo: return "FileError";
  case ErrorCode::kCancelled: return "Cancelled";
  }
  return "Error";
}

/// The library's exception as the package's of that kind.
void set_python_error(const Error& error) {
  const py::object type = py::module_::import("ptet._errors").attr(name_of(error.code()));
  const py::object offset = error.byte_offset() ? py::object(py::int_(*error.byte_offset())) : py::object(py::none());
  const py::object made = type(to_str(error.what()), offset);
  PyErr_SetObject(type.ptr(), made.ptr());
}

} // namespace
} // namespace ptet::python

PYBIND11_MODULE(_core, module) {
  using namespace ptet::python;
  module.attr("version") = ptet::kVersion;
  pybind11::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(std::move(thrown));
    } catch (const ptet::Error& error) {
      set_python_error(error);
    }
  });
  module.def(
      "end",
      [] {
        announce_end_of_gil();
        shut_readers();
        end_gil();
      },
      "To be called when Python ends, see atexit.");
  bind_build(module);
  bind_dataset(module);
  bind_session(module);
}
