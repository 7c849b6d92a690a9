#pragma once

// Calibration of an estimator's score: functions from the score to the probability that the pose is
// right, and to the probability that a pick at it succeeds. `pickbed calibrate` fits it on a run.
// docs/pages/guides/calibration.md describes the file.

#include <filesystem>
#include <string>
#include <vector>

#include "perception/layer.h"
#include "scenes/base/settings.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::perception {

// A point of a ScoreCurve.
struct ScoreKnot {
  double score = 0;
  double probability = 0;
  void Visit(SettingsVisitor& v);
};

// A rising, piecewise linear function from scores to probabilities. It is constant outside of its
// knots.
struct ScoreCurve {
  std::vector<ScoreKnot> knots;  // with rising scores

  bool empty() const { return knots.empty(); }
  // Returns the probability for a score. Must not be empty.
  double At(double score) const;
};

// A calibration and the settings of the estimator for which it holds.
struct ScoreCalibration {
  static constexpr int kVersion = 1;

  std::string run;  // results folder on which it was fitted
  // Settings of the estimator in that run; see EstimatorSpec.
  std::string estimator, mode, model, scores = "probability";
  std::vector<std::string> command;
  double min_score = 0;
  int bins = 0, poses = 0, right = 0;  // number of samples
  int picks = 0, picked = 0;
  ScoreCurve pose_right;
  ScoreCurve pick_succeeds;  // empty: too few picks, or all with the same outcome

  void Visit(SettingsVisitor& v);

  // Returns the curve for EstimatorSpec::calibrated_to. Throws InputError if the file has none.
  const ScoreCurve& CurveFor(const EstimatorSpec& spec) const;
  // Throws InputError unless the calibration is for the estimator of `spec`: name, mode, model, and
  // the file names in the command.
  void RequireFor(const EstimatorSpec& spec) const;
};

// Returns the calibration as YAML.
std::string WriteCalibration(ScoreCalibration calibration);
// Reads a calibration file. Throws InputError for a file of another kind or version, a truncated
// file, and a curve that falls.
ScoreCalibration ReadCalibration(const std::filesystem::path& file);
// Reads spec.calibration, and checks that it has what `spec` needs. Throws InputError.
ScoreCalibration CalibrationFor(const EstimatorSpec& spec);

}  // namespace pickbed::perception
