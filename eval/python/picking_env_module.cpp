#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <limits>
#include <memory>
#include <utility>

#include "eval/python/arrays.h"
#include "eval/python/calls.h"
#include "eval/python/docstring.h"
#include "eval/python/module.h"
#include "eval/python/picking_env.h"
#include "eval/python/records.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace py = pybind11;

// The environment and the guard of its renderer.
struct PythonEnv {
  CallGuard guard{"BinPickingEnv"};
  BinPickingEnv env;
  explicit PythonEnv(std::shared_ptr<const LoadedScenario> scenario)
      : env(std::move(scenario), {HandleSignals, WarnInPython}) {}

  CapturedView View() {
    return guard.Run([&] { return env.View(); });
  }
};

py::dict ObservationOf(PythonEnv& e) {
  // The arrays keep the view alive.
  const py::object view = py::cast(e.View());
  py::dict observation;
  for (const char* key : {"color", "depth_m", "K", "X_WC"}) observation[key] = view.attr(key);
  return observation;
}

py::dict InfoOf(const PythonEnv& e) {
  py::dict info;
  info["bin_index"] = e.env.bin_index();
  info["attempt"] = e.env.attempt();
  info["instances_left"] = e.env.instances_left();
  return info;
}

py::tuple Reset(PythonEnv& e, const py::object& seed, const py::object& options) {
  std::optional<uint64_t> new_seed;
  if (!seed.is_none()) new_seed = NumberFrom(seed, "seed", std::numeric_limits<uint64_t>::max());
  std::optional<int> bin_index;
  if (!options.is_none()) {
    CheckInput(py::isinstance<py::dict>(options), "options must be a dict or None");
    for (const auto& [key, value] : options.cast<py::dict>()) {
      const std::string name = py::str(key);
      CheckInput(name == "bin_index", UnknownNameMessage("option", name, {"bin_index"}));
      bin_index = static_cast<int>(NumberFrom(value, name, std::numeric_limits<int>::max()));
    }
  }
  e.guard.Run([&] { e.env.Reset(new_seed, bin_index); });
  return py::make_tuple(ObservationOf(e), InfoOf(e));
}

std::optional<Grasp> GraspFrom(const PythonEnv& e, const py::object& grasp) {
  if (grasp.is_none()) return std::nullopt;
  if (py::isinstance<Grasp>(grasp)) return grasp.cast<Grasp>();
  const Grasp open = e.env.GraspAt(Pose::Identity());
  return MakeGrasp(grasp, open.width_m, open.score, open.hypothesis, open.tool);
}

py::tuple Step(PythonEnv& e, const py::object& action) {
  const std::optional<Grasp> grasp = GraspFrom(e, action);
  const AttemptRecord record = e.guard.Run([&] { return e.env.Step(grasp); });
  py::dict info = InfoOf(e);
  info["record"] = record;
  const double reward = record.failure == FailureReason::kNone ? 1 : 0;
  return py::make_tuple(ObservationOf(e), reward, e.env.terminated(), e.env.truncated(), info);
}

}  // namespace

void AddPickingEnv(py::module_& module) {
  py::class_<PythonEnv>(module, "BinPickingEnv", Doc("BinPickingEnv"))
      .def(py::init([](std::shared_ptr<LoadedScenario> scenario) {
             return WithoutLock([&] { return std::make_unique<PythonEnv>(std::move(scenario)); });
           }),
           py::arg("scenario").none(false), Doc("BinPickingEnv::BinPickingEnv"))
      .def("reset", &Reset, py::arg("seed") = py::none(), py::arg("options") = py::none(),
           Doc("BinPickingEnv::Reset"))
      .def("step", &Step, py::arg("grasp"), Doc("BinPickingEnv::Step"))
      .def(
          "estimate", [](PythonEnv& e) { return e.guard.Run([&] { return e.env.Estimate(); }); },
          Doc("BinPickingEnv::Estimate"))
      .def(
          "choose_grasp",
          [](PythonEnv& e) {
            return e.guard.Run([&] { return std::optional<Grasp>(e.env.ChooseGrasp()); });
          },
          Doc("BinPickingEnv::ChooseGrasp"))
      .def_property_readonly("view", &PythonEnv::View, Doc("BinPickingEnv::View"))
      .def_property_readonly(
          "trials", [](PythonEnv& e) { return e.guard.Run([&] { return e.env.trials(); }); },
          Doc("BinPickingEnv::trials"))
      .def(
          "write",
          [](PythonEnv& e, const std::filesystem::path& folder) {
            e.guard.Run([&] { e.env.Write(folder); });
          },
          py::arg("folder"), Doc("BinPickingEnv::Write"))
      .def(
          "close", [](const PythonEnv&) {}, "Does nothing; Gymnasium calls it.");
}

}  // namespace pickbed::eval
