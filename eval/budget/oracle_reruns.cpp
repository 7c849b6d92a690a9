#include "eval/budget/oracle_reruns.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "eval/store/results_store.h"
#include "eval/store/store_check.h"
#include "eval/summary/failure_budget.h"
#include "eval/summary/result_files.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

Gain GainBetween(const std::vector<Cluster>& before, const std::vector<Cluster>& after) {
  return {RateOf(before), RateOf(after), PairedInterval(before, after)};
}

// Keeps the trials whose number is in `wanted`, which is sorted.
std::vector<TrialResult> Only(std::vector<TrialResult> all, const std::vector<int>& wanted) {
  std::erase_if(all, [&](const TrialResult& trial) {
    return !std::binary_search(wanted.begin(), wanted.end(), trial.trial);
  });
  return all;
}

void RequireSums(const OracleRerun& rerun) {
  const FailureBudget attempts = BudgetOfAttempts(rerun.trials);
  const FailureBudget instances = BudgetOfInstances(rerun.trials);
  if (!rerun.row.truth.AllOfPerception()) return;
  RequireGraspFailuresOnly(attempts);
  RequireGraspFailuresOnly(instances);
}

}  // namespace

std::vector<TrialResult> TrialsOfRun(const BudgetJob& job) {
  const std::string where = job.run.string();
  const std::optional<std::string> stored = StoredSettings(job.run);
  CheckInput(
      stored.has_value(),
      fmt::format("{} has no {}; name the results folder of a `pickbed run`", where, kStoreFile));
  const std::string identity = RunIdentity(job.spec, job.objects);
  CheckInput(*stored == identity,
             fmt::format("{} was made with another model, gripper, sensor, object or scenario than "
                         "there is now; repeat the run",
                         where));
  std::vector<TrialResult> trials = ResultsStore::OpenToRead(job.run).ReadAll();
  CheckInput(!trials.empty(),
             fmt::format("{} has no finished trial; resume the run to finish it", where));
  const std::string file = (job.run / kStoreFile).string();
  for (const TrialResult& trial : trials) {
    CheckTrial(trial, {job.spec.objects.size(), job.spec.occlusion.bands.size()}, file);
    CheckInput(OutcomesAddUp(trial),
               fmt::format("{}: table 'instance_outcomes', trial {}: the outcomes do not add up to "
                           "its {} instances, of which {} were cleared; {}",
                           file, trial.trial, trial.instances_dropped, trial.instances_cleared,
                           kRestoreAdvice));
  }
  return trials;
}

BudgetRuns RerunWithTruth(const BudgetJob& job, const BudgetListener& listener) {
  BudgetRuns runs;
  runs.as_run = TrialsOfRun(job);
  runs.forecasts = ForecastsOf(runs.as_run, job.objects, job.tolerance);
  RunOptions options;
  options.jobs = job.jobs;
  options.resume = true;
  options.retry_crashed = true;
  options.picture_trials = options.failure_picture_trials = 0;
  for (const TrialResult& trial : runs.as_run) options.only_trials.push_back(trial.trial);
  for (const OracleRow& row : job.rows) {
    options.out = job.run / kBudgetFolder / row.name;
    options.truth = row.truth;
    RunListener of_row;
    of_row.on_trial = [&](const RunState& state) {
      if (listener.on_trial) listener.on_trial(row, state);
    };
    of_row.on_message = [&](const std::string& line) {
      if (listener.on_message) listener.on_message(row, line);
    };
    of_row.stop = listener.stop;
    RunReport report = RunScenario(job.spec, job.objects, options, of_row);
    runs.interrupted = report.interrupted;
    if (runs.interrupted) return runs;
    if (!report.crashed.empty()) {
      const CrashedTrial& first = report.crashed.front();
      throw std::runtime_error(fmt::format(
          "{}: {} trials crashed twice, the first is trial {}: {}; the same command repeats them",
          row.name, report.crashed.size(), first.trial, first.why));
    }
    runs.reruns.push_back({row, Only(std::move(report.trials), options.only_trials)});
    RequireSums(runs.reruns.back());
  }
  return runs;
}

StageGain GainOf(std::span<const TrialResult> as_run, std::span<const TrialResult> rerun) {
  const bool same = std::ranges::equal(as_run, rerun, {}, &TrialResult::trial, &TrialResult::trial);
  if (!same) throw std::logic_error("only equal trials can be compared");
  return {GainBetween(AttemptsByTrial(as_run), AttemptsByTrial(rerun)),
          GainBetween(InstancesByTrial(as_run), InstancesByTrial(rerun))};
}

}  // namespace pickbed::eval
