#pragma once

// Trials of a run as the plain tables that its report shows: rates with intervals, histograms,
// calibration and a list of lost picks. Made from stored trials alone. Scenes are the units of all
// intervals.

#include <span>
#include <string>
#include <vector>

#include "eval/error_median.h"
#include "eval/loss_budget.h"
#include "eval/statistics.h"
#include "eval/summary.h"
#include "eval/trial.h"

namespace pickbed {

struct ReportOptions {
  int confidence_bins = 10;    // of the calibration's chart, 2 .. 100
  int error_bins = 25;         // of an error's histogram, 2 .. 200
  double error_share = 0.95;   // of all errors that a histogram reaches to, 0.5 .. 1
  int failures = 240;          // in the gallery at most, 0 .. 5000
  int picture_width_px = 520;  // of the gallery's pictures, 64 .. 4096
  int picture_quality = 72;    // JPEG, 1 .. 100
  double pictures_mb = 6;      // of all of them, 0 .. 100
  int views = 4;               // in 3D: lost picks and one success, 0 .. 20
  double views_mb = 4;         // of all of them, 0 .. 100
  int cloud_points = 20000;    // of a view, 0 .. 1000000
  int view_triangles = 3000;   // of a part in a view, 100 .. 1000000
  // Throws std::logic_error.
  void Validate() const;
};

// What one set of settings did.
struct PointTrials {
  std::string name;
  std::vector<std::string> objects;  // names of the parts
  std::vector<TrialResult> trials;   // by trial
  CycleSpec cycle;
  std::vector<VisibleBand> bands = ReportedBands();  // by which rates are told
};

struct ReportRate {
  int hits = 0, tries = 0;
  Interval ci95;
  double rate() const { return tries > 0 ? static_cast<double>(hits) / tries : 0; }
};

// Of parts whose visible fraction is in a band: the band's share of them that was recalled, and the
// share of grasps aimed at them that succeeded. Where looks have a target, of the target alone.
struct BandRates {
  VisibleBand band;
  ReportRate recall, picks;
  ReportRate targets;  // of looks at a target, those that brought it; without targets none tried
};

enum class PoseError { kMssd, kTranslation, kRotation };
inline constexpr int kPoseErrors = 3;
struct PoseErrorRow {
  PoseError error;
  const char* name;                            // "MSSD"
  const char* unit;                            // "diameters"
  int digits;                                  // behind the point, that people are shown
  double (*of)(const HypothesisScore& score);  // in that unit
};
std::span<const PoseErrorRow> PoseErrorTable();

struct ErrorBin {
  double low = 0, high = 0;
  int right = 0, wrong = 0;  // poses with MSSD below and above a tenth of the diameter
};
struct ErrorHistogram {
  std::vector<ErrorBin> bins;
  int beyond = 0;  // poses that are worse than the last bin
  int total = 0;   // with those beyond
  ErrorMedian median;
};

// Seconds a trial.
struct StageTime {
  std::string stage;  // "estimate/icp" is a part of "estimate"
  double mean_s = 0;
  double low_s = 0, high_s = 0;  // 10th and 90th percentile over trials
};

struct ConfidenceBin {
  double mean_confidence = 0;
  ReportRate right;
};
// Reported poses by confidence; bins that hold none are left out.
struct Calibration {
  std::vector<ConfidenceBin> bins;
  int poses = 0;
  // Expected calibration error: mean distance of confidence and share of right ones over the bins,
  // weighted by their poses (Guo et al. 2017, eq. 3).
  double expected_error = 0;
};

struct ObjectReport {
  std::string name;
  int dropped = 0, picked = 0;
  ReportRate recall;                  // of those in view, kCountedVisibility or more
  ReportRate picks;                   // of executed grasps that were aimed at it
  ErrorMedian median_mssd_diameters;  // of hypotheses of it
  Loss commonest = Loss::kNone;       // of its fates; kNone = no loss
};

struct PointReport {
  std::string name;
  RunSummary summary;
  BudgetShares attempts;
  ReportRate recall;  // of all parts in view
  std::vector<BandRates> bands;
  std::vector<ErrorHistogram> errors;  // by PoseError
  Calibration calibration;
  std::vector<StageTime> seconds;  // longest first, each before its parts
  std::vector<ObjectReport> objects;
};

// All points in one go, for histograms of different points have the same bins.
std::vector<PointReport> ReportOn(std::span<const PointTrials> points,
                                  const ReportOptions& options = {});

// A look that brought no part.
struct LostPick {
  int point = 0;
  int trial = 0, pick = 0;
  Loss loss = Loss::kNone;
  // Of the executed grasp; negative, empty without one. Visible: of a look's target in any case.
  std::string object;
  double visible_fraction = -1, confidence = -1, mssd_diameters = -1;
};
// By trial and pick.
std::vector<LostPick> LostPicksOf(std::span<const PointTrials> points);

// `most` of them that show every reason: of each in turn the next, then in their old order.
std::vector<LostPick> SpreadOverReasons(const std::vector<LostPick>& picks, int most);

}  // namespace pickbed
