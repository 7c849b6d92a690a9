#pragma once

// Compares estimators on the same bins. Each estimator gets the same images and the same random
// numbers, and is scored against the same ground truth.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "eval/bop/score_accumulator.h"
#include "eval/trial/pose_matching.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// The label has the form NAME[:MODE][=MODEL]: "ppf", "descriptor:accurate" or
// "kehl:accurate=kehl.net".
struct ComparedEstimator {
  std::string label;
  EstimatorSpec spec;
};
// Returns the label with the current name of its mode, and reports a former one
// (SetDeprecationListener()).
std::string CurrentLabel(const std::string& label);

// Parses the labels. Each result is `base` with the name, mode and model of the label. A label
// without a model uses the model of `base` if the names are equal, else the shipped model; the same
// holds for the calibration and the kind of scores. Throws InputError for unknown names, for a
// label that occurs twice, and for '=' without a model.
std::vector<ComparedEstimator> ParseEstimators(const std::vector<std::string>& labels,
                                               const EstimatorSpec& base);

// Throws InputError if an estimator has no mode of the name that its settings give. The oracle uses
// no mode.
void RequireModes(const ScenarioSpec& scenario, const std::vector<ComparedEstimator>& estimators);

// Result of one estimator on the image of one bin.
struct ComparedImage {
  int trial = 0;
  AttemptScore score;
  StageSeconds seconds;  // see EstimatorRunner
  // Success probability of a pick for each hypothesis, see eval/tolerance/maps.h. Empty without
  // maps.
  std::vector<std::optional<double>> pick_chances = {};
};

// Results of one estimator on all bins.
struct ComparedRow {
  std::string label;
  std::vector<ComparedImage> images;  // by trial
  DatasetScores bop;                  // AR and AP over all bins; object ids are index + 1
  double setup_s = 0;                 // time to load; includes codebooks that were not in the cache
  // Peak memory above what the process held before. For images after the first, memory that other
  // rows freed and this row reused is not counted.
  double peak_memory_mib = 0;
};

struct ComparisonJob {
  ScenarioSpec spec;
  ObjectSet objects;
  std::vector<ComparedEstimator> estimators;
  // Results folder; gets pictures/trial_0000/LABEL/ of the first bins and of the bins that
  // `wants_pictures` chooses, and logs of estimators that are other programs. Empty = neither.
  std::filesystem::path out;
  int pictured_bins = 0;
  int threads = 1;  // upper limit; the results are the same for any number
  std::function<void(std::string_view what, int done, int total)> on_progress;  // may be empty
  std::function<bool()> stop;                                                   // may be empty
  // Called when an estimator that is another program failed, with one line. May be empty.
  std::function<void(const std::string& line)> on_warning = {};
  // Called after each bin with the image of each estimator, in their order. Returns whether the
  // bin gets pictures although it is none of the first ones. May be empty.
  std::function<bool(const std::vector<const ComparedImage*>& images)> wants_pictures = {};
};

// Returns the file of the overlay of an estimator in a bin. `out` is ComparisonJob::out.
std::filesystem::path ComparedOverlay(const std::filesystem::path& out, int trial,
                                      const std::string& label);

// Fills the bins one after the other and runs each estimator on each image. If `stop` returns true,
// it ends after the current bin and returns the results so far. Throws InputError, see
// SimulatedCell and EstimatorRunner.
std::vector<ComparedRow> CompareEstimators(const ComparisonJob& job);

class ToleranceMaps;  // eval/tolerance/maps.h
// Fills `pick_chances` of every image from the tolerance models.
void AddPickChances(const ToleranceMaps& maps, std::vector<ComparedRow>& rows);

}  // namespace pickbed::eval
