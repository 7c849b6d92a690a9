#include "eval/trial/attempt.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "eval/trial/failure_attribution.h"
#include "eval/trial/oracle_estimator.h"
#include "eval/trial/pose_matching.h"
#include "grasp/execute/stir.h"
#include "grasp/grippers/requirements.h"
#include "scenes/base/error.h"
#include "scenes/base/finite_counts.h"
#include "scenes/base/ids_format.h"
#include "scenes/base/random.h"
#include "sim/drop/fill_level.h"

namespace pickbed::eval {
namespace {

Observation Capture(TrialSetup& setup, int attempt, LiveTrial& trial) {
  const StageTimer timer(trial.seconds, "capture");
  return setup.cell.Capture(trial.scene, trial.bin_index, attempt);
}

// Whether an attempt has the first image of a run. A wrong answer of a program, or a region of
// interest without readings, then ends the run.
bool IsFirstImage(BinIndex bin_index, int attempt) {
  return bin_index == BinIndex(0) && attempt == 0;
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
    const bool is_missed = !record.pose_free || missed[i] == FailureReason::kNotVisible;
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
  const MotionListener on_step =
      trial.observer != nullptr ? trial.observer->ListenToMotion() : MotionListener();
  ExecuteResult stirred = StirBin(trial.scene, trial.objects, tool, path, StirOptions(),
                                  ExecuteOptions().physics, on_step);
  record.outcome = stirred.outcome;
  record.failure = stirred.outcome.failure;
  trial.failed.Clear();  // the stir moved the instances
  return std::move(stirred.after);
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
  if (record.grasp && !record.pose_free) {
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

EstimateResult EstimateInImage(TrialSetup& setup, const Observation& view,
                               const InstanceMatcher& truth, BinIndex bin_index, int attempt) {
  if (!setup.has_poses) return {};
  setup.MakeEstimator();
  const OracleStages& oracle = setup.options.truth;
  Rng rng = Rng::Derive(setup.spec.seed, bin_index, fmt::format("estimate/{}", attempt));
  EstimateResult result;
  if (setup.estimator) {
    const auto count_reachable = [&](std::span<const PoseHypothesis> poses, int wanted) {
      return CountReachable(setup, view, poses, wanted);
    };
    result = setup.estimator->Estimate(view.frame, view.calibration, rng, nullptr, count_reachable,
                                       IsFirstImage(bin_index, attempt));
    if (result.failure) Warn(setup, *result.failure, bin_index, attempt);
  } else if (!oracle.AllOfPerception()) {
    result = OracleEstimate(InstancesInImage(setup.cell, bin_index, truth.instances()),
                            setup.spec.estimator, rng);
  }
  if (!oracle.detection && !oracle.pose && !oracle.refinement) return result;
  const InstanceMatcher visible(
      setup.metric_models, InstancesInImage(setup.cell, bin_index, VisibleInstances(setup, truth)));
  result.hypotheses = SubstituteTruth(std::move(result.hypotheses), visible, oracle);
  if (setup.refiner) {
    setup.refiner->Refine(view.frame, view.calibration.Background(setup.cell.bin()),
                          result.hypotheses);
  }
  return result;
}

uint64_t PlanSeed(const TrialSetup& setup, BinIndex bin_index, int attempt) {
  return Rng::Derive(setup.spec.seed, bin_index, fmt::format("plan/{}", attempt)).Next();
}

LiveAttempt::LiveAttempt(TrialSetup& setup, const AttemptTask& task, LiveTrial& trial, LastImage)
    : setup_(setup),
      task_(task),
      trial_(trial),
      state_{trial.bin_index, setup.cell, setup.tools.front().get(), trial.scene, record_} {
  record_.attempt = task.attempt;
  record_.pose_free = !setup.has_poses;
  record_.target = task.target;
  record_.band = task.band;
  record_.errors = setup.cell.ErrorsOf(trial.bin_index, task.attempt);
}

LiveAttempt::LiveAttempt(TrialSetup& setup, const AttemptTask& task, LiveTrial& trial)
    : LiveAttempt(setup, task, trial, LastImage()) {
  Reach(TrialStage::kScene);
  Observation view = Capture(setup, task.attempt, trial);
  state_.view = &view;
  Reach(TrialStage::kImage);
  InstanceMatcher truth(setup.metric_models, InstancesOf(trial.scene, view.visible_fractions,
                                                         setup.cell.camera().X_CW()));
  trial.image = std::make_shared<CapturedImage>(
      CapturedImage{std::move(view), std::move(truth), {}, {}, ImagePicks(setup.cell.objects())});
  state_.view = &trial.image->view;
}

std::unique_ptr<LiveAttempt> LiveAttempt::WithLastImage(TrialSetup& setup, int attempt,
                                                        LiveTrial& trial) {
  std::unique_ptr<LiveAttempt> further(new LiveAttempt(setup, {attempt}, trial, LastImage()));
  const CapturedImage& image = *trial.image;
  AttemptRecord& record = further->record_;
  record.pick_of_image = static_cast<int>(image.picks.size());
  for (const InstanceRecord& instance : image.instances) {
    const bool is_left =
        std::any_of(trial.scene.objects.begin(), trial.scene.objects.end(),
                    [&](const PosedObject& posed) { return posed.instance == instance.instance; });
    if (is_left) record.instances.push_back(instance);
  }
  for (const ScoredHypothesis& hypothesis : image.hypotheses) {
    record.hypotheses.push_back(hypothesis.record);
  }
  further->estimated_ = true;
  further->Plan();
  if (!further->chosen_) return nullptr;
  further->Reach(TrialStage::kScene);
  further->state_.view = &image.view;
  further->Reach(TrialStage::kImage);
  further->state_.hypotheses = &image.hypotheses;
  further->Reach(TrialStage::kHypotheses);
  return further;
}

void LiveAttempt::Reach(TrialStage stage) { ReachStage(stage, state_, record_, trial_.observer); }

const std::vector<ScoredHypothesis>& LiveAttempt::Estimate() {
  CapturedImage& image = *trial_.image;
  if (estimated_) return image.hypotheses;
  const EstimateResult estimate =
      EstimateInImage(setup_, image.view, image.truth, trial_.bin_index, task_.attempt);
  for (const auto& [stage, value] : estimate.seconds) trial_.seconds[stage] += value;
  image.hypotheses =
      ScoreHypotheses(setup_, image.view, image.truth, estimate, trial_.seconds, record_);
  image.instances = record_.instances;
  if (estimate.failure) image.estimator_failure = estimate.failure->reason;
  estimated_ = true;
  state_.hypotheses = &image.hypotheses;
  Reach(TrialStage::kHypotheses);
  return image.hypotheses;
}

void LiveAttempt::Plan() {
  planned_ = true;
  if (task_.is_stir) return;
  const CapturedImage& image = *trial_.image;
  chosen_ = eval::ChooseGrasp(setup_, {trial_.scene, trial_.objects}, image.view, trial_.failed,
                              image.picks, PlanSeed(setup_, trial_.bin_index, task_.attempt),
                              record_, trial_.seconds);
  for (const auto& [stage, count] : TakeNotFiniteCounts()) trial_.seconds[stage] += count;
  const std::optional<PlannerFailure>& failure = record_.planner_failure;
  if (IsFirstImage(trial_.bin_index, task_.attempt) && failure && failure->is_malformed) {
    throw InputError(failure->text);  // most probably a mistake that all answers have
  }
}

const std::optional<Grasp>& LiveAttempt::ChooseGrasp() {
  Estimate();
  if (!planned_) Plan();
  return chosen_;
}

void LiveAttempt::LeaveOutPoses() {
  if (!estimated_) {
    CapturedImage& image = *trial_.image;
    ScoreHypotheses(setup_, image.view, image.truth, {}, trial_.seconds, record_);
    image.instances = record_.instances;
  } else if (record_.pose_free) {
    return;
  }
  record_.pose_free = true;
  record_.hypotheses.clear();
  for (InstanceRecord& instance : record_.instances) {
    instance.recalled = false;
    const bool counts = instance.visible_fraction >= kCountedVisibility;
    instance.missed = counts ? FailureReason::kNone : FailureReason::kNotVisible;
  }
  state_.hypotheses = &trial_.image->hypotheses;
  Reach(TrialStage::kHypotheses);
}

bool LiveAttempt::IsChosen(const std::optional<Grasp>& grasp) const {
  if (!planned_ || grasp.has_value() != chosen_.has_value()) return false;
  if (!grasp) return true;
  return grasp->X_WG.matrix() == chosen_->X_WG.matrix() && grasp->width_m == chosen_->width_m &&
         grasp->score == chosen_->score && grasp->hypothesis == chosen_->hypothesis &&
         grasp->tool == chosen_->tool && grasp->lift_aside_m == chosen_->lift_aside_m;
}

void LiveAttempt::RequireValid(const std::optional<Grasp>& grasp) const {
  if (!grasp) return;
  RequireOpensFor(ToolNamed(setup_.tools, grasp->tool), grasp->width_m);
  const int poses = estimated_ ? static_cast<int>(record_.hypotheses.size()) : 0;
  CheckInput(grasp->hypothesis >= kNoHypothesis && grasp->hypothesis < poses,
             fmt::format("the grasp is for hypothesis {}, but the attempt has {} hypotheses; use "
                         "{} for a grasp without a pose",
                         grasp->hypothesis, poses, kNoHypothesis));
}

AttemptRecord LiveAttempt::Execute(const std::optional<Grasp>& grasp) {
  RequireValid(grasp);
  if (grasp) state_.gripper = &ToolNamed(setup_.tools, grasp->tool);
  const bool is_pose_free = grasp && grasp->hypothesis == kNoHypothesis;
  if (!estimated_ || is_pose_free) LeaveOutPoses();
  record_.grasp = grasp;
  Reach(TrialStage::kGrasp);
  ExecuteAndAttribute(setup_, task_, trial_, record_);
  Reach(TrialStage::kOutcome);
  return std::move(record_);
}

AttemptRecord RunAttempt(TrialSetup& setup, const AttemptTask& task, LiveTrial& trial) {
  LiveAttempt attempt(setup, task, trial);
  return attempt.Execute(attempt.ChooseGrasp());
}

}  // namespace pickbed::eval
