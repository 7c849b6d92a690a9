#pragma once

// A pose estimator for images of a real camera: codebooks are made for the camera and the median
// depth of the first image, because nothing else is known.

#include <filesystem>
#include <functional>
#include <memory>
#include <string_view>

#include "eval/layer.h"
#include "perception/estimators/pose_estimator.h"

namespace pickbed::eval {

// Default minimum score of a pose in an image without a scenario. It is higher than in a scenario,
// whose bin is known: unknown surroundings give more wrong poses. See
// docs/pages/benchmarks_rooms.md.
inline constexpr double kMinImageScore = 0.6;

struct ImageEstimatorSetup {
  ObjectSet objects;
  EstimatorSpec spec;
  std::string refiner = "pcl_icp";
  int threads = 1;                     // upper limit; the results are the same for any number
  std::filesystem::path log_dir = {};  // for the output of an estimator that is another program
  std::function<void(std::string_view what, double share)> on_progress = {};
};

// Holds an estimator with its objects and views.
class ImageEstimator {
 public:
  // `first` must have a depth reading. Throws InputError as MakeEstimator().
  ImageEstimator(const ImageEstimatorSetup& setup, const RgbdFrame& first);
  ~ImageEstimator();

  EstimateResult Estimate(const EstimatorInput& input, Rng& rng);
  const ObjectSet& objects() const { return objects_; }
  LabelledViewSource& views() { return *views_; }  // only for estimators that render
  double working_distance_m() const { return working_distance_m_; }

 private:
  ObjectSet objects_;
  double working_distance_m_ = 0;
  std::unique_ptr<LabelledViewSource> views_;
  std::unique_ptr<PoseEstimator> estimator_;
};

// Returns whether any pixel has a reading.
bool HasReadings(const Image<float>& depth_m);

}  // namespace pickbed::eval
