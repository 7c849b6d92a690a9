#include "eval/trial/trial.h"

#include <fmt/format.h>

#include <stdexcept>

#include "eval/trial/attempt.h"

namespace pickbed::eval {
namespace {

TrialResult DropBin(const TrialSetup& setup, LiveTrial& trial) {
  const StageTimer timer(trial.seconds, "drop");
  TrialResult result;
  result.trial = result.bin_index = trial.bin_index;
  result.errors = setup.cell.ErrorsOf(trial.bin_index);
  trial.objects = setup.cell.TrueObjects(trial.bin_index);
  const std::vector<double> sizes = setup.cell.SizesOf(trial.bin_index);
  CertifiedScene made = setup.cell.MakeScene(trial.bin_index);
  result.certificate = std::move(made.certificate);
  result.refused = std::move(made.refused);
  result.instances_dropped = setup.cell.WantedIn(made.scene);
  for (const PosedObject& posed : made.scene.objects) {
    if (!setup.cell.IsWanted(posed.object)) continue;
    InstanceOutcome& outcome = result.outcomes.emplace_back();
    outcome.instance = posed.instance;
    outcome.object = posed.object;
    outcome.deviation = posed.deviation;
    outcome.size_deviation = sizes[posed.object];
  }
  trial.scene = std::move(made.scene);
  return result;
}

void ReportProgress(const TrialSetup& setup, const TrialResult& result) {
  if (!setup.on_progress) return;
  setup.on_progress(fmt::format("trial {}", result.trial),
                    static_cast<double>(result.instances_cleared) / result.instances_dropped);
}

int MaxAttempts(const PolicySpec& policy, const PolicyRow& row) {
  return row.max_attempts > 0 ? row.max_attempts : policy.max_attempts;
}

bool MayUseLastImage(const TrialSetup& setup, const std::vector<AttemptRecord>& before) {
  return !before.empty() && before.back().failure == FailureReason::kNone &&
         !before.back().pose_free &&
         before.back().pick_of_image + 1 < setup.spec.policy.picks_per_image;
}

}  // namespace

PickingTrial::PickingTrial(TrialSetup& setup, BinIndex bin_index, TrialObserver* observer)
    : setup_(setup),
      policy_(PolicyNamed(setup.spec.policy.stop)),
      max_attempts_(MaxAttempts(setup.spec.policy, policy_)),
      trial_(std::make_unique<LiveTrial>()) {
  trial_->bin_index = bin_index;
  trial_->observer = observer;
  result_ = DropBin(setup, *trial_);
}

PickingTrial::~PickingTrial() = default;

bool PickingTrial::HasReachedLimit() const {
  return max_attempts_ > 0 && state_.attempts >= max_attempts_ &&
         result_.ended_by == FailureReason::kNone && setup_.cell.WantedIn(trial_->scene) > 0;
}

bool PickingTrial::HasEnded() const {
  return result_.ended_by != FailureReason::kNone || setup_.cell.WantedIn(trial_->scene) == 0 ||
         HasReachedLimit();
}

const Scene& PickingTrial::scene() const { return trial_->scene; }

BinIndex PickingTrial::bin_index() const { return trial_->bin_index; }

LiveAttempt& PickingTrial::Attempt() {
  if (attempt_) return *attempt_;
  if (HasEnded()) throw std::logic_error("the trial has ended");
  const PolicySpec& policy = setup_.spec.policy;
  AttemptTask task{state_.attempts};
  // No stir is wasted on a trial that ends with it.
  const bool is_last = state_.failures_in_row + 1 >= policy.max_failures_in_row ||
                       state_.attempts + 1 == max_attempts_;
  may_stir_ = stirs_ < policy.stir.max && !is_last;
  task.is_stir =
      may_stir_ && policy.stir.after_failures > 0 && failed_ >= policy.stir.after_failures;
  if (task.is_stir || (may_stir_ && without_grasp_ + 1 >= policy.stir.after)) task.stir = stirs_;
  if (MayUseLastImage(setup_, result_.attempts)) {
    attempt_ = LiveAttempt::WithLastImage(setup_, task.attempt, *trial_);
  }
  if (!attempt_) attempt_ = std::make_unique<LiveAttempt>(setup_, task, *trial_);
  return *attempt_;
}

const AttemptRecord& PickingTrial::Execute(const std::optional<Grasp>& grasp) {
  result_.attempts.push_back(Attempt().Execute(grasp));
  attempt_ = nullptr;
  const AttemptRecord& attempt = result_.attempts.back();
  const bool picked = attempt.failure == FailureReason::kNone;
  result_.instances_cleared += picked;
  ReportProgress(setup_, result_);
  ++state_.attempts;
  const bool stirred = Stirred(attempt);
  stirs_ += stirred;
  // A program that failed says nothing about the bin.
  const bool program_failed = ProgramFailed(attempt.failure);
  if (!program_failed) without_grasp_ = attempt.grasp || stirred ? 0 : without_grasp_ + 1;
  state_.grasp_found = UsedHand(attempt) || may_stir_ || program_failed;
  if (!program_failed) failed_ = picked || stirred ? 0 : failed_ + 1;
  state_.failures_in_row = picked ? 0 : state_.failures_in_row + 1;
  if (policy_.gives_up(state_, setup_.spec.policy)) result_.ended_by = attempt.failure;
  return attempt;
}

TrialResult PickingTrial::TakeResult() {
  TrialEnd end;
  end.gave_up = result_.ended_by != FailureReason::kNone;
  for (const PosedObject& posed : trial_->scene.objects) end.remaining.push_back(posed.instance);
  result_.outcomes = DecideOutcomes(std::move(result_.outcomes), result_.attempts, end);
  result_.layers = std::move(trial_->layers);
  result_.instances_tested = trial_->graspable.tested;
  result_.instances_graspable = trial_->graspable.graspable;
  result_.seconds = std::move(trial_->seconds);
  return std::move(result_);
}

TrialResult RunTrial(TrialSetup& setup, BinIndex bin_index, TrialObserver* observer) {
  PickingTrial trial(setup, bin_index, observer);
  while (!trial.HasEnded()) trial.Execute(trial.Attempt().ChooseGrasp());
  return trial.TakeResult();
}

}  // namespace pickbed::eval
