#pragma once
#include <pybind11/pybind11.h>

namespace meshmser::python {

/// Adds `_run`, which runs a configuration; the package's own Python makes it a function of keyword arguments.
void declare_run(pybind11::module_& module);

}  // namespace meshmser::python
