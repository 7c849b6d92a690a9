#pragma once

// Paired comparison of two runs on the same scenes. For each statistic: both values, their
// difference with interval and p value, and the number of scenes needed to show such a difference.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/stats/paired_tests.h"
#include "eval/summary/run_summary.h"
#include "eval/trial/trial.h"

namespace pickbed::eval {

// One statistic of both runs.
struct PairedStatistic {
  std::string key;      // such as "recall_30_50"
  std::string name;     // such as "recall, 30-50 % visible"
  bool is_rate = true;  // rate in 0..1; else an error, smaller is better
  double before = 0, after = 0;
  // Interval of after - before; unknown with too few scenes. A median needs six of them.
  Interval difference_ci95 = Interval::Unknown();
  double p_value = 1;
  std::string test = {};      // test that gave p_value: "mcnemar" | "sign_flip"
  int scenes = 0;             // scenes with data in either run
  int discordant_scenes = 0;  // scenes in which the runs differ
  // Number of scenes that shows this difference with power 0.8 at level 0.05; only for rates.
  std::optional<int> scenes_needed = std::nullopt;
  std::optional<OddsRatio> odds_ratio = std::nullopt;  // only if each scene has one outcome

  double difference() const { return after - before; }
};

// All statistics of a pair of runs.
struct PairedComparison {
  int scenes = 0;       // shared
  int before_only = 0;  // scenes that only one of the runs has
  int after_only = 0;
  std::vector<PairedStatistic> statistics;
};

// Compares the trials of two runs, one configuration each. Trials are paired by scene number. The
// statistics are:
// - pick success, attempts that picked, instances cleared, targets picked by visible fraction,
// - recall of all instances with a visible fraction of at least 0.1, and by visible fraction; in
//   occlusion trials recall of the targets, and of all instances in view,
// - precision,
// - share of correct top-ranked poses,
// - median of each compared metric (MetricTable), such as MSSD and rotation error, on the instances
//   found by both (PairedErrorsByScene).
// Statistics without data in a run are left out. `bands` must be the bands of both configurations.
// Throws InputError if no scene is shared.
PairedComparison ComparePaired(std::span<const TrialResult> before,
                               std::span<const TrialResult> after,
                               const std::vector<VisibleBand>& bands = ReportedBands());

// Compares two rates as clusters by scene; one row of the table.
PairedStatistic PairedRate(const std::string& key, const std::string& name,
                           const std::vector<Cluster>& before, const std::vector<Cluster>& after);

// Returns the part of the settings or identity of a run (eval/sweep/run.h) that determines its
// scenes. It holds seed, bin, objects and arrangement, and the mesh hashes if the text has them.
// For occlusion trials it also holds the camera and all of `occlusion`, which place the blockers.
// If the keys are equal, trials of equal number have the same scenes, whatever camera or sensor
// captures them.
std::string SceneKey(const std::string& settings);

// Throws InputError unless the scene keys agree. The message names both runs, the first setting
// that differs, and its group.
void RequireSameScenes(const std::string& settings_before, const std::string& settings_after,
                       const std::string& name_before, const std::string& name_after);

// Returns the difference of a statistic with its 95 % interval. Rates are in percentage points,
// errors in their unit.
std::string DifferenceText(const PairedStatistic& statistic);
// Returns the comparison as a table for the console. Statistics that are equal in every scene are
// only counted, unless `all_rows`; `remedy` is added to that line and says how to see them.
std::string PairedTable(const PairedComparison& comparison, bool all_rows = false,
                        const std::string& remedy = "");
// Returns the comparison as JSON.
std::string PairedJson(const PairedComparison& comparison);

}  // namespace pickbed::eval
