#include "eval/trial/trial_setup.h"

#include "eval/trial/oracle_estimator.h"
#include "grasp/candidates/candidates.h"
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
  if (!truth.AllOfPerception()) {
    estimator = MakeEstimatorRunner(cell, scenario, 1, progress, options.log_dir);
  }
  if (truth.pose && !truth.refinement && scenario.estimator.name != kOracleName) {
    refiner = std::make_unique<OracleRefiner>(cell.objects(), scenario.refiner);
  }
  candidates.resize(tools.size());
  for (size_t i = 0; i < cell.objects().size(); ++i) {
    const ObjectModel& model = *cell.objects()[i];
    metric_models.push_back(MakeMetricModel(model));
    for (auto& by_object : candidates) by_object.emplace_back();
    if (!cell.IsWanted(ObjectId(i))) continue;
    WithSettingsKey(scenario, "gripper", [&] {
      ToolCandidates of_object = RequireToolCandidates(model, tools);
      for (size_t k = 0; k < tools.size(); ++k) {
        candidates[k].back() = std::move(of_object.by_tool[k]);
      }
    });
  }
  for (size_t k = 0; k < tools.size(); ++k) {
    FillTolerance(scenario, cell.objects(), tools[k]->name, candidates[k]);
  }
}

}  // namespace pickbed::eval
