#pragma once

// Aggregate statistics of a run, computed only from its stored trials. So they do not depend on the
// number of workers.

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/stats/statistics.h"
#include "eval/store/results_store.h"
#include "eval/summary/clutter_json.h"
#include "eval/summary/cycle.h"
#include "eval/summary/early_stop.h"
#include "eval/summary/held_instances.h"
#include "eval/summary/hidden_share.h"
#include "eval/summary/occlusion_curve.h"
#include "eval/summary/pile_rates.h"
#include "eval/summary/success_rates.h"
#include "eval/tolerance/pick_forecast.h"
#include "eval/trial/trial.h"

namespace pickbed::eval {

// Recall of the instances of one band of visible fractions.
struct RecallBand {
  double visible_min = 0, visible_max = 1;
  int instances = 0, recalled = 0;
};

// Returns the bands of visible fractions for the report of a run: the bands of `spec` if it is
// enabled, else 10-30, 30-50, 50-70, 70-90 and 90-100 %.
std::vector<VisibleBand> ReportedBands(const OcclusionSpec& spec = {});

// Returns the bands with zero counts.
std::vector<RecallBand> EmptyRecallBands(const std::vector<VisibleBand>& bands = ReportedBands());
// Counts an instance in its band. An instance that is in no band is ignored.
void CountRecall(const InstanceRecord& instance, std::vector<RecallBand>& bands);

// A scene that failed its certificate, with its trial.
struct TrialRefusal {
  int trial = 0;
  RefusedScene scene;
};

// Name of each element of RunSummary::in_view: "0-10", "10-30", ..., "90-100".
std::vector<std::string> InViewNames();
// Returns the element of RunSummary::in_view that counts an instance.
size_t InViewIndex(double visible_fraction);

// Executed grasps with one gripper.
struct ToolCount {
  int executed_grasps = 0, successes = 0;
};

// Statistics of a run. Scenes are the units of the intervals (see ClusterInterval), because picks
// of one bin are not independent.
struct RunSummary {
  int trials = 0;
  int executed_grasps = 0, successes = 0;  // a stir of the bin counts as a failed grasp
  double success_rate = 0;
  Interval success_ci95;
  std::array<RuleRate, kSuccessRules> by_rule;  // the same executed grasps, judged by each rule
  int instances_dropped = 0, instances_cleared = 0;
  double cleared_rate = 0;
  Interval cleared_ci95;
  ReportRate attempts_picked;   // attempts that picked, of all attempts
  ReportRate requested_picked;  // cleared instances, of the requested ones
  ReportRate recall;            // instances with a correct pose, of all in view that count
  ReportRate precision;         // right poses, of all reported ones
  ReportRate target_recall;     // the same as recall for targets; only of occlusion trials
  // Number of instances in view by visible fraction: under 10 %, then the default bands. An
  // instance counts once per image.
  std::vector<int> in_view;
  int images = 0;  // captured images; several attempts can share one
  int frames = 0, top1_correct = 0;
  double top1_precision = 0;
  Interval top1_ci95;
  std::vector<RecallBand> recall_by_visibility;
  std::vector<Interval> recall_ci95;  // one per band
  std::vector<FillBand> by_fill;      // without bands that no grasp is in
  std::vector<LayerRate> by_layer;    // the same
  std::vector<TrialRefusal> refused;
  std::vector<CrashedTrial> crashed;       // not part of any other count
  std::optional<StopState> stop;           // set if the run may stop early
  std::vector<BandStatistics> bands;       // only for occlusion trials, else empty
  std::vector<HiddenBand> hidden;          // the same
  std::map<std::string, ToolCount> tools;  // by gripper; stirs are not included
  std::map<std::string, int> failures;     // failure reason -> number of attempts
  std::vector<PickForecast> forecasts;     // empty without tolerance models
  CycleTime cycle;
  RetentionStatistics retention;
  DropTimes drop_times;
  ClutterSummary clutter;  // before the first pick; without occlusion trials
  StageSeconds seconds;    // mean per trial, by stage

  // Returns whether there was a pose stage: recall and precision have samples.
  bool has_poses() const { return recall.samples > 0 || frames > 0; }
};

// Trials of one configuration.
struct ConfigurationTrials {
  std::string name;
  std::vector<std::string> objects;  // object names
  std::vector<TrialResult> trials;   // ordered by trial number
  CycleSpec cycle;
  std::vector<VisibleBand> bands = ReportedBands();  // bands of the reported rates
};

// Computes the statistics of a run. The members crashed, stop, bands and forecasts are left empty.
RunSummary Summarize(const std::vector<TrialResult>& trials, const CycleSpec& cycle = {},
                     const std::vector<VisibleBand>& bands = ReportedBands());

// Returns the content of summary.json, without times. Picks per hour contain the computing time
// only if the settings give it, and are null if nothing was picked.
std::string SummaryJson(const RunSummary& summary);
// Returns sentences on the instances in view: how many do not count because they are hidden, and
// how occluded the others are. Empty without images.
std::string InViewText(const RunSummary& summary);
// Returns the summary as text for the console.
std::string SummaryTable(const RunSummary& summary);

}  // namespace pickbed::eval
