#pragma once

#include <functional>
#include <string>

#include "scenes/check.h"

namespace pickbed {

// The line that `run` ends with, or "no error".
inline std::string ErrorOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace pickbed
