#include "eval/trial/trial_setup.h"

#include "eval/trial/oracle_estimator.h"
#include "grasp/candidates/candidates.h"
#include "grasp/grippers/requirements.h"
#include "grasp/grippers/table.h"
#include "grasp/plan/plan.h"
#include "scenes/scenario/policy.h"

namespace pickbed::eval {

TrialSetup::TrialSetup(const ScenarioSpec& scenario, const ObjectSet& objects,
                       const Progress& progress, const TrialOptions& trial_options)
    : spec(scenario),
      options(trial_options),
      on_progress(progress),
      cell(scenario, objects),
      gripper(WithSettingsKey(scenario, "gripper", [&] { return LoadGripper(scenario.gripper); })) {
  WithSettingsKey(scenario, "policy.stop", [&] { PolicyNamed(scenario.policy.stop); });
  WithSettingsKey(scenario, "policy.ranking", [&] { RankingNamed(scenario.policy.ranking); });
  execute.rule = WithSettingsKey(scenario, "policy.success",
                                 [&] { return DecidingRule(scenario.policy.success); });
  const OracleStages& truth = options.truth;
  if (!truth.AllOfPerception()) {
    estimator = std::make_unique<EstimatorRunner>(cell, scenario, 1, progress);
  }
  if (truth.pose && !truth.refinement && scenario.estimator.name != kOracleName) {
    refiner = std::make_unique<OracleRefiner>(cell.objects(), scenario.refiner);
  }
  for (size_t i = 0; i < cell.objects().size(); ++i) {
    const ObjectModel& model = *cell.objects()[i];
    metric_models.push_back(MakeMetricModel(model));
    candidates.emplace_back();
    if (!cell.IsWanted(ObjectId(i))) continue;
    WithSettingsKey(scenario, "gripper",
                    [&] { candidates.back() = RequireCandidates(model, *gripper); });
  }
}

}  // namespace pickbed::eval
