#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>
#include <memory>

#include "eval/bop/vsd.h"
#include "eval/metrics/metric_table.h"
#include "eval/metrics/pose_errors.h"
#include "eval/python/arrays.h"
#include "eval/python/calls.h"
#include "eval/python/docstring.h"
#include "eval/python/module.h"
#include "scenes/base/error.h"
#include "sim/render/renderer.h"

namespace pickbed::eval {
namespace {

namespace py = pybind11;

// An object for the metrics, and its renderer for VSD.
struct PythonMetricModel {
  std::shared_ptr<const ObjectModel> object;
  MetricModel metric;
  CallGuard guard{"MetricModel"};
  std::unique_ptr<Renderer> renderer = nullptr;  // made on first use

  DistanceCrop Draw(const Pose& X_CO, const CameraIntrinsics& camera) {
    if (!renderer) {
      renderer = std::make_unique<Renderer>(GlContextOptions(), DetailOptions{0, 0});
      renderer->AddMesh(object->mesh_O);
    }
    const RenderInstance instance{0, X_CO, 1};
    const RenderedImage image = renderer->RenderDepth({camera, Pose::Identity()}, {&instance, 1});
    return DistanceCropOf(image.depth_m, camera);
  }
};

// Rotations keep their rounding errors, so that pose errors are equal to the BOP toolkit.
struct PosePair {
  Pose X_est, X_true;
  PosePair(py::handle est, py::handle truth)
      : X_est(PoseFrom(est, "X_est", true)), X_true(PoseFrom(truth, "X_true", true)) {}
};

template <double (*kError)(const MetricModel&, const Pose&, const Pose&)>
double ErrorOf(const PythonMetricModel& model, py::handle X_est, py::handle X_true) {
  const PosePair pair(X_est, X_true);
  return WithoutLock([&] { return kError(model.metric, pair.X_est, pair.X_true); });
}

std::vector<double> VsdOf(PythonMetricModel& model, const CameraIntrinsics& camera,
                          py::handle X_est, py::handle X_true, py::handle depth,
                          py::handle tau_values, double delta_m) {
  const PosePair pair(X_est, X_true);
  const Image<float> depth_m = DepthFrom(depth, camera);
  const std::vector<double> taus = NumbersFrom(tau_values, "taus");
  for (const double tau : taus) {
    CheckInput(tau > 0, fmt::format("taus has the value {}: must be positive", tau));
  }
  CheckInput(delta_m >= 0 && std::isfinite(delta_m),
             fmt::format("delta_m = {}: must be finite and not negative", delta_m));
  return model.guard.Run([&] {
    const DistanceCrop estimated = model.Draw(pair.X_est, camera);
    const DistanceCrop truth = model.Draw(pair.X_true, camera);
    return Vsd(estimated, truth, DistancesOf(depth_m, camera), model.metric.diameter_m, taus,
               {delta_m});
  });
}

}  // namespace

void AddMetrics(py::module_& module) {
  using Model = PythonMetricModel;
  py::class_<Model>(module, "MetricModel", Doc("MetricModel"))
      .def(py::init([](std::shared_ptr<ObjectModel> object, int max_vertices) {
             CheckInput(max_vertices >= 0,
                        fmt::format("max_vertices = {}: must not be negative", max_vertices));
             return WithoutLock([&] {
               MetricModel metric = MakeMetricModel(*object, max_vertices);
               return std::unique_ptr<Model>(new Model{std::move(object), std::move(metric)});
             });
           }),
           py::arg("object").none(false), py::arg("max_vertices") = 2000, Doc("MakeMetricModel"))
      .def_property_readonly(
          "vertices_O_m",
          [](const py::object& self) {
            return Share(self.cast<const Model&>().metric.vertices_O, self);
          },
          Doc("MetricModel::vertices_O"))
      .def_property_readonly(
          "symmetries_O", [](const Model& m) { return ArrayOf(m.metric.symmetries_O); },
          Doc("MetricModel::symmetries_O"))
      .def_property_readonly("diameter_m", [](const Model& m) { return m.metric.diameter_m; });
  const auto add = [&](const char* name, auto function, const char* doc) {
    module.def(name, function, py::arg("model"), py::arg("X_est"), py::arg("X_true"), doc);
  };
  add("mssd_m", ErrorOf<Mssd>, Doc("Mssd"));
  add("add_m", ErrorOf<Add>, Doc("Add"));
  add("adi_m", ErrorOf<Adi>, Doc("Adi"));
  add("rotation_error_rad", ErrorOf<RotationError>, Doc("RotationError"));
  add("translation_error_m", ErrorOf<TranslationError>, Doc("TranslationError"));
  module.def(
      "mspd_px",
      [](const Model& model, const CameraIntrinsics& camera, py::handle X_est, py::handle X_true) {
        const PosePair pair(X_est, X_true);
        return WithoutLock([&] { return Mspd(model.metric, camera, pair.X_est, pair.X_true); });
      },
      py::arg("model"), py::arg("camera"), py::arg("X_est"), py::arg("X_true"), Doc("Mspd"));
  module.def("vsd", VsdOf, py::arg("model"), py::arg("camera"), py::arg("X_est"), py::arg("X_true"),
             py::arg("depth_m"), py::arg("taus"), py::arg("delta_m") = VsdOptions().delta_m,
             "Visible Surface Discrepancy of BOP. `depth_m` is the measured image, `taus` are "
             "tolerances in diameters, and a pixel up to `delta_m` behind the measured surface is "
             "visible. Returns one error in 0..1 for each tolerance.");
  module.def(
      "pose_errors",
      [](const Model& model, const CameraIntrinsics& camera, py::handle X_est, py::handle X_true) {
        const PosePair pair(X_est, X_true);
        const MetricValues values = WithoutLock([&] {
          return RecordedMetrics({model.metric, camera, pair.X_est, pair.X_true});
        });
        py::dict errors;
        for (const MetricValue& value : values) errors[value.metric.c_str()] = value.value;
        return errors;
      },
      py::arg("model"), py::arg("camera"), py::arg("X_est"), py::arg("X_true"),
      Doc("RecordedMetrics"));
}

}  // namespace pickbed::eval
