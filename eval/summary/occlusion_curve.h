#pragma once

// Results of occlusion trials by band of the target's visible fraction: recall of the target,
// errors of its best pose, and success rate of the picks that target it.
//
// Scenes are the units of the intervals (see ClusterInterval). A band has one attempt per scene, so
// its intervals are Wilson intervals unless a scene number repeats.

#include <map>
#include <span>
#include <string>
#include <vector>

#include "eval/stats/median_error.h"
#include "eval/stats/statistics.h"
#include "eval/trial/trial.h"
#include "scenes/scenario/occlusion_spec.h"

namespace pickbed::eval {

// Number of attempts with a property, and the interval of their share.
struct ShareOfAttempts {
  int hits = 0;
  Interval ci95;
};

// Median pose errors of the hypothesis with the highest score among those matched to the target.
struct ErrorMedians {
  int attempts = 0;  // with such a hypothesis
  ErrorMedian mssd_diameters, translation_m, rotation_rad;
};

// Statistics of one band.
struct BandStatistics {
  VisibleBand band;
  int attempts = 0;
  double mean_visible = 0;
  ShareOfAttempts recalled;  // some hypothesis is correct for the target
  ShareOfAttempts picked;    // the pick delivered the target
  ErrorMedians errors;
  std::map<std::string, int> failures;  // failure reason -> number of attempts
  int trials_without = 0;               // number of trials without a scene for this band
  BandAccount account;                  // summed over all trials: targets given up and blockers
};

// Returns one entry per band of `spec`, in the order of the settings (least visible first).
// Attempts without a target in a band are not counted.
std::vector<BandStatistics> StatisticsByBand(std::span<const TrialResult> trials,
                                             const OcclusionSpec& spec);

// Curve of one configuration of a sweep.
struct NamedCurve {
  std::string configuration;  // its name
  std::vector<BandStatistics> bands;
};
// Returns a CSV table with one line per configuration and band; errors in mm, degrees and
// diameters. Cells without a value are empty.
std::string CurveCsv(std::span<const NamedCurve> curves);

// Returns the curve as a table for the console. Then come the bands that some trials could not
// fill, with the counts of targets and blockers that were tried. With `few_bins`, unknown intervals
// are left out, because the caller says that there are too few bins.
std::string CurveTable(const std::vector<BandStatistics>& bands, bool few_bins = false);

}  // namespace pickbed::eval
