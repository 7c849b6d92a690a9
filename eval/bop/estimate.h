#pragma once

// Runs an estimator on a BOP data set, real or simulated.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/bop/results_csv.h"
#include "scenes/scenario_spec.h"

namespace pickbed::bop {

// What BOP tells an estimator of an image that is a target of BOP19: localisation, which objects
// are in it and how many of each, without a file of targets counted from the truth; detection,
// nothing.
enum class Task { kLocalisation, kDetection };

struct EstimateOptions {
  EstimatorSpec estimator;
  std::string refiner = "pcl_icp";
  uint64_t seed = 0;
  int threads = 1;  // at most; results are the same for any number
  Task task = Task::kLocalisation;
};

struct EstimateProgress {
  std::string what;  // scene and image, or the code book that is made
  double share = 0;
};

// Of every target image, poses of the objects that are its targets, of each no more than are to be
// found (BOP19 and localisation), or all poses of any object of the data set (detection, or where
// only BOP24 names the image). The estimator gets images, cameras, meshes and, in localisation,
// these counts; no other truth and no background, since BOP knows no bin. Throws
// InputError for an unknown estimator, the oracle (it would need the truth) and a broken data set:
// before the first image is worked on.
std::vector<Estimate> EstimateDataset(
    const std::filesystem::path& root, const std::string& split, const EstimateOptions& options,
    const std::function<void(const EstimateProgress&)>& on_progress = {});

// How the poses of one target image come about, as EstimateDataset finds them, as a page in
// `folder` (explain.h). `image` is "SCENE/IMAGE", as in "48/12", or the number of the image among
// the targets, from 0. Throws InputError, as above and for an image that is no target.
void ExplainTarget(const std::filesystem::path& root, const std::string& split,
                   const EstimateOptions& options, const std::string& image,
                   const std::filesystem::path& folder,
                   const std::function<void(const EstimateProgress&)>& on_progress = {});

}  // namespace pickbed::bop
