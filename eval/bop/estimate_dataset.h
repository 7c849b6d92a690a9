#pragma once

// Runs a pose estimator on the target images of a BOP data set, real or simulated.

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "eval/bop/results_csv.h"
#include "eval/bop/targets.h"
#include "eval/explain/explain.h"
#include "eval/frames/image_notes.h"
#include "scenes/bin/bin.h"
#include "scenes/scenario/region_spec.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// Prior knowledge about a BOP19 target image that the estimator gets. Localisation: the objects in
// the image and the number of instances of each. Without a targets file, the instances are counted
// from the ground truth. Detection: none.
enum class DatasetTask { kLocalisation, kDetection };

struct EstimateDatasetOptions {
  EstimatorSpec estimator;
  std::string refiner = "pcl_icp";
  uint64_t seed = 0;
  int threads = 1;  // upper limit; the results are the same for any number
  DatasetTask task = DatasetTask::kLocalisation;
  std::filesystem::path log_dir = {};  // for the output of an estimator that is another program
  // Bin in all images whose camera pose is known, at the origin of the world frame, as in data sets
  // of `pickbed dataset make`. nullopt: unknown, as in BOP.
  std::optional<Bin> bin = {};
  // Region of interest in each image. A box in the world frame needs images with a camera pose.
  RegionSpec region = {};
  // Images that are not processed, because an earlier run has their estimates.
  std::set<ListedImage> finished = {};
  // Called with each processed image and its estimates. May be empty.
  std::function<void(const DatasetImageNote& note, std::span<const DatasetEstimate> estimates)>
      on_image = {};
  // Called after each image; true ends the work. May be empty.
  std::function<bool()> stop = {};
  // Called with one line for each kind of doubtful images (CheckFrame), when such an estimator
  // failed, and at the end if the estimator recognised no background in some images. May be empty.
  std::function<void(const std::string& line)> on_warning = {};
};

struct EstimateDatasetProgress {
  std::string what;  // scene and image, or the codebook being built
  double share = 0;  // 0..1
};

// Estimates in the images of a dataset, also if the work ended early.
struct DatasetEstimates {
  std::vector<DatasetEstimate> estimates;
  std::vector<DatasetImageNote> notes;  // one per processed image
  size_t images = 0;                    // target images
  size_t done = 0;                      // processed images, and those finished before
};

// Estimates poses in every target image. In localisation on a BOP19 image, it returns poses of the
// target objects only, at most as many of each as are to be found. In detection, or if only BOP24
// names the image, it returns all poses of any object of the data set. The estimator gets images,
// cameras, meshes, the bin of the options and, in localisation, these counts. It gets no other
// ground truth. `on_progress` is called while codebooks are built and after each image. Each image
// adds to `result`, so that the estimates before an error are not lost. Throws InputError for an
// unknown estimator, the oracle (it would need ground truth) and a broken data set, or if
// CheckFrame() finds an error in every image. It reads all images before it processes the first, so
// that a broken file is reported at once.
void EstimateDataset(const std::filesystem::path& root, const std::string& split,
                     const EstimateDatasetOptions& options, DatasetEstimates& result,
                     const std::function<void(const EstimateDatasetProgress&)>& on_progress = {});

// Writes a page (eval/explain/explain.h) into `folder` that shows the stages by which
// EstimateDataset finds the poses of one target image. `image` is "SCENE/IMAGE", for example
// "48/12", or the index of the image among the targets, from 0. Throws InputError as
// EstimateDataset does, for an image that is no target, and for an estimator without a trace.
[[nodiscard]] ExplanationPage ExplainTarget(
    const std::filesystem::path& root, const std::string& split,
    const EstimateDatasetOptions& options, const std::string& image,
    const std::filesystem::path& folder,
    const std::function<void(const EstimateDatasetProgress&)>& on_progress = {});

}  // namespace pickbed::eval
