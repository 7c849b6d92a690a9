#include "eval/python/calls.h"

#include <chrono>
#include <stdexcept>

namespace pickbed::eval {
namespace {

namespace py = pybind11;

}  // namespace

void HandleSignals() {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kPeriod{50};
  thread_local Clock::time_point handled;
  const Clock::time_point now = Clock::now();
  if (now - handled < kPeriod) return;
  handled = now;
  const py::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void WarnInPython(const std::string& line) {
  const py::gil_scoped_acquire lock;
  if (PyErr_WarnEx(PyExc_RuntimeWarning, line.c_str(), 1) != 0) throw py::error_already_set();
}

CallGuard::Use::Use(CallGuard& call_guard) : guard(call_guard) {
  if (guard.owner_ != std::this_thread::get_id()) {
    throw std::runtime_error(guard.name_ + " was made by another thread; make one in each thread");
  }
  if (guard.in_use_) throw std::runtime_error(guard.name_ + " is in use by another call");
  guard.in_use_ = true;
}

}  // namespace pickbed::eval
