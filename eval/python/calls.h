#pragma once

// Calls from Python: without the interpreter lock, by one thread at a time, and with Ctrl-C.

#include <pybind11/pybind11.h>

#include <string>
#include <thread>
#include <utility>

#include "eval/layer.h"

namespace pickbed::eval {

// Lets Python handle signals, at most every 50 ms, so that Ctrl-C ends a long call. Throws
// pybind11::error_already_set if a handler raised an exception. The interpreter lock must be free.
void HandleSignals();

// Issues a warning of Python. Throws pybind11::error_already_set if warnings are errors. The
// interpreter lock must be free.
void WarnInPython(const std::string& line);

// Runs `work` without the interpreter lock and returns its result.
template <typename Work>
auto WithoutLock(Work work) {
  const pybind11::gil_scoped_release release;
  return work();
}

// Guards an object that owns a renderer, whose context belongs to one thread.
class CallGuard {
 public:
  // `name` is the class in Python. The object belongs to the calling thread.
  explicit CallGuard(std::string name)
      : name_(std::move(name)), owner_(std::this_thread::get_id()) {}

  // Runs `work` without the interpreter lock and returns its result. Throws std::runtime_error in
  // another thread, and during another call.
  template <typename Work>
  auto Run(Work work) {
    const Use use(*this);
    return WithoutLock(std::move(work));
  }

 private:
  struct Use {
    explicit Use(CallGuard& call_guard);
    ~Use() { guard.in_use_ = false; }
    CallGuard& guard;
  };
  std::string name_;
  std::thread::id owner_;
  bool in_use_ = false;  // guarded by the interpreter lock
};

}  // namespace pickbed::eval
