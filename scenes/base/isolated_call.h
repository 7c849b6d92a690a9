#pragma once

// Runs code that may crash, hang or take all memory on bad input, such as an importer of another
// project, in a child process.

#include <cstddef>
#include <functional>
#include <string>

#include "scenes/base/error.h"

namespace pickbed::scenes {

// The process of an isolated call died or exceeded a limit.
class IsolationError : public InputError {
 public:
  using InputError::InputError;
};

// What the child may use.
struct IsolationLimits {
  int seconds = 60;                  // of wall time
  size_t memory_bytes = 4000000000;  // beyond what this process has mapped
  size_t result_bytes = 2000000000;
};

// Returns the bytes that `work` returns. `work` runs in a copy of this process, so nothing that it
// changes is seen here. It may not use threads of this process. Throws InputError with its message
// if `work` throws one, and IsolationError that says what happened ("the process crashed
// (Segmentation fault)") if the process dies or exceeds a limit.
std::string CallIsolated(const std::function<std::string()>& work,
                         const IsolationLimits& limits = {});

}  // namespace pickbed::scenes
