#pragma once

// Messages about wrong arguments of functions of the Python module.

#include <pybind11/pybind11.h>

#include "eval/layer.h"

namespace pickbed::eval {

// Wraps the functions of the module and the methods of its classes. The TypeError of pybind11 for
// wrong arguments has several lines; the wrapper raises one line with the argument, the expected
// type and the given value. Docstrings stay as they are. Call it when the module is complete.
void ShortenArgumentErrors(pybind11::module_& module);

}  // namespace pickbed::eval
