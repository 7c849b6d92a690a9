#pragma once

// Scores of pose estimates on a BOP data set, by the rules in eval/bop/scores.h. Errors:
// VSD (tolerances 0.05 to 0.5 diameters, thresholds 0.05 to 0.5), MSSD (thresholds 0.05 to 0.5
// diameters) and MSPD (thresholds 5 to 50 px of an image 640 px wide). Symmetries come from
// models_info.json. Errors use all vertices of the meshes in models_eval, or models if it is
// absent.

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "eval/bop/results_csv.h"
#include "eval/bop/score_accumulator.h"
#include "eval/bop/vsd.h"
#include "grasp/tolerance/tolerance_model.h"

namespace pickbed::eval {

// Tolerance model of an object and the file from which it was read.
struct NamedTolerance {
  std::filesystem::path file;
  ToleranceModel model;
};
using TolerancesById = std::map<int, NamedTolerance>;
// Reads tolerance models. Each text has the form ID=PLACE: an obj_id, and a model.yaml written by
// `pickbed tolerance` or the folder of this file. Returns the models by obj_id. Throws InputError
// for any other text and for an object that occurs twice.
TolerancesById ReadTolerances(const std::vector<std::string>& texts);

struct ScoreOptions {
  VsdOptions vsd;
  int max_estimates = 0;  // of an image in BOP24; 0 = as the BOP toolkit, MaxEstimatesOf()
  std::string sensor;     // whose files are used, see ReadSceneTruth(); empty = the only one
};

// Returns the number of estimates of an image that count in BOP24: 100, or 200 if the folder of the
// data set is named xyzibd.
int MaxEstimatesOf(const std::filesystem::path& root);

// Scores `estimates` on the images of a split. `on_scene` is called before each scene with its
// folder. Throws InputError for a broken data set, a split without scenes, and targets without
// ground truth. Throws also for an object that models_info.json does not have, in `estimates` or
// `tolerances`, and for a tolerance model of another mesh.
DatasetScores EvaluateDataset(const std::filesystem::path& root, const std::string& split,
                              const std::vector<DatasetEstimate>& estimates,
                              const ScoreOptions& options = {},
                              const TolerancesById& tolerances = {},
                              const std::function<void(const std::string& scene)>& on_scene = {});

}  // namespace pickbed::eval
