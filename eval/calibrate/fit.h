#pragma once

// Fit of a score calibration, with its cross-validated quality.

#include <optional>
#include <string>

#include "eval/calibrate/samples.h"
#include "eval/stats/forecast_quality.h"
#include "perception/estimators/score_calibration.h"

namespace pickbed::eval {

// Minimum numbers of samples of a fit.
inline constexpr int kMinCalibrationSamples = 30;
inline constexpr int kMinCalibrationBins = kMinBinsOfInterval;
// Number of parts of the bins in the cross-validation, if there are as many bins.
inline constexpr int kCalibrationFolds = 10;

// Fits a rising curve by isotonic regression. One success at the lowest and one failure at the
// highest score are added, so that no finite sample gives a probability of 0 or 1.
ScoreCurve FitCurve(const OutcomeClusters& samples);

// A fitted curve and its quality.
struct FittedCurve {
  ScoreCurve curve;  // fitted to all samples
  int samples = 0, hits = 0;
  // The scores as they are; empty if a score is outside 0 to 1, so that they are no probabilities.
  ForecastClusters before;
  // Cross-validated: the curve that converts a score was fitted to bins of other folds.
  ForecastClusters after;
  std::optional<ForecastQuality> quality_before;
  ForecastQuality quality_after;
  std::optional<ForecastQuality> change;  // after minus before
};

// Returns why the samples are not enough, in one sentence; empty if they are. `noun`: "pose",
// "pick". `hit`: "right", "successful".
std::string TooFewSamples(const OutcomeClusters& samples, const std::string& noun,
                          const std::string& hit);

// Fits and cross-validates. Needs enough samples.
FittedCurve FitAndValidate(const OutcomeClusters& samples);

// Calibration of a run.
struct CalibrationFit {
  CalibrationSamples samples;
  FittedCurve pose_right;
  std::optional<FittedCurve> pick_succeeds;
  std::string no_picks;  // why there is no curve for picks
};

// Fits both curves. Throws InputError, which names the run, if the poses are too few, or all right
// or all wrong.
CalibrationFit FitCalibration(CalibrationSamples samples);

// Returns the file of the fit.
ScoreCalibration CalibrationOf(const CalibrationFit& fit);

}  // namespace pickbed::eval
