#pragma once

#include <functional>
#include <string>

#include "scenes/base/error.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// Returns the message of the InputError that `run` throws, or "no error".
inline std::string ErrorOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace pickbed::tests
