#pragma once

// Repeats the trials of a run with ground truth in place of one stage at a time
// (eval/trial/stage_oracle.h), and measures the gain.
//
//   RUN/budget/ROW/   results folder of a rerun (eval/sweep/run.h); finished trials are kept

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "eval/stats/statistics.h"
#include "eval/sweep/run.h"
#include "eval/tolerance/maps.h"
#include "eval/tolerance/pick_forecast.h"
#include "eval/trial/stage_oracle.h"

namespace pickbed::eval {

struct BudgetJob {
  std::filesystem::path run;  // results folder of `pickbed run`
  ScenarioSpec spec;          // from its scenario.yaml
  ObjectSet objects;
  std::vector<OracleRow> rows;  // one rerun per row, which names the stage to replace
  ToleranceMaps tolerance;      // for the forecasts of the run's picks
  int jobs = 1;
};

// Rerun with ground truth substituted for a stage.
struct OracleRerun {
  OracleRow row;
  std::vector<TrialResult> trials;
};

struct BudgetRuns {
  std::vector<TrialResult> as_run;      // by trial
  std::vector<OracleRerun> reruns;      // each with the same trials as `as_run`
  std::vector<PickForecast> forecasts;  // for the picks of `as_run`
  bool interrupted = false;             // if true, `reruns` is not complete
};

// Callbacks of a rerun. `stop` returns true to end it.
struct BudgetListener {
  std::function<void(const OracleRow& row, const RunState& state)> on_trial;
  std::function<void(const OracleRow& row, const std::string& line)> on_message;
  std::function<bool()> stop;
};

// Reads the finished trials of the run. Throws InputError if the folder holds none, or if a mesh,
// the model, the gripper, the sensor or the scenario differs from the run.
std::vector<TrialResult> TrialsOfRun(const BudgetJob& job);

// Repeats the trials once per row of the job. Forks, see eval/runtime/process_pool.h. The results
// do not depend on the number of jobs. Throws InputError as TrialsOfRun and RunScenario do, and
// std::runtime_error if trials crashed twice. Throws std::logic_error if perception caused failures
// although ground truth replaced it (see RequireGraspFailuresOnly).
BudgetRuns RerunWithTruth(const BudgetJob& job, const BudgetListener& listener);

// Increase of a rate, with its 95 % interval over paired trials.
struct Gain {
  double before = 0, after = 0;
  Interval rise{-1, 1};
  double points() const { return 100 * (after - before); }
};
struct StageGain {
  Gain attempts;   // successful attempts / all attempts
  Gain instances;  // picked instances / instances that the policy asked for
};
// Computes the gain of `rerun` over `as_run`. Throws std::logic_error unless both have the same
// trials in the same order.
StageGain GainOf(std::span<const TrialResult> as_run, std::span<const TrialResult> rerun);

}  // namespace pickbed::eval
