#include "eval/trial/trial.h"

#include <fmt/format.h>

#include "eval/trial/attempt.h"
#include "scenes/scenario/policy.h"

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

// Continues with the last image after a successful pick, while a further pick cannot be disturbed
// by the earlier ones. Else a new image is captured.
AttemptRecord RunNextAttempt(TrialSetup& setup, const AttemptTask& task,
                             const std::vector<AttemptRecord>& before, LiveTrial& trial) {
  if (!before.empty() && before.back().failure == FailureReason::kNone &&
      before.back().pick_of_image + 1 < setup.spec.policy.picks_per_image) {
    if (auto further = RunFurtherPick(setup, task.attempt, trial)) return std::move(*further);
  }
  return RunAttempt(setup, task, trial);
}

}  // namespace

TrialResult RunTrial(TrialSetup& setup, BinIndex bin_index, TrialObserver* observer) {
  LiveTrial trial;
  trial.bin_index = bin_index;
  trial.observer = observer;
  TrialResult result = DropBin(setup, trial);
  const PolicySpec& policy = setup.spec.policy;
  const PolicyRow& row = PolicyNamed(policy.stop);
  const int max_attempts = row.max_attempts > 0 ? row.max_attempts : policy.max_attempts;
  PolicyState state;
  int stirs = 0, without_grasp = 0;  // attempts in a row
  while (result.ended_by == FailureReason::kNone && setup.cell.WantedIn(trial.scene) > 0 &&
         (max_attempts == 0 || state.attempts < max_attempts)) {
    AttemptTask task{state.attempts};
    // No stir is wasted on a trial that ends with it.
    const bool is_last = state.failures_in_row + 1 >= policy.max_failures_in_row ||
                         state.attempts + 1 == max_attempts;
    const bool may_stir = stirs < policy.stir.max && !is_last;
    if (may_stir && without_grasp + 1 >= policy.stir.after) task.stir = stirs;
    result.attempts.push_back(RunNextAttempt(setup, task, result.attempts, trial));
    const AttemptRecord& attempt = result.attempts.back();
    const bool picked = attempt.failure == FailureReason::kNone;
    result.instances_cleared += picked;
    ReportProgress(setup, result);
    ++state.attempts;
    const bool stirred = Stirred(attempt);
    stirs += stirred;
    // A program that failed says nothing about the bin.
    const bool program_failed = ProgramFailed(attempt.failure);
    if (!program_failed) without_grasp = attempt.grasp || stirred ? 0 : without_grasp + 1;
    state.grasp_found = UsedHand(attempt) || may_stir || program_failed;
    state.failures_in_row = picked ? 0 : state.failures_in_row + 1;
    if (row.gives_up(state, policy)) result.ended_by = attempt.failure;
  }
  TrialEnd end;
  end.gave_up = result.ended_by != FailureReason::kNone;
  for (const PosedObject& posed : trial.scene.objects) end.remaining.push_back(posed.instance);
  result.outcomes = DecideOutcomes(std::move(result.outcomes), result.attempts, end);
  result.layers = std::move(trial.layers);
  result.instances_tested = trial.graspable.tested;
  result.instances_graspable = trial.graspable.graspable;
  result.seconds = std::move(trial.seconds);
  return result;
}

}  // namespace pickbed::eval
