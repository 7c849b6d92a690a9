#pragma once

// Scores and outcomes of a finished run, on which scores are calibrated.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/stats/roc.h"
#include "eval/trial/trial_records.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// Scores of one run by bin. Bins without a pose are left out.
struct CalibrationSamples {
  std::string run;          // results folder
  EstimatorSpec estimator;  // its settings
  // Reported poses: original score of the estimator, and whether the pose is right. Poses of an
  // image that several picks share count once.
  OutcomeClusters poses;
  // Executed grasps: original score of the pose, and whether the pick succeeded. The same bins.
  OutcomeClusters picks;
};

// Collects the samples of some trials. `run` and `estimator` are left empty.
CalibrationSamples SamplesOf(const std::vector<TrialResult>& trials);

// Reads the samples of a run. `configuration`: number of the configuration of a sweep; none = the
// only one. Throws InputError if the folder has no results, for a sweep without a number, for a run
// without poses, with the oracle, with stages replaced by ground truth, or with a calibration.
// A damaged trial is refused in the same way, with the names of the store, the table and the trial.
CalibrationSamples ReadSamples(const std::filesystem::path& run,
                               std::optional<int> configuration = std::nullopt);

}  // namespace pickbed::eval
