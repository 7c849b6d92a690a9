#pragma once

// Occlusion trials by band of the target's visible fraction: recall of the target, how exact its
// best pose is, and how often the pick that was aimed at it succeeds.
//
// Units of intervals are scenes, see ClusterInterval: a band has one look a scene, so that its
// intervals are Wilson's where no scene comes twice.

#include <map>
#include <span>
#include <string>
#include <vector>

#include "eval/error_median.h"
#include "eval/statistics.h"
#include "eval/trial.h"
#include "scenes/occlusion_spec.h"

namespace pickbed {

struct ShareOfLooks {
  int hits = 0;
  Interval ci95;
};

// Medians, of the hypothesis with the highest score among those that stand on the target.
struct ErrorMedians {
  int looks = 0;  // that have one
  ErrorMedian mssd_diameters, translation_m, rotation_rad;
};

struct BandFigures {
  VisibleBand band;
  int looks = 0;
  double mean_visible = 0;
  ShareOfLooks recalled;  // some hypothesis is right for the target
  ShareOfLooks picked;    // the pick brought the target
  ErrorMedians errors;
  std::map<std::string, int> losses;  // why picks were lost
  int trials_without = 0;             // trials that found no scene for this band
  BandAccount account;                // of all trials; `given_up` targets and blockers
};

// One for each band of `spec`, from the least visible on. Trials without looks at targets add
// nothing.
std::vector<BandFigures> FiguresByBand(std::span<const TrialResult> trials,
                                       const OcclusionSpec& spec);

// Several points of a sweep side by side; errors in mm, degrees and diameters. Empty cells where
// there is nothing to tell.
struct NamedCurve {
  std::string point;  // its name
  std::vector<BandFigures> bands;
};
std::string CurveCsv(std::span<const NamedCurve> curves);

// For people: the curve, then each band that some trial could not fill, with what was tried.
std::string CurveTable(const std::vector<BandFigures>& bands);

}  // namespace pickbed
