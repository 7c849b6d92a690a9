#include "eval/python/records.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>

#include "eval/python/arrays.h"
#include "eval/python/docstring.h"
#include "eval/python/module.h"
#include "eval/trial/instance_matcher.h"
#include "eval/trial/trial_records.h"
#include "grasp/plan/plan.h"
#include "perception/estimators/pose_estimator.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace py = pybind11;

constexpr double kMaxGraspDistance_m = 20;
constexpr double kMaxWidth_m = 10;
constexpr double kMaxAside_m = 1;

// The names of failure reasons are the same as in the results files.
template <FailureReason AttemptRecord::*kMember>
std::string_view NameIn(const AttemptRecord& record) {
  return FailureName(record.*kMember);
}

py::dict VerdictsOf(const GraspOutcome& outcome) {
  py::dict verdicts;
  for (const SuccessRuleRow& row : SuccessRuleTable()) {
    verdicts[row.name] = bool{outcome.verdicts[static_cast<int>(row.rule)]};
  }
  return verdicts;
}

py::dict HashesOf(const AttemptRecord& record) {
  py::dict hashes;
  for (const TrialStage stage : kTrialStages) hashes[StageName(stage)] = record.hashes[stage];
  return hashes;
}

py::dict MetricsOf(const HypothesisRecord& record) {
  py::dict metrics;
  for (const MetricValue& value : record.metrics) metrics[value.metric.c_str()] = value.value;
  return metrics;
}

void AddGrasp(py::module_& module) {
  module.attr("NO_HYPOTHESIS") = kNoHypothesis;
  py::class_<Grasp>(module, "Grasp", Doc("Grasp"))
      .def(
          py::init([](py::handle X_WG, double width_m, double score, int hypothesis,
                      const std::string& tool, const std::array<double, 2>& lift_aside_m) {
            Grasp grasp = MakeGrasp(X_WG, width_m, score, hypothesis, tool);
            grasp.lift_aside_m = {lift_aside_m[0], lift_aside_m[1]};
            const double aside_m = grasp.lift_aside_m.norm();
            CheckInput(aside_m <= kMaxAside_m,
                       fmt::format("lift_aside_m is {:.4g} m long: must be from 0 to {}, in metres",
                                   aside_m, kMaxAside_m));
            return grasp;
          }),
          py::arg("X_WG"), py::arg("width_m"), py::arg("score") = 1.0,
          py::arg("hypothesis") = kNoHypothesis, py::arg("tool") = "",
          py::arg("lift_aside_m") = std::array<double, 2>{0, 0},
          "`X_WG` is the pose of the hand when its fingers close. `width_m` is the distance "
          "between "
          "the two contacts; the hand opens wider for the approach. `hypothesis` is the index of "
          "the estimated pose that is grasped, -1 = none. `tool` is the name of the gripper; empty "
          "= the first one. `lift_aside_m` is the horizontal shift (x, y) of the hand in the world "
          "at the start of the lift.")
      .def_property_readonly("X_WG", [](const Grasp& g) { return ArrayOf(g.X_WG); })
      .def_readonly("width_m", &Grasp::width_m)
      .def_readonly("score", &Grasp::score)
      .def_readonly("hypothesis", &Grasp::hypothesis, Doc("Grasp::hypothesis"))
      .def_readonly("tool", &Grasp::tool, Doc("Grasp::tool"))
      .def_property_readonly(
          "lift_aside_m",
          [](const Grasp& g) {
            return std::array{g.lift_aside_m.x(), g.lift_aside_m.y()};
          },
          Doc("Grasp::lift_aside_m"))
      .def("__repr__", [](const Grasp& g) {
        const Eigen::Vector3d& p = g.X_WG.translation();
        return fmt::format("<Grasp at [{:.4f}, {:.4f}, {:.4f}] m, width {:.4f} m, score {:.3f}>",
                           p.x(), p.y(), p.z(), g.width_m, g.score);
      });
  py::class_<PlanResult>(module, "PlanResult", Doc("PlanResult"))
      .def_readonly("grasps", &PlanResult::grasps, Doc("PlanResult::grasps"))
      .def_readonly("rejected", &PlanResult::rejected, Doc("PlanResult::rejected"))
      .def_property_readonly(
          "failure",
          [](const PlanResult& r) {
            return r.failure ? std::optional(r.failure->text) : std::nullopt;
          },
          Doc("PlanResult::failure"));
}

void AddHypotheses(py::module_& module) {
  py::class_<PoseHypothesis>(module, "PoseHypothesis", Doc("PoseHypothesis"))
      .def(py::init(&MakeHypothesis), py::arg("object"), py::arg("X_CO"), py::arg("score") = 1.0,
           "`object` is an index into Scenario.objects. `X_CO` is the pose of the object in the "
           "camera frame. `score` is the probability that the pose is right, 0..1.")
      .def_property_readonly("object", [](const PoseHypothesis& h) { return int{h.object}; })
      .def_property_readonly("X_CO", [](const PoseHypothesis& h) { return ArrayOf(h.X_CO); })
      .def_readonly("score", &PoseHypothesis::score, Doc("PoseHypothesis::score"))
      .def_property_readonly(
          "inlier_share", [](const PoseHypothesis& h) { return h.fit.inlier_share; },
          Doc("FitReport::inlier_share"))
      .def("__repr__", [](const PoseHypothesis& h) {
        const Eigen::Vector3d& p = h.X_CO.translation();
        return fmt::format(
            "<PoseHypothesis of object {} at [{:.4f}, {:.4f}, {:.4f}] m, score {:.3f}>",
            int{h.object}, p.x(), p.y(), p.z(), h.score);
      });
  py::class_<EstimateResult>(module, "EstimateResult", Doc("EstimateResult"))
      .def_readonly("hypotheses", &EstimateResult::hypotheses, Doc("EstimateResult::hypotheses"))
      .def_readonly("seconds", &EstimateResult::seconds, "wall time by stage, s")
      .def_property_readonly(
          "failure",
          [](const EstimateResult& r) {
            return r.failure ? std::optional(r.failure->text) : std::nullopt;
          },
          Doc("EstimateResult::failure"));
  py::class_<HypothesisRecord>(module, "HypothesisRecord", Doc("HypothesisRecord"))
      .def_property_readonly("object", [](const HypothesisRecord& r) { return int{r.object}; })
      .def_property_readonly(
          "instance", [](const HypothesisRecord& r) { return int{r.instance}; },
          Doc("HypothesisRecord::instance"))
      .def_readonly("score", &HypothesisRecord::score)
      .def_readonly("correct", &HypothesisRecord::correct, Doc("HypothesisRecord::correct"))
      .def_property_readonly("metrics", &MetricsOf, Doc("HypothesisRecord::metrics"))
      .def_property_readonly(
          "X_WO", [](const HypothesisRecord& r) { return ArrayOf(r.X_WO); },
          Doc("HypothesisRecord::X_WO"))
      .def_property_readonly(
          "X_OE", [](const HypothesisRecord& r) { return ArrayOf(r.X_OE); },
          Doc("HypothesisRecord::X_OE"));
}

void AddInstances(py::module_& module) {
  py::class_<TrueInstance>(module, "TrueInstance", Doc("TrueInstance"))
      .def_property_readonly(
          "instance", [](const TrueInstance& t) { return int{t.instance}; },
          "number of the instance; the id image contains it + 1")
      .def_property_readonly(
          "object", [](const TrueInstance& t) { return int{t.object}; },
          "index into Scenario.objects")
      .def_property_readonly("X_CO", [](const TrueInstance& t) { return ArrayOf(t.X_CO); })
      .def_readonly("visible_fraction", &TrueInstance::visible_fraction,
                    "visible share of its pixels, 0..1; 0 for a distractor");
  py::class_<InstanceRecord>(module, "InstanceRecord", Doc("InstanceRecord"))
      .def_property_readonly("instance", [](const InstanceRecord& r) { return int{r.instance}; })
      .def_property_readonly("object", [](const InstanceRecord& r) { return int{r.object}; })
      .def_readonly("visible_fraction", &InstanceRecord::visible_fraction)
      .def_readonly("recalled", &InstanceRecord::recalled, Doc("InstanceRecord::recalled"))
      .def_property_readonly(
          "missed", [](const InstanceRecord& r) { return FailureName(r.missed); },
          Doc("InstanceRecord::missed"));
}

void AddOutcome(py::module_& module) {
  using Outcome = GraspOutcome;
  py::class_<Outcome>(module, "GraspOutcome", Doc("GraspOutcome"))
      .def_readonly("success", &Outcome::success, Doc("GraspOutcome::success"))
      .def_property_readonly(
          "failure", [](const Outcome& o) { return FailureName(o.failure); },
          "failure reason, \"none\" on success")
      .def_property_readonly(
          "picked_instance", [](const Outcome& o) { return int{o.picked_instance}; },
          Doc("GraspOutcome::picked_instance"))
      .def_readonly("instances_lifted", &Outcome::instances_lifted,
                    Doc("GraspOutcome::instances_lifted"))
      .def_readonly("instances_entangled", &Outcome::instances_entangled,
                    Doc("GraspOutcome::instances_entangled"))
      .def_readonly("final_opening_m", &Outcome::final_opening_m)
      .def_readonly("slip_m", &Outcome::slip_m, Doc("GraspOutcome::slip_m"))
      .def_readonly("in_hand_rotation_error_rad", &Outcome::in_hand_rotation_error_rad,
                    Doc("GraspOutcome::in_hand_rotation_error_rad"))
      .def_readonly("neighbors_displaced", &Outcome::neighbors_displaced,
                    Doc("GraspOutcome::neighbors_displaced"))
      .def_readonly("is_target", &Outcome::is_target, Doc("GraspOutcome::is_target"))
      .def_readonly("instances_touched", &Outcome::instances_touched,
                    Doc("GraspOutcome::instances_touched"))
      .def_readonly("lift_height_m", &Outcome::lift_height_m, Doc("GraspOutcome::lift_height_m"))
      .def_readonly("place_executed", &Outcome::place_executed, Doc("GraspOutcome::place_executed"))
      .def_readonly("place_error_m", &Outcome::place_error_m, Doc("GraspOutcome::place_error_m"))
      .def_readonly("place_rotation_error_rad", &Outcome::place_rotation_error_rad,
                    Doc("GraspOutcome::place_rotation_error_rad"))
      .def_readonly("retention_g", &Outcome::retention_g, Doc("GraspOutcome::retention_g"))
      .def_property_readonly("verdicts", &VerdictsOf, "verdict of each success rule, by name")
      .def("__repr__", [](const Outcome& o) {
        return fmt::format("<GraspOutcome: {}>", o.success ? "success" : FailureName(o.failure));
      });
}

void AddAttempts(py::module_& module) {
  using Record = AttemptRecord;
  py::class_<Record>(module, "AttemptRecord", Doc("AttemptRecord"))
      .def_readonly("attempt", &Record::attempt, Doc("AttemptRecord::attempt"))
      .def_readonly("pick_of_image", &Record::pick_of_image, Doc("AttemptRecord::pick_of_image"))
      .def_readonly("pose_free", &Record::pose_free, Doc("AttemptRecord::pose_free"))
      .def_readonly("instances", &Record::instances)
      .def_readonly("hypotheses", &Record::hypotheses)
      .def_readonly("chosen", &Record::chosen, Doc("AttemptRecord::chosen"))
      .def_property_readonly(
          "matched_instance", [](const Record& r) { return int{r.matched_instance}; },
          Doc("AttemptRecord::matched_instance"))
      .def_readonly("grasp", &Record::grasp, Doc("AttemptRecord::grasp"))
      .def_readonly("grasps_rejected", &Record::grasps_rejected,
                    Doc("AttemptRecord::grasps_rejected"))
      .def_readonly("outcome", &Record::outcome)
      .def_property_readonly("failure", &NameIn<&Record::failure>,
                             "failure reason of the attempt, \"none\" on success")
      .def_readonly("fill_level", &Record::fill_level, Doc("AttemptRecord::fill_level"))
      .def_readonly("layer", &Record::layer, Doc("AttemptRecord::layer"))
      .def_property_readonly("hashes", &HashesOf, Doc("StageHashes"))
      .def("__repr__", [](const Record& r) {
        return fmt::format("<AttemptRecord {}: {}>", r.attempt, FailureName(r.failure));
      });
  using Trial = TrialResult;
  py::class_<Trial>(module, "TrialResult",
                    "Record of one bin, from the drop to the end of picking.")
      .def_property_readonly(
          "bin_index", [](const Trial& t) { return int{t.bin_index}; },
          Doc("TrialResult::bin_index"))
      .def_readonly("instances_dropped", &Trial::instances_dropped)
      .def_readonly("instances_cleared", &Trial::instances_cleared,
                    Doc("TrialResult::instances_cleared"))
      .def_readonly("attempts", &Trial::attempts)
      .def_property_readonly(
          "ended_by", [](const Trial& t) { return FailureName(t.ended_by); },
          "failure reason that ended the trial; \"none\" if the bin is empty or the number of "
          "attempts was reached")
      .def_readonly("seconds", &Trial::seconds, "wall time by stage, s");
}

}  // namespace

Grasp MakeGrasp(py::handle X_WG, double width_m, double score, int hypothesis,
                const std::string& tool) {
  Grasp grasp;
  grasp.X_WG = PoseFrom(X_WG, "X_WG");
  const double distance_m = grasp.X_WG.translation().norm();
  CheckInput(distance_m <= kMaxGraspDistance_m,
             fmt::format("X_WG is {:.4g} m from the bin; positions are in metres", distance_m));
  CheckInput(width_m >= 0 && width_m <= kMaxWidth_m,
             fmt::format("width_m = {}: must be from 0 to {}, in metres", width_m, kMaxWidth_m));
  CheckInput(std::isfinite(score), fmt::format("score = {}: must be finite", score));
  grasp.width_m = width_m;
  grasp.score = score;
  grasp.hypothesis = hypothesis;
  grasp.tool = tool;
  return grasp;
}

PoseHypothesis MakeHypothesis(int object, py::handle X_CO, double score) {
  PoseHypothesis hypothesis;
  hypothesis.object = ObjectId(object);
  hypothesis.X_CO = PoseFrom(X_CO, "X_CO");
  CheckInput(score >= 0 && score <= 1, fmt::format("score = {}: must be from 0 to 1", score));
  hypothesis.score = score;
  return hypothesis;
}

void AddRecords(py::module_& module) {
  AddGrasp(module);
  AddHypotheses(module);
  AddInstances(module);
  AddOutcome(module);
  AddAttempts(module);
}

}  // namespace pickbed::eval
