#pragma once

// What one reads off a run. Made from stored trials alone, so that it is the same for any number of
// workers.

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/cycle.h"
#include "eval/occlusion_curve.h"
#include "eval/outcome_table.h"
#include "eval/pick_forecast.h"
#include "eval/results_store.h"
#include "eval/statistics.h"
#include "eval/sweep_stop.h"
#include "eval/trial.h"

namespace pickbed {

struct RecallBand {
  double visible_min = 0, visible_max = 1;
  int instances = 0, recalled = 0;
};

// By what visible fractions a run is told: its own bands where it is on occlusion, else 10-30,
// 30-50, 50-70, 70-90, 90-100 %.
std::vector<VisibleBand> ReportedBands(const OcclusionSpec& spec = {});

// With nothing counted yet.
std::vector<RecallBand> EmptyRecallBands(const std::vector<VisibleBand>& bands = ReportedBands());
// Counts an instance in its band; one that is less visible than all of them in none.
void CountRecall(const InstanceRecord& instance, std::vector<RecallBand>& bands);

struct TrialRefusal {
  int trial = 0;
  RefusedScene scene;
};

// Intervals are over scenes, see ClusterInterval: picks of one bin are not independent.
struct RunSummary {
  int trials = 0, attempts = 0, successes = 0;
  double success_rate = 0;
  Interval success_ci95;
  std::array<RuleRate, kSuccessRules> by_rule;  // of the same attempts
  int parts_dropped = 0, parts_cleared = 0;
  double cleared_rate = 0;
  Interval cleared_ci95;
  int frames = 0, top1_correct = 0;
  double top1_precision = 0;
  Interval top1_ci95;
  std::vector<RecallBand> recall_by_visibility;
  std::vector<Interval> recall_ci95;    // of each band
  std::vector<TrialRefusal> refused;    // scenes that failed their certificate
  std::vector<CrashedTrial> crashed;    // counted nowhere else
  std::optional<StopState> stop;        // where it may end early
  std::vector<BandFigures> bands;       // of occlusion trials, else none
  std::map<std::string, int> losses;    // reason -> attempts or ends charged to it
  std::vector<PickForecast> forecasts;  // by tolerance maps, where there are some
  CycleTime cycle;
  StageSeconds seconds;  // stage -> mean a trial
};

RunSummary Summarize(const std::vector<TrialResult>& trials, const CycleSpec& cycle = {},
                     const std::vector<VisibleBand>& bands = ReportedBands());

// summary.json, without times. Picks per hour are null where they rest on a measured time, or
// nothing was picked.
std::string SummaryJson(const RunSummary& summary);
std::string SummaryTable(const RunSummary& summary);  // for people
// A line a trial; those that crashed have empty cells.
std::string TrialsCsv(const std::vector<TrialResult>& trials,
                      const std::vector<CrashedTrial>& crashed = {});
// A line a pick; p_pick is the chance of the executed pose, p_grasp that of the executed grasp of
// it, where its part has a tolerance map. `parts` are the names of the kinds that were dropped.
std::string PicksCsv(const std::vector<TrialResult>& trials, const std::vector<std::string>& parts,
                     const ToleranceMaps& maps = {});
// A line a part.
std::string PartsCsv(const std::vector<TrialResult>& trials, const std::vector<std::string>& parts);
// The last lines, of trial "all", are the cycle's seconds a picked part.
std::string TimingsCsv(const std::vector<TrialResult>& trials, const CycleTime& cycle = {});

}  // namespace pickbed
