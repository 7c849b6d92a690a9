#pragma once

// Scenarios for Python: settings as Python values.

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/base/settings.h"

namespace pickbed::eval {

// Returns the settings as nested dicts and lists.
pybind11::dict SettingsDict(const VisitFunction& visit);

// Returns settings as assignments "key=value". `settings`: None, a list of such assignments, or a
// dict of keys such as "objects.0.count" and values. Throws InputError for anything else.
std::vector<std::string> AssignmentsFrom(const pybind11::object& settings);

}  // namespace pickbed::eval
