#include "eval/frames/image_estimator.h"

#include <algorithm>
#include <vector>

#include "perception/estimators/finite_poses.h"
#include "scenes/base/files.h"
#include "sim/convex/convex_pieces.h"
#include "sim/sensor/depth_noise.h"
#include "sim/training_view_source.h"

namespace pickbed::eval {
namespace {

// Median depth in metres. Used as a working distance because it needs no ground truth.
double MedianDepth_m(const Image<float>& depth_m) {
  std::vector<float> readings;
  for (const float d : depth_m.pixels()) {
    if (d > 0) readings.push_back(d);
  }
  std::nth_element(readings.begin(), readings.begin() + readings.size() / 2, readings.end());
  return readings[readings.size() / 2];
}

}  // namespace

bool HasReadings(const Image<float>& depth_m) {
  return std::ranges::any_of(depth_m.pixels(), [](float d) { return d > 0; });
}

ImageEstimator::ImageEstimator(const ImageEstimatorSetup& image_setup, const RgbdFrame& first)
    : objects_(image_setup.objects), working_distance_m_(MedianDepth_m(first.depth_m)) {
  EstimatorSetup setup;
  setup.spec = image_setup.spec;
  setup.refiner = image_setup.refiner;
  setup.intrinsics = first.intrinsics;
  setup.working_distance_m = working_distance_m_;
  if (EstimatorNamed(image_setup.spec.name).renders) {
    objects_ = WithConvexPieces(objects_);
    ViewSourceOptions view_options;
    view_options.sensor = LoadSensorProfile(ScenarioSpec().sensor);
    view_options.camera = first.intrinsics;
    views_ = MakeSimViewSource(objects_, view_options);
  }
  setup.objects = objects_;
  setup.threads = image_setup.threads;
  setup.views = views_.get();
  setup.log_dir = image_setup.log_dir;
  setup.cache_dir = CacheDir();
  setup.on_progress = image_setup.on_progress;
  estimator_ = MakeEstimator(setup);
}

ImageEstimator::~ImageEstimator() = default;

EstimateResult ImageEstimator::Estimate(const EstimatorInput& input, Rng& rng) {
  EstimateResult result = estimator_->Estimate(input, rng);
  DropNotFinite(result.hypotheses);
  return result;
}

}  // namespace pickbed::eval
