#pragma once

// The methods whose picks are executed: poses from BOP results files, or the true poses.
//
// Scores can have any scale, because only their order counts. The planner needs a confidence in
// 0..1: the share of the estimates of the file with a lower score, plus half of the share with an
// equal score. So any increasing function of the scores gives the same picks.

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "eval/bop/read_dataset.h"
#include "eval/bop/results_csv.h"
#include "eval/bop/stored_scenes.h"

namespace pickbed::eval {

inline constexpr char kTruePosesMethod[] = "oracle";

struct MethodPose {
  int object_id = 0;
  Pose X_CO = Pose::Identity();
  double score = 0;       // as in the file
  double confidence = 0;  // 0..1, from the order of the scores
};

// A method with its poses by (scene, image), highest score first.
struct Method {
  std::string name;
  std::map<std::pair<int, int>, std::vector<MethodPose>> images;
};

// A scene of the data set with its ground truth and its physics.
struct ExecutedScene {
  SceneTruth truth;
  StoredScenes stored;
};
using ExecutedScenes = std::map<int, ExecutedScene>;  // by scene id

// Returns the method of these estimates.
Method MethodOf(const std::string& name, const std::vector<DatasetEstimate>& estimates);

// Returns the poses of all instances that are at least 10 % visible, with the visible fraction as
// the score. They come from the files of the data set: the method that knows the truth.
std::vector<DatasetEstimate> TrueEstimates(const std::filesystem::path& root,
                                           const std::string& split);
// Returns the same poses of scenes that were read. In a cell with errors, they are the poses in the
// true camera frame, as of an estimator that makes no error.
std::vector<DatasetEstimate> OracleEstimates(const ExecutedScenes& scenes);

// Checks the estimates of a results file against the data set and its bin. Throws InputError for a
// scene, image or object that the data set does not have, and for translations in metres. Throws
// also if no estimate is near the bin, as in results of another data set.
void RequireEstimatesOf(const std::filesystem::path& file,
                        const std::vector<DatasetEstimate>& estimates, const ExecutedScenes& scenes,
                        const Bin& bin, int objects);

// Returns one line about images without an estimate; empty if every image has one.
std::string MissingImagesText(const std::filesystem::path& file, const Method& method,
                              const ExecutedScenes& scenes);

}  // namespace pickbed::eval
