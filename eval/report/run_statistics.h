#pragma once

// Statistics of a run as shown in its report: rates with intervals, histograms, calibration, and a
// list of failed picks. Computed only from stored trials. Scenes are the units of all intervals.

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "eval/draw/overlay.h"
#include "eval/stats/median_error.h"
#include "eval/stats/statistics.h"
#include "eval/summary/failure_budget.h"
#include "eval/summary/run_summary.h"
#include "eval/trial/trial.h"

namespace pickbed::eval {

// Options of a report.
struct ReportOptions {
  int confidence_bins = 10;   // bins of the calibration chart, 2 .. 100
  int error_bins = 25;        // bins of an error histogram, 2 .. 200
  double error_share = 0.95;  // share of all errors inside the histogram range, 0.5 .. 1
  int failures = 240;         // maximum number of failures in the gallery, 0 .. 5000
  PictureSize picture;        // size of the pictures in the gallery
  double pictures_mb = 6;     // all gallery pictures together, 0 .. 100
  int views = 4;              // 3D views: failures and one success, 0 .. 20
  double views_mb = 4;        // all 3D views together, 0 .. 100
  int animations = 3;         // animated picks: failures and one success, 0 .. 20
  double animations_mb = 3;   // all animated picks together, 0 .. 100
  int cloud_points = 20000;   // points per view, 0 .. 1000000
  int view_triangles = 3000;  // per object in a view, 100 .. 1000000
  // Tolerance maps that forecast the pick success, see ToleranceMaps; empty = no forecast.
  std::vector<std::string> tolerance;
  // Folder of the page, for links to full pictures. Empty = no links.
  std::filesystem::path page_folder;
  // Throws std::logic_error if a value is out of range.
  void Validate() const;
};

// Rates of the instances in one band of visible fractions: share recalled, and success rate of the
// grasps that target them. In occlusion trials only the target counts.
struct BandRates {
  VisibleBand band;
  ReportRate recall, picks;
  // Attempts with a target that delivered it; samples is 0 without targets.
  ReportRate targets;
};

// A histogram bin [low, high).
struct ErrorBin {
  double low = 0, high = 0;
  int right = 0, wrong = 0;  // poses with MSSD below / not below 0.1 diameter
};
// Pose error of the instances in one band of visible fractions.
struct BandError {
  int poses = 0;
  ErrorMedian median;
};
// Histogram of one reported metric (MetricTable).
struct ErrorHistogram {
  std::string metric;  // key, such as "translation_m"
  std::string title;   // such as "translation"
  std::string unit;    // of the bins, such as "mm"
  int digits = 0;      // decimals of the median
  std::vector<ErrorBin> bins;
  int beyond = 0;  // poses with an error above the last bin
  int total = 0;   // including `beyond`
  ErrorMedian median;
  std::vector<BandError> by_band;  // one per ConfigurationReport::bands
};

// Times of a stage per trial.
struct StageTime {
  std::string stage;  // "estimate/icp" is included in "estimate"
  double mean_s = 0;
  double low_s = 0, high_s = 0;  // 10th and 90th percentile over trials
};

// Correct poses among the poses of one confidence bin.
struct ConfidenceBin {
  double mean_confidence = 0;
  ReportRate right;
};
// Calibration of the confidence of reported poses. Empty bins are left out.
struct Calibration {
  std::vector<ConfidenceBin> bins;
  int poses = 0;
  // Expected calibration error: mean absolute difference of confidence and share of correct poses
  // over the bins, weighted by number of poses (Guo et al. 2017, eq. 3).
  double expected_error = 0;
};

// Attempts `first` to `last` of each bin, counted from 0, and the share that picked.
struct AttemptRange {
  int first = 0, last = 0;
  ReportRate picked;
};

// Statistics of one object.
struct ObjectReport {
  std::string name;
  int dropped = 0, picked = 0;
  ReportRate recall;  // of instances with a visible fraction of at least kCountedVisibility
  ReportRate picks;   // of executed grasps that target it
  ErrorMedian median_mssd_diameters;  // of the hypotheses of this object
  // Most frequent failure reason of its instances; kNone = no failure.
  FailureReason commonest = FailureReason::kNone;
};

inline constexpr int kAttemptRanges = 20;

// Statistics of one configuration.
struct ConfigurationReport {
  std::string name;
  RunSummary summary;
  BudgetShares attempts;
  std::vector<BandRates> bands;
  // MSSD, translation, rotation, then other reported metrics that the trials have. The same for all
  // configurations of a report.
  std::vector<ErrorHistogram> errors;
  Calibration calibration;
  std::vector<StageTime> seconds;  // longest first, each followed by its sub-stages
  // At most kAttemptRanges ranges of equal length, as the bin empties. The same ranges for all
  // configurations of a report.
  std::vector<AttemptRange> attempt_ranges;
  std::map<std::string, int64_t> rejected;  // cause -> number of rejected grasp candidates
  std::vector<ObjectReport> objects;
};

// Computes the statistics of all configurations together, so that their histograms have the same
// bins.
std::vector<ConfigurationReport> ReportOn(std::span<const ConfigurationTrials> configurations,
                                          const ReportOptions& options = {});

// An attempt that picked no instance.
struct FailedPick {
  int configuration = 0;
  int trial = 0, attempt = 0;
  FailureReason failure = FailureReason::kNone;
  // Data of the executed grasp; negative or empty without one. In occlusion trials visible_fraction
  // is always set, for the target.
  std::string object;
  double visible_fraction = -1, confidence = -1, mssd_diameters = -1;
};
// Returns all failed attempts, ordered by configuration, trial and pick.
std::vector<FailedPick> FailedPicksOf(std::span<const ConfigurationTrials> configurations);

// Selects at most `maximum` failures so that every reason is shown: the first failure of each
// reason, then the second of each, and so on. The original order is kept.
std::vector<FailedPick> SpreadOverReasons(const std::vector<FailedPick>& picks, int maximum);

// Returns each band of visible fractions once, the least visible first. The configurations in one
// chart may have different bands.
std::vector<VisibleBand> BandsOfAll(std::span<const ConfigurationReport> configurations);

// Names of the configurations, in order.
std::vector<std::string> NamesOf(std::span<const ConfigurationReport> configurations);

}  // namespace pickbed::eval
