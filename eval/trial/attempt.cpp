#include "eval/trial/attempt.h"

#include <fmt/format.h>

#include "eval/trial/failure_attribution.h"
#include "eval/trial/observer.h"
#include "eval/trial/oracle_estimator.h"
#include "eval/trial/pose_matching.h"
#include "scenes/base/random.h"

namespace pickbed::eval {
namespace {

Observation Capture(TrialSetup& setup, int attempt, LiveTrial& trial) {
  const StageTimer timer(trial.seconds, "capture");
  return setup.cell.Capture(trial.scene, trial.bin_index, attempt);
}

// The instances that stage oracles take as visible, with their true poses.
std::vector<TrueInstance> VisibleInstances(const TrialSetup& setup, const Scene& scene,
                                           const Observation& view) {
  std::vector<TrueInstance> instances;
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    const double visible = view.visible_fractions[i];
    if (!setup.cell.IsWanted(posed.object)) continue;
    if (!setup.options.truth.sense && visible < kCountedVisibility) continue;
    instances.push_back({posed.object, setup.cell.camera().X_CW() * posed.X_WO, visible});
  }
  return instances;
}

// The poses of the estimator, with ground truth in place of the stages that an oracle replaces.
std::vector<PoseHypothesis> EstimatePoses(TrialSetup& setup, const Observation& view, int attempt,
                                          LiveTrial& trial) {
  EstimateResult result;
  if (setup.estimator) {
    Rng rng = Rng::Derive(setup.spec.seed, trial.bin_index, fmt::format("estimate/{}", attempt));
    result = EstimateWithOracle(*setup.estimator, trial.scene, view, rng);
    for (const auto& [stage, value] : result.seconds) trial.seconds[stage] += value;
  }
  const OracleStages& truth = setup.options.truth;
  if (!truth.detection && !truth.pose && !truth.refinement) return result.hypotheses;
  auto hypotheses =
      SubstituteTruth(std::move(result.hypotheses), VisibleInstances(setup, trial.scene, view),
                      setup.metric_models, truth);
  if (setup.refiner) {
    setup.refiner->Refine(view.frame, {setup.cell.bin(), setup.cell.camera().X_CW()}, hypotheses);
  }
  return hypotheses;
}

void ScoreHypotheses(const TrialSetup& setup, const Observation& view,
                     const std::vector<PoseHypothesis>& hypotheses, LiveTrial& trial,
                     AttemptRecord& record) {
  const StageTimer timer(trial.seconds, "score");
  AttemptScore score = ScoreAgainstTruth(trial.scene, view.visible_fractions, setup.metric_models,
                                         setup.cell.camera(), hypotheses);
  const std::vector<FailureReason> missed =
      MissReasons(score, hypotheses, {trial.scene, setup.metric_models, setup.cell.camera()});
  for (size_t i = 0; i < missed.size(); ++i) score.instances[i].missed = missed[i];
  record.instances = std::move(score.instances);
  record.hypotheses = std::move(score.hypotheses);
}

std::vector<EstimatedPose> ToWorld(const std::vector<PoseHypothesis>& hypotheses,
                                   const Pose& X_WC) {
  std::vector<EstimatedPose> poses;
  for (const PoseHypothesis& h : hypotheses) poses.push_back({h.object, X_WC * h.X_CO, h.score});
  return poses;
}

// Executes record.grasp and returns the scene after it.
Scene Execute(const TrialSetup& setup, const EstimatedPose& pose, LiveTrial& trial,
              AttemptRecord& record) {
  const StageTimer timer(trial.seconds, "execute");
  record.matched_instance =
      MatchedInstance(record.hypotheses[record.chosen], setup.options.match_diameters);
  ExecuteResult executed = TryGrasp(setup, trial.scene, *record.grasp, pose, record);
  record.outcome = executed.outcome;
  trial.failed.Remember(*record.grasp, pose, record.outcome);
  return std::move(executed.after);
}

}  // namespace

AttemptRecord RunAttempt(TrialSetup& setup, const AttemptTask& task, LiveTrial& trial) {
  AttemptRecord record;
  record.attempt = task.attempt;
  record.target = task.target;
  record.band = task.band;
  AttemptState state{trial.bin_index, setup.cell, *setup.gripper, trial.scene, record};
  const auto reach = [&](TrialStage stage) { ReachStage(stage, state, record, trial.observer); };

  reach(TrialStage::kScene);
  const Observation view = Capture(setup, task.attempt, trial);
  state.view = &view;
  reach(TrialStage::kImage);
  const std::vector<PoseHypothesis> hypotheses = EstimatePoses(setup, view, task.attempt, trial);
  state.hypotheses = &hypotheses;
  ScoreHypotheses(setup, view, hypotheses, trial, record);
  reach(TrialStage::kHypotheses);
  const std::vector<EstimatedPose> poses = ToWorld(hypotheses, setup.cell.camera().X_WC());
  const uint64_t plan_seed =
      Rng::Derive(setup.spec.seed, trial.bin_index, fmt::format("plan/{}", task.attempt)).Next();
  record.grasp =
      ChooseGrasp(setup, trial.scene, view, poses, trial.failed, plan_seed, record, trial.seconds);
  reach(TrialStage::kGrasp);
  Scene after = trial.scene;
  if (record.grasp) {
    record.chosen = record.grasp->hypothesis;
    after = Execute(setup, poses[record.chosen], trial, record);
  }
  record.failure = AttributeFailure(record, hypotheses, setup.options.match_diameters,
                                    {trial.scene, setup.metric_models, setup.cell.camera()});
  trial.scene = std::move(after);
  reach(TrialStage::kOutcome);
  return record;
}

}  // namespace pickbed::eval
