#pragma once

// The plug-in boundary of perception: an RGB-D frame in, ranked pose hypotheses out. An estimator
// never sees the truth. Adding one is one file in estimators/ and one row in pose_estimator.cpp.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "perception/pose_hypothesis.h"
#include "scenes/bin.h"
#include "scenes/labelled_view.h"
#include "scenes/random.h"
#include "scenes/rgbd_frame.h"
#include "scenes/scenario_spec.h"
#include "scenes/stage_seconds.h"

namespace pickbed {

class CandidateSource;
struct EstimateTrace;       // estimate_trace.h
struct LearnedNetwork;      // torch_verifier_file.h
struct TrainingOptions;     // training.h
struct WohlhartBinOptions;  // estimators/wohlhart.h

struct EstimatorInput {
  const RgbdFrame& frame;
  std::optional<KnownBackground> background;  // none: a dominant plane is fitted and removed
  // Filled by estimators whose row `explains`; null costs nothing. The answer is the same.
  EstimateTrace* trace = nullptr;
  // How many of each object are there to be found, by object index, where that is told, as in BOP's
  // 6D localisation task; empty: unknown. Answers keep to it. As many as objects, else InputError.
  std::vector<int> instances = {};
};

struct EstimateResult {
  std::vector<PoseHypothesis> hypotheses;  // highest score first
  StageSeconds seconds;
};

class PoseEstimator {
 public:
  virtual ~PoseEstimator() = default;
  virtual EstimateResult Estimate(const EstimatorInput& input, Rng& rng) = 0;
};

// What an estimator is made from.
struct EstimatorSetup {
  ObjectSet objects;  // those that may be in the bin
  EstimatorSpec spec;
  std::string refiner = "pcl_icp";  // what polishes the reported poses, see polish.h
  CameraIntrinsics intrinsics;
  double working_distance_m = 0.85;     // camera to parts, for code books
  LabelledViewSource* views = nullptr;  // over the same objects; may be null where no row renders
  std::filesystem::path cache_dir;
  int threads = 1;  // at most; results are the same for any number
  std::function<void(std::string_view what, double share)> on_progress;  // may be empty
};

// What candidates are made from.
struct CandidateSetup {
  const ObjectSet& objects;
  LabelledViewSource& views;  // of these and maybe other parts
  const LearnedNetwork& network;
};

// To learn the network that candidates come from.
struct LearnJob {
  LabelledViewSource& views;  // its objects are what is learned
  const WohlhartBinOptions& options;
  uint64_t seed = 0;
  std::filesystem::path checkpoint;            // see WohlhartJob
  std::function<bool(double share)> on_share;  // false = stop; may be empty
  int threads = 1;                             // what is learned does not depend on it
};

struct EstimatorRow {
  const char* name;
  const char* help;
  std::unique_ptr<PoseEstimator> (*make)(const EstimatorSetup& setup);
  // The trained model that it will read, which need not exist; null or empty: it reads none.
  std::filesystem::path (*model_file)(const EstimatorSpec& spec) = nullptr;
  bool explains = false;  // fills EstimatorInput::trace
  bool renders = false;   // makes use of setup.views
  // What its verifiers are trained on, where no descriptor of patches is learned; else null.
  std::unique_ptr<CandidateSource> (*candidates)(const CandidateSetup& setup) = nullptr;
  // How its model is trained by `pickbed train NAME`, by default; null = not so.
  TrainingOptions (*training)() = nullptr;
  // Learns the network of `candidates`, nothing when stopped; null = they need none.
  std::optional<LearnedNetwork> (*learn)(const LearnJob& job) = nullptr;
};

std::span<const EstimatorRow> EstimatorTable();

}  // namespace pickbed
