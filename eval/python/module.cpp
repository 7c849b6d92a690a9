#include "eval/python/module.h"

#include <dlfcn.h>

#include <exception>
#include <filesystem>
#include <stdexcept>

#include "eval/python/argument_errors.h"
#include "eval/runtime/process.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace py = pybind11;

// Uses the assets that were installed with the module. The program looks for them beside itself,
// but the running program is Python. Other programs, such as plug-ins, inherit the variable.
void FindAssets() {
  Dl_info here{};
  if (dladdr(reinterpret_cast<void*>(&FindAssets), &here) == 0) return;
  const std::filesystem::path file = std::filesystem::absolute(here.dli_fname);
  const std::filesystem::path folder =
      (file.parent_path() / PICKBED_ASSETS_NEAR_MODULE).lexically_normal();
  if (!std::filesystem::is_directory(folder)) return;
  // A value that the user has set is kept.
  py::module_::import("os").attr("environ").attr("setdefault")("PICKBED_ASSETS", folder.string());
}

// A broken condition of a function is a ValueError. An index out of range stays an IndexError.
void RaiseValueError(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const std::out_of_range&) {
    throw;
  } catch (const std::logic_error& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  }
}

}  // namespace

PYBIND11_MODULE(pickbed, module) {
  module.doc() =
      "Bin picking with the simulation in the loop: drop, capture, estimate, plan, execute, "
      "measure."
      "\n\nLengths are in metres and angles in radians. X_AB is the pose of frame B in frame A, a "
      "4 x "
      "4 array: p_A = X_AB @ p_B. Frames: W world (z up, origin in the center of the bin floor), C "
      "camera (x right, y down, z forward; pixel (0, 0) is the center of the first pixel), O "
      "object, "
      "G gripper (z approach, x closing). Depth is in metres along the z axis of the camera; 0 = "
      "no "
      "reading.\n\nThe module limits OpenMP, OpenBLAS and OpenCV to one thread in the whole "
      "process, "
      "because results must not depend on the number of processors. Bad input raises InputError "
      "with one line, an argument of a wrong type TypeError with one line.";
  module.attr("__version__") = PICKBED_VERSION;
  UseOneThread();
  py::register_exception<InputError>(module, "InputError", PyExc_ValueError).doc() =
      "Bad input: one line with the file, key or argument, the value and a remedy.";
  py::register_exception_translator(&RaiseValueError);
  AddScenarios(module);
  AddMetrics(module);
  AddIntervals(module);
  AddRecords(module);
  AddCell(module);
  AddPickingEnv(module);
  ShortenArgumentErrors(module);
  FindAssets();
}

}  // namespace pickbed::eval
