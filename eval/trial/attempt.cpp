#include "eval/trial/attempt.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "eval/trial/failure_attribution.h"
#include "eval/trial/instance_matcher.h"
#include "eval/trial/observer.h"
#include "eval/trial/oracle_estimator.h"
#include "eval/trial/pose_matching.h"
#include "grasp/execute/stir.h"
#include "scenes/base/ids_format.h"
#include "scenes/base/random.h"
#include "sim/drop/fill_level.h"

namespace pickbed::eval {
namespace {

Observation Capture(TrialSetup& setup, int attempt, LiveTrial& trial) {
  const StageTimer timer(trial.seconds, "capture");
  return setup.cell.Capture(trial.scene, trial.bin_index, attempt);
}

// The instances that stage oracles take as visible.
std::vector<TrueInstance> VisibleInstances(const TrialSetup& setup, const InstanceMatcher& truth) {
  std::vector<TrueInstance> visible;
  for (const TrueInstance& instance : truth.instances()) {
    if (!setup.cell.IsWanted(instance.object)) continue;
    if (!setup.options.truth.sense && instance.visible_fraction < kCountedVisibility) continue;
    visible.push_back(instance);
  }
  return visible;
}

// Reports that the program of the estimator or of the planner failed: one line, then the program's
// own report.
template <typename Failure>
void Warn(const TrialSetup& setup, const Failure& failure, BinIndex bin_index, int attempt) {
  if (!setup.options.on_warning) return;
  setup.options.on_warning(fmt::format("bin {}, attempt {}: {}", bin_index, attempt, failure.text));
  for (const std::string& line : failure.traceback) setup.options.on_warning("  " + line);
}

// The result of the estimator, with ground truth in place of the stages that an oracle replaces.
EstimateResult EstimatePoses(TrialSetup& setup, const Observation& view,
                             const InstanceMatcher& truth, int attempt, LiveTrial& trial) {
  if (!setup.has_poses) return {};
  const OracleStages& oracle = setup.options.truth;
  Rng rng = Rng::Derive(setup.spec.seed, trial.bin_index, fmt::format("estimate/{}", attempt));
  EstimateResult result;
  if (setup.estimator) {
    const auto count_reachable = [&](std::span<const PoseHypothesis> poses, int wanted) {
      return CountReachable(setup, view, poses, wanted);
    };
    const bool is_first = trial.bin_index == BinIndex(0) && attempt == 0;
    result = setup.estimator->Estimate(view.frame, view.calibration, rng, nullptr, count_reachable,
                                       is_first);
    if (result.failure) Warn(setup, *result.failure, trial.bin_index, attempt);
  } else if (!oracle.AllOfPerception()) {
    result = OracleEstimate(InstancesInImage(setup.cell, trial.bin_index, truth.instances()),
                            setup.spec.estimator, rng);
  }
  for (const auto& [stage, value] : result.seconds) trial.seconds[stage] += value;
  if (!oracle.detection && !oracle.pose && !oracle.refinement) return result;
  const InstanceMatcher visible(setup.metric_models, VisibleInstances(setup, truth));
  result.hypotheses = SubstituteTruth(std::move(result.hypotheses), visible, oracle);
  if (setup.refiner) {
    setup.refiner->Refine(view.frame, view.calibration.Background(setup.cell.bin()),
                          result.hypotheses);
  }
  return result;
}

// Compares the poses with ground truth and fills record.instances and record.hypotheses.
std::vector<ScoredHypothesis> ScoreHypotheses(const TrialSetup& setup, const Observation& view,
                                              const InstanceMatcher& truth,
                                              const EstimateResult& estimate, StageSeconds& seconds,
                                              AttemptRecord& record) {
  const StageTimer timer(seconds, "score");
  AttemptScore score = ScoreAgainstTruth(truth, setup.cell.camera(), view.calibration.camera.X_WC(),
                                         estimate.hypotheses);
  const std::vector<FailureReason> missed = MissReasons(score, truth);
  for (size_t i = 0; i < missed.size(); ++i) {
    // Without a pose stage, no stage missed a visible instance.
    const bool is_missed = setup.has_poses || missed[i] == FailureReason::kNotVisible;
    const bool is_failure = estimate.failure && missed[i] == FailureReason::kNoProposal;
    if (is_missed) {
      score.instances[i].missed = is_failure ? estimate.failure->reason : missed[i];
    }
  }
  record.instances = std::move(score.instances);
  record.hypotheses = score.Records();
  return std::move(score.hypotheses);
}

// The instance of a grasp without a pose: the one that came or, without one, the instance whose
// center of mass is nearest to the grasp.
InstanceId InstanceOfGrasp(const Grasp& grasp, const GraspOutcome& outcome,
                           const LiveTrial& trial) {
  if (outcome.picked_instance >= 0) return outcome.picked_instance;
  InstanceId nearest = kNoInstance;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const PosedObject& posed : trial.scene.objects) {
    const Eigen::Vector3d center_W = posed.X_WO * trial.objects[posed.object]->mass.com_O;
    const double distance_m = (center_W - grasp.X_WG.translation()).norm();
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    nearest = posed.instance;
  }
  return nearest;
}

// Executes record.grasp and returns the scene after it.
Scene Execute(const TrialSetup& setup, LiveTrial& trial, AttemptRecord& record) {
  const StageTimer timer(trial.seconds, "execute");
  record.chosen = record.grasp->hypothesis;
  const HypothesisRecord* chosen = HypothesisOf(*record.grasp, record.hypotheses);
  if (chosen != nullptr) {
    record.matched_instance = MatchedInstance(*chosen, setup.options.match_diameters);
  }
  const MotionListener on_step =
      trial.observer != nullptr ? trial.observer->ListenToMotion() : MotionListener();
  ExecuteResult executed = TryGrasp(setup, {trial.scene, trial.objects}, *record.grasp,
                                    record.hypotheses, record.errors, on_step);
  record.outcome = executed.outcome;
  if (chosen != nullptr) {
    const EstimatedPose pose = PoseOf(*chosen);
    trial.failed.Remember(*record.grasp, &pose, record.outcome);
  } else {
    record.matched_instance = InstanceOfGrasp(*record.grasp, record.outcome, trial);
    trial.failed.Remember(*record.grasp, nullptr, record.outcome);
  }
  return std::move(executed.after);
}

// Stirs the bin with the first tool and returns the scene after it.
Scene Stir(const TrialSetup& setup, const AttemptTask& task, LiveTrial& trial,
           AttemptRecord& record) {
  const StageTimer timer(trial.seconds, "execute");
  const Gripper& tool = *setup.tools.front();
  const StirPath path = ChooseStir(setup.cell.bin(), tool, trial.image->view, task.stir);
  ExecuteResult stirred = StirBin(trial.scene, trial.objects, tool, path);
  record.outcome = stirred.outcome;
  record.failure = stirred.outcome.failure;
  trial.failed.Clear();  // the stir moved the instances
  return std::move(stirred.after);
}

uint64_t PlanSeed(const TrialSetup& setup, const LiveTrial& trial, int attempt) {
  return Rng::Derive(setup.spec.seed, trial.bin_index, fmt::format("plan/{}", attempt)).Next();
}

// Measures trial.scene, which must be from before the pick.
void MeasureFillOfAttempt(const TrialSetup& setup, LiveTrial& trial, AttemptRecord& record) {
  const StageTimer timer(trial.seconds, "score");
  const sim::FillStatistics fill = sim::MeasureFill(trial.scene, trial.objects);
  record.fill_level = fill.fill_level;
  for (size_t i = 0; i < trial.scene.objects.size(); ++i) {
    if (trial.scene.objects[i].instance != record.matched_instance) continue;
    record.layer = fill.layers[i];
    record.instances_above = fill.above[i];
    record.instances_below = fill.below[i];
  }
  const bool is_first = record.attempt == 0 && record.target < 0;
  if (!is_first) return;
  trial.layers = CountsByLayer(fill.layers);
  constexpr int kMaxTested = 20;  // all of a deep bin would take as long as several attempts
  trial.graspable =
      CountGraspable(setup, trial.scene, trial.image->view.visible_fractions, kMaxTested);
}

// Executes record.grasp or, without a grasp, the stir of the task; replaces the scene and
// attributes a failure.
void ExecuteAndAttribute(const TrialSetup& setup, const AttemptTask& task, LiveTrial& trial,
                         AttemptRecord& record) {
  CapturedImage& image = *trial.image;
  if (record.grasp && setup.has_poses) {
    image.picks.Add(*record.grasp, PoseOf(record.hypotheses[record.grasp->hypothesis]),
                    ToolNamed(setup.tools, record.grasp->tool));
  }
  Scene after = record.grasp ? Execute(setup, trial, record) : trial.scene;
  MeasureFillOfAttempt(setup, trial, record);
  record.failure =
      AttributeFailure(record, image.hypotheses, setup.options.match_diameters, image.truth);
  if (record.pose_free && record.failure == FailureReason::kNone) {
    // Without a pose, a distractor can be picked; it is not what the order asks for.
    const InstanceMatcher& truth = image.truth;
    const auto picked = std::find_if(truth.instances().begin(), truth.instances().end(),
                                     [&](const TrueInstance& instance) {
                                       return instance.instance == record.outcome.picked_instance;
                                     });
    if (picked != truth.instances().end() && !setup.cell.IsWanted(picked->object)) {
      record.failure = FailureReason::kWrongObject;
    }
  }
  if (!record.grasp && record.planner_failure) {
    Warn(setup, *record.planner_failure, trial.bin_index, record.attempt);
    record.failure = record.planner_failure->reason;
  }
  if (!record.grasp && image.estimator_failure != FailureReason::kNone) {
    record.failure = image.estimator_failure;
  }
  if (!record.grasp && !ProgramFailed(record.failure) && task.stir >= 0) {
    after = Stir(setup, task, trial, record);
  }
  trial.scene = std::move(after);
}

}  // namespace

AttemptRecord RunAttempt(TrialSetup& setup, const AttemptTask& task, LiveTrial& trial) {
  AttemptRecord record;
  record.attempt = task.attempt;
  record.pose_free = !setup.has_poses;
  record.target = task.target;
  record.band = task.band;
  record.errors = setup.cell.ErrorsOf(trial.bin_index, task.attempt);
  AttemptState state{trial.bin_index, setup.cell, setup.tools.front().get(), trial.scene, record};
  const auto reach = [&](TrialStage stage) { ReachStage(stage, state, record, trial.observer); };

  reach(TrialStage::kScene);
  Observation view = Capture(setup, task.attempt, trial);
  state.view = &view;
  reach(TrialStage::kImage);
  InstanceMatcher truth(setup.metric_models, InstancesOf(trial.scene, view.visible_fractions,
                                                         setup.cell.camera().X_CW()));
  const EstimateResult estimate = EstimatePoses(setup, view, truth, task.attempt, trial);
  std::vector<ScoredHypothesis> hypotheses =
      ScoreHypotheses(setup, view, truth, estimate, trial.seconds, record);
  const CapturedImage& image = trial.image.emplace(
      CapturedImage{std::move(view), std::move(truth), std::move(hypotheses), record.instances,
                    ImagePicks(setup.cell.objects()),
                    estimate.failure ? estimate.failure->reason : FailureReason::kNone});
  state.view = &image.view;
  state.hypotheses = &image.hypotheses;
  reach(TrialStage::kHypotheses);
  record.grasp =
      ChooseGrasp(setup, {trial.scene, trial.objects}, image.view, trial.failed, image.picks,
                  PlanSeed(setup, trial, task.attempt), record, trial.seconds);
  if (record.grasp) state.gripper = &ToolNamed(setup.tools, record.grasp->tool);
  reach(TrialStage::kGrasp);
  ExecuteAndAttribute(setup, task, trial, record);
  reach(TrialStage::kOutcome);
  return record;
}

std::optional<AttemptRecord> RunFurtherPick(TrialSetup& setup, int attempt, LiveTrial& trial) {
  const CapturedImage& image = trial.image.value();
  AttemptRecord record;
  record.attempt = attempt;
  record.pick_of_image = static_cast<int>(image.picks.size());
  record.errors = setup.cell.ErrorsOf(trial.bin_index, attempt);
  for (const InstanceRecord& instance : image.instances) {
    const bool is_left =
        std::any_of(trial.scene.objects.begin(), trial.scene.objects.end(),
                    [&](const PosedObject& posed) { return posed.instance == instance.instance; });
    if (is_left) record.instances.push_back(instance);
  }
  for (const ScoredHypothesis& hypothesis : image.hypotheses) {
    record.hypotheses.push_back(hypothesis.record);
  }
  record.grasp = ChooseGrasp(setup, {trial.scene, trial.objects}, image.view, trial.failed,
                             image.picks, PlanSeed(setup, trial, attempt), record, trial.seconds);
  if (!record.grasp) return std::nullopt;
  AttemptState state{trial.bin_index, setup.cell, &ToolNamed(setup.tools, record.grasp->tool),
                     trial.scene, record};
  const auto reach = [&](TrialStage stage) { ReachStage(stage, state, record, trial.observer); };
  reach(TrialStage::kScene);
  state.view = &image.view;
  reach(TrialStage::kImage);
  state.hypotheses = &image.hypotheses;
  reach(TrialStage::kHypotheses);
  reach(TrialStage::kGrasp);
  ExecuteAndAttribute(setup, {attempt}, trial, record);
  reach(TrialStage::kOutcome);
  return record;
}

}  // namespace pickbed::eval
