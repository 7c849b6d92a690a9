#pragma once

// The trials of a run once more, with truth in place of one stage at a time (eval/truth_feed.h),
// and what that gains.
//
//   RUN/budget/ROW/   results folder of a rerun (eval/run.h); trials that are finished there stay

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "eval/pick_forecast.h"
#include "eval/run.h"
#include "eval/statistics.h"
#include "eval/tolerance_maps.h"
#include "eval/truth_feed.h"

namespace pickbed {

struct BudgetJob {
  std::filesystem::path run;  // results folder of `pickbed run`
  ScenarioSpec spec;          // of its scenario.yaml
  ObjectSet objects;
  std::vector<OracleRow> rows;  // what is to be fed, a rerun each
  ToleranceMaps tolerance;      // to judge the run's picks by
  int jobs = 1;
};

struct FedRun {
  OracleRow row;
  std::vector<TrialResult> trials;
};

struct BudgetRuns {
  std::vector<TrialResult> as_run;      // by trial
  std::vector<FedRun> fed;              // the same trials each
  std::vector<PickForecast> forecasts;  // of the picks as run
  bool interrupted = false;             // then `fed` is not complete
};

struct BudgetListener {
  std::function<void(const OracleRow& row, const RunState& state)> on_trial;
  std::function<void(const OracleRow& row, const std::string& line)> on_message;
  std::function<bool()> stop;
};

// The finished trials of the run. Throws InputError when the folder holds none, or when a mesh, the
// model, the gripper or the sensor is not what the run was made with.
std::vector<TrialResult> TrialsOfRun(const BudgetJob& job);

// Forks, see eval/workers.h. Same bytes for any number of jobs. Throws InputError as TrialsOfRun
// and RunScenario do, std::runtime_error when trials were lost, and std::logic_error when a stage
// lost picks although it was fed with truth (see RequireGraspLossesOnly).
BudgetRuns RerunWithTruth(const BudgetJob& job, const BudgetListener& listener);

// By how much a rate rises. 95 % interval over trials, which are paired.
struct Gain {
  double before = 0, after = 0;
  Interval rise{-1, 1};
  double points() const { return 100 * (after - before); }
};
struct StageGain {
  Gain attempts;   // picked of all attempts
  Gain instances;  // picked of the instances asked for
};
// The same trials in the same order; throws std::logic_error otherwise.
StageGain GainOf(std::span<const TrialResult> as_run, std::span<const TrialResult> fed);

}  // namespace pickbed
