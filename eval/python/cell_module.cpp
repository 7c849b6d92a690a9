#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "eval/python/arrays.h"
#include "eval/python/calls.h"
#include "eval/python/cell.h"
#include "eval/python/docstring.h"
#include "eval/python/module.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace py = pybind11;

BinIndex BinFrom(int bin_index) {
  CheckInput(bin_index >= 0, fmt::format("bin_index = {}: must not be negative", bin_index));
  return BinIndex(bin_index);
}

int AttemptFrom(int attempt) {
  CheckInput(attempt >= 0, fmt::format("attempt = {}: must not be negative", attempt));
  return attempt;
}

// The cell and the guard of its renderer.
struct PythonCell {
  CallGuard guard{"Cell"};
  Cell cell;
  explicit PythonCell(std::shared_ptr<const LoadedScenario> scenario)
      : cell(std::move(scenario), {HandleSignals, WarnInPython}) {}
};

py::array MaskOf(const CapturedView& view, int instance) {
  const auto& instances = view.instances;
  const bool is_known = std::any_of(instances.begin(), instances.end(),
                                    [&](const auto& t) { return t.instance == instance; });
  CheckInput(is_known, fmt::format("the image has no instance {}", instance));
  const Image<uint16_t>& ids = view.observation->ids;
  py::array_t<bool> mask({ids.height(), ids.width()});
  bool* pixel = mask.mutable_data();
  for (const uint16_t id : ids.pixels()) *pixel++ = id == instance + 1;
  return mask;
}

void AddContent(py::module_& module) {
  py::class_<PosedObject>(module, "PosedObject", Doc("PosedObject"))
      .def_property_readonly(
          "instance", [](const PosedObject& p) { return int{p.instance}; },
          Doc("PosedObject::instance"))
      .def_property_readonly(
          "object", [](const PosedObject& p) { return int{p.object}; },
          "index into Scenario.objects")
      .def_property_readonly("X_WO", [](const PosedObject& p) { return ArrayOf(p.X_WO); });
  py::class_<BinContent>(module, "BinContent", Doc("BinContent"))
      .def_property_readonly("instances", [](const BinContent& c) { return c.scene.objects; })
      .def_property_readonly("bin_index", [](const BinContent& c) { return int{c.bin_index}; })
      .def_readonly("object_names", &BinContent::object_names)
      .def("__len__", [](const BinContent& c) { return c.scene.objects.size(); })
      .def("__repr__", [](const BinContent& c) {
        return fmt::format("<BinContent of bin {}: {} instances>", int{c.bin_index},
                           c.scene.objects.size());
      });
}

void AddView(py::module_& module) {
  // An image shares its memory with the arrays, which keep the view alive.
  const auto shared = [](auto member) {
    return [member](const py::object& self) {
      return Share(member(*self.cast<const CapturedView&>().observation), self);
    };
  };
  py::class_<CapturedView>(module, "CapturedView", Doc("CapturedView"))
      .def_property_readonly(
          "color", shared([](const Observation& o) -> const Image<Rgb8>& { return o.frame.color; }),
          "color image, height x width x 3, uint8, sRGB")
      .def_property_readonly("depth_m", shared([](const Observation& o) -> const Image<float>& {
                               return o.frame.depth_m;
                             }),
                             "depth image with sensor noise, height x width, float32, metres along "
                             "camera z, 0 = no reading")
      .def_property_readonly(
          "ids", shared([](const Observation& o) -> const Image<uint16_t>& { return o.ids; }),
          Doc("Observation::ids"))
      .def_property_readonly(
          "camera", [](const CapturedView& v) { return v.observation->frame.intrinsics; },
          "intrinsics of the camera, as calibrated")
      .def_property_readonly(
          "K", [](const CapturedView& v) { return CameraMatrix(v.observation->frame.intrinsics); },
          "3 x 3 camera matrix, px")
      .def_property_readonly(
          "X_WC",
          [](const CapturedView& v) { return ArrayOf(v.observation->calibration.camera.X_WC()); },
          "pose of the camera in the world, as calibrated")
      .def_readonly("content", &CapturedView::content, "ground truth: the bin in the image")
      .def_readonly("instances", &CapturedView::instances, "ground truth of each instance")
      .def_property_readonly(
          "visible_fractions",
          [](const CapturedView& v) { return v.observation->visible_fractions; },
          "ground truth: visible fraction of each instance, 0 for distractors")
      .def("instance_mask", &MaskOf, py::arg("instance"),
           "Returns the visible pixels of an instance, an array of bool.")
      .def_readonly("attempt", &CapturedView::attempt, Doc("CapturedView::attempt"));
}

}  // namespace

void AddCell(py::module_& module) {
  AddContent(module);
  AddView(module);
  using Hypotheses = std::vector<PoseHypothesis>;
  py::class_<PythonCell>(module, "Cell", Doc("Cell"))
      .def(py::init([](std::shared_ptr<LoadedScenario> scenario) {
             return WithoutLock([&] { return std::make_unique<PythonCell>(std::move(scenario)); });
           }),
           py::arg("scenario").none(false), Doc("Cell::Cell"))
      .def(
          "drop",
          [](PythonCell& c, int bin_index) {
            const BinIndex bin = BinFrom(bin_index);
            return c.guard.Run([&] { return c.cell.Drop(bin); });
          },
          py::arg("bin_index") = 0, Doc("Cell::Drop"))
      .def(
          "capture",
          [](PythonCell& c, const BinContent& content, int attempt) {
            AttemptFrom(attempt);
            return c.guard.Run([&] { return c.cell.Capture(content, attempt); });
          },
          py::arg("content"), py::arg("attempt") = 0, Doc("Cell::Capture"))
      .def(
          "estimate",
          [](PythonCell& c, const CapturedView& view) {
            return c.guard.Run([&] { return c.cell.Estimate(view); });
          },
          py::arg("view"), Doc("Cell::Estimate"))
      .def(
          "estimate_frame",
          [](PythonCell& c, const CameraIntrinsics& camera, py::handle X_WC, py::handle depth_m,
             const py::object& color, uint64_t seed) {
            RgbdFrame frame{camera, {}, DepthFrom(depth_m, camera)};
            if (!color.is_none()) frame.color = ColorFrom(color, camera);
            const Camera posed(camera, PoseFrom(X_WC, "X_WC"));
            return c.guard.Run([&] { return c.cell.EstimateFrame(frame, posed, seed); });
          },
          py::arg("camera"), py::arg("X_WC"), py::arg("depth_m"), py::arg("color") = py::none(),
          py::arg("seed") = 0, Doc("Cell::EstimateFrame"))
      .def(
          "score",
          [](PythonCell& c, const CapturedView& view, const Hypotheses& hypotheses) {
            return c.guard.Run([&] { return c.cell.Score(view, hypotheses); });
          },
          py::arg("view"), py::arg("hypotheses"), Doc("Cell::Score"))
      .def(
          "plan",
          [](PythonCell& c, const CapturedView& view, const Hypotheses& hypotheses,
             int max_grasps) {
            return c.guard.Run([&] { return c.cell.Plan(view, hypotheses, max_grasps); });
          },
          py::arg("view"), py::arg("hypotheses") = Hypotheses(),
          py::arg("max_grasps") = PlanOptions().max_grasps, Doc("Cell::Plan"))
      .def(
          "execute",
          [](PythonCell& c, const BinContent& content, const Grasp& grasp,
             const Hypotheses& hypotheses, int attempt) {
            AttemptFrom(attempt);
            PickResult result =
                c.guard.Run([&] { return c.cell.Execute(content, grasp, hypotheses, attempt); });
            return std::make_pair(result.outcome, std::move(result.after));
          },
          py::arg("content"), py::arg("grasp"), py::arg("hypotheses") = Hypotheses(),
          py::arg("attempt") = 0, Doc("Cell::Execute"))
      .def(
          "run_trial",
          [](PythonCell& c, int bin_index) {
            const BinIndex bin = BinFrom(bin_index);
            return c.guard.Run([&] { return c.cell.RunTrial(bin); });
          },
          py::arg("bin_index") = 0, Doc("Cell::RunTrial"))
      .def_property_readonly(
          "camera", [](const PythonCell& c) { return c.cell.camera().intrinsics; },
          Doc("Cell::camera"))
      .def_property_readonly(
          "X_WC", [](const PythonCell& c) { return ArrayOf(c.cell.camera().X_WC()); },
          "true pose of the camera in the world")
      .def_property_readonly(
          "objects",
          [](const PythonCell& c) {
            std::vector<std::shared_ptr<ObjectModel>> objects;
            for (const auto& object : c.cell.objects()) {
              objects.push_back(std::const_pointer_cast<ObjectModel>(object));
            }
            return objects;
          },
          Doc("Cell::objects"));
}

}  // namespace pickbed::eval
