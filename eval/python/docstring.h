#pragma once

// Docstrings of the Python module. They are the comments of the C++ headers, which
// make_docstrings.py collects when the module is built.

#include <string_view>

#include "eval/python/docstrings.h"

namespace pickbed::eval {

// Returns the comment of a declaration, such as "GraspOutcome::slip_m". It does not compile if the
// headers that CMakeLists.txt lists have no such comment.
consteval const char* Doc(std::string_view name) {
  for (const Docstring& docstring : kDocstrings) {
    if (docstring.name == name) return docstring.text;
  }
  throw "no header has a comment for this name";
}

}  // namespace pickbed::eval
