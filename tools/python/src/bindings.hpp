// The parts of the module ptet._core, which the Python files of the package ptet stand on. Arguments are checked there;
// here only what keeps memory safe.
#pragma once

#include <pybind11/pybind11.h>

namespace ptet::python {

void bind_build(pybind11::module_& module);
void bind_dataset(pybind11::module_& module);
/// After bind_dataset.
void bind_session(pybind11::module_& module);

} // namespace ptet::python
