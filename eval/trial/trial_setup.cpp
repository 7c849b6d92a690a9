#include "eval/trial/trial_setup.h"

#include <fmt/format.h>

#include "eval/shapes/segment_shapes.h"
#include "eval/trial/oracle_estimator.h"
#include "grasp/candidates/candidates.h"
#include "grasp/completed/success_network.h"
#include "grasp/plan/plan.h"
#include "grasp/tolerance/tolerance_ranking.h"
#include "scenes/scenario/policy.h"

namespace pickbed::eval {

void TrialOptions::Visit(SettingsVisitor& v) {
  v.Real("retry_radius_m", retry_radius_m, {0, 10},
         "distance of the estimated positions within which a grasp repeats a failure, m");
  v.Real("retry_angle_rad", retry_angle_rad, {0, 3.2},
         "angle of the approaches within which a grasp repeats a failure, rad");
  v.Integer("retry_grasps", retry_grasps, {1, 1000000}, "number of grasps planned after a failure");
  v.Integer("cloud_stride_px", cloud_stride_px, {1, 1000}, "step of the observed points, px");
  v.Real("match_diameters", match_diameters, {0, 10},
         "MSSD within which a hypothesis matches an instance, diameters");
  v.Integer("true_grasps", true_grasps, {1, 1000000}, "number of grasps tried in the true scene");
}

const PlannerRow& PlannerOf(const ScenarioSpec& scenario, const OracleStages& truth) {
  const PlannerRow& row = *WithSettingsKey(scenario, "planner.name",
                                           [&] { return &PlannerNamed(scenario.planner.name); });
  if (row.needs_poses) return row;
  if (truth.AllOfPerception()) return PlannerNamed(kPosePlanner);
  const auto refuse = [&](bool is_set, const std::string& key, const std::string& why) {
    CheckInput(!is_set, fmt::format("{}: planner {} works without poses, {}", scenario.At(key),
                                    row.name, why));
  };
  const PolicySpec& policy = scenario.policy;
  refuse(scenario.occlusion.enabled, "occlusion.enabled",
         "so it cannot pick a chosen target; set it to false");
  refuse(policy.picks_per_image > 1, "policy.picks_per_image",
         "so it does not know which picks disturb each other; set it to 1");
  refuse(policy.check_lift, "policy.check_lift",
         "so it does not know the lifted object; set it to false");
  refuse(policy.ranking != PolicySpec().ranking, "policy.ranking",
         fmt::format("and ranks by its own score; set it to {}", PolicySpec().ranking));
  refuse(truth.detection || truth.pose || truth.refinement, "planner.name",
         "so there is no such stage to replace by ground truth; choose grasp, perception or "
         "everything");
  return row;
}

TrialSetup::TrialSetup(const ScenarioSpec& scenario, const ObjectSet& objects,
                       const Progress& progress, const TrialOptions& trial_options)
    : spec(scenario),
      options(trial_options),
      on_progress(progress),
      cell(scenario, objects),
      tools(
          WithSettingsKey(scenario, "gripper", [&] { return LoadTools(scenario.gripper.names); })) {
  CheckSettings("TrialOptions", options);
  WithSettingsKey(scenario, "policy.stop", [&] { PolicyNamed(scenario.policy.stop); });
  WithSettingsKey(scenario, "policy.ranking", [&] { RankingNamed(scenario.policy.ranking); });
  execute.rule = WithSettingsKey(scenario, "policy.success",
                                 [&] { return DecidingRule(scenario.policy.success); });
  execute.retention.max_g = scenario.policy.retention_g;
  execute.retention.is_lateral = scenario.policy.retention_load == "lateral";
  const OracleStages& truth = options.truth;
  // Measured surfaces that contradict the true poses would be obstacles for the planner.
  if (truth.AllOfPerception()) cell.MeasureExactly();
  const PlannerRow& planner_row = PlannerOf(scenario, truth);
  has_poses = planner_row.needs_poses;
  if (!options.estimator_on_demand) MakeEstimator();
  if (on_progress) {
    cell.SetOnPrepare([report = on_progress](int done, int total) {
      report("objects prepared", static_cast<double>(done) / total);
    });
  }
  if (has_poses) cell.PrepareAllObjects();
  candidates.resize(tools.size());
  for (size_t i = 0; i < cell.objects().size(); ++i) {
    const ObjectModel& model = *cell.objects()[i];
    metric_models.push_back(MakeMetricModel(model));
    for (auto& by_object : candidates) by_object.emplace_back();
    if (!cell.IsWanted(ObjectId(i)) || !has_poses) continue;
    WithSettingsKey(scenario, "gripper", [&] {
      ToolCandidates of_object = RequireToolCandidates(model, tools);
      for (size_t k = 0; k < tools.size(); ++k) {
        candidates[k].back() = std::move(of_object.by_tool[k]);
      }
    });
  }
  for (size_t k = 0; has_poses && k < tools.size(); ++k) {
    FillTolerance(scenario, cell.objects(), tools[k]->name, candidates[k]);
  }
  PlanOptions plan_options;
  plan_options.ranking = scenario.policy.ranking;
  std::shared_ptr<const SuccessNetwork> network;
  if (planner_row.needs_shapes) {
    const PlannerSpec& with = scenario.planner;
    WithSettingsKey(scenario, "planner.segmentation", [&] { SegmenterNamed(with.segmentation); });
    const std::string completion =
        planner_row.completion != nullptr ? planner_row.completion : with.completion;
    shapes = WithSettingsKey(scenario, "planner.completion", [&] {
      return std::make_shared<SegmentShapes>(with.segmentation, completion);
    });
    network = WithSettingsKey(scenario, "planner.success_model",
                              [&] { return SuccessNetworkNamed(with.success_model); });
  }
  planner = WithSettingsKey(scenario, "planner.name", [&] {
    return planner_row.make({scenario.planner, tools, cell.objects(), candidates, plan_options,
                             options.cloud_stride_px, cell.camera().intrinsics,
                             WorkingDistance_m(cell), cell.bin(), options.log_dir, shapes.get(),
                             network});
  });
}

void TrialSetup::MakeEstimator() {
  if (has_estimator) return;
  const OracleStages& truth = options.truth;
  if (has_poses && !truth.AllOfPerception()) {
    estimator = MakeEstimatorRunner(cell, spec, 1, on_progress, options.log_dir);
  }
  if (truth.pose && !truth.refinement && spec.estimator.name != kOracleName) {
    refiner = std::make_unique<OracleRefiner>(cell.objects(), spec.refiner);
  }
  has_estimator = true;
}

void TrialSetup::SetSeed(uint64_t seed) {
  ScenarioSpec reseeded = spec;
  reseeded.seed = seed;
  RequireSizesFit(reseeded, cell.objects(), tools);
  spec.seed = seed;
  cell.SetSeed(seed);
}

}  // namespace pickbed::eval
