#pragma once

// Plug-in interface of perception: an estimator maps an RGB-D frame to ranked pose hypotheses. It
// never gets ground truth. A new estimator is one file in estimators/ and one row in
// pose_estimator.cpp.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "perception/pose_hypothesis.h"
#include "scenes/base/random.h"
#include "scenes/base/stage_timer.h"
#include "scenes/bin/bin.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/labelled_view.h"
#include "scenes/scenario/failure_reason.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::perception {

struct EstimateTrace;     // candidates/estimate_trace.h
class EstimatorTraining;  // estimators/estimator_training.h

// Input of one estimate.
struct EstimatorInput {
  const RgbdFrame& frame;
  std::optional<KnownBackground> background;  // none: the background planes are fitted and removed
  // Filled by estimators whose table row has `explains`; null = no trace. It does not change the
  // result.
  EstimateTrace* trace = nullptr;
  // Known number of instances by object index, as in BOP's 6D localisation task; empty = unknown.
  // The result has at most this many hypotheses per object. InputError if the size is not the
  // number of objects.
  std::vector<int> instances = {};
  // Returns how many of the poses, best first, a grasp can reach; it stops counting at `wanted`.
  // Only search mode "first" asks; empty = every pose can be reached.
  std::function<int(std::span<const PoseHypothesis>, int wanted)> count_reachable = {};
  std::optional<Pose> X_WC = {};  // pose of the camera in the world; none: unknown
  // The first image of a run. An answer of the estimator `process` that breaks the protocol then
  // throws InputError, because it is most probably a mistake that all answers have.
  bool is_first = false;
  // Region of interest, of the size of the depth image: pixels that are not 0. Null = all. Only
  // these pixels propose poses, and background planes are fitted to them. An estimator that is
  // another program does not get it. Poses outside are not removed.
  const Image<uint8_t>* region = nullptr;
  // False: without a given background, no plane is looked for.
  bool fits_background = true;
};

// Why an estimator that is another program gave no poses.
struct EstimatorFailure {
  FailureReason reason = FailureReason::kEstimatorCrashed;  // or kEstimatorTimeout
  std::string text;                                         // one line
  std::vector<std::string> traceback;                       // the program's own report, by line
};

// Result of one estimate.
struct EstimateResult {
  std::vector<PoseHypothesis> hypotheses;  // highest score first
  StageSeconds seconds;
  std::optional<EstimatorFailure> failure = {};  // the hypotheses are then empty
  // False if the estimator looked for a table, floor or bin in the image and recognised none.
  bool has_background = true;
  // Ways in which the image differs from the training images, one sentence each; see
  // verify/image_domain.h. Scores are lowered for them. Empty for estimators without a verifier.
  std::vector<std::string> domain_warnings = {};
};

// Interface of an estimator.
class PoseEstimator {
 public:
  virtual ~PoseEstimator() = default;
  // Estimates the poses of all instances in the frame. The same input and state of `rng` give the
  // same hypotheses.
  virtual EstimateResult Estimate(const EstimatorInput& input, Rng& rng) = 0;
};

// Inputs for making an estimator.
struct EstimatorSetup {
  ObjectSet objects;  // objects that may be in the bin
  EstimatorSpec spec;
  std::string refiner = "pcl_icp";  // a row of RefinerTable(), see icp/final_refinement.h
  CameraIntrinsics intrinsics;
  double working_distance_m = 0.85;  // camera to objects, for codebooks
  LabelledViewSource* views =
      nullptr;                      // of the same objects; needed if the table row has `renders`
  std::filesystem::path cache_dir;  // for codebooks; empty = no cache
  int threads = 1;                  // maximum number; results do not depend on it
  std::optional<Bin> bin = {};      // none: unknown
  std::filesystem::path log_dir;    // for the output of other programs; empty = not kept
  std::function<void(std::string_view what, double share)> on_progress;  // may be empty
};

// Returns how many pixels per axis the estimators join before their search, see
// perception/cloud/search_cloud.h.
int SearchBinning(const EstimatorSetup& setup);

// One row of the table of estimators.
struct EstimatorRow {
  const char* name;
  const char* help;
  std::span<const char* const> modes;  // allowed values of EstimatorSpec::mode
  std::unique_ptr<PoseEstimator> (*make)(const EstimatorSetup& setup);
  bool explains = false;   // fills EstimatorInput::trace
  bool renders = false;    // uses EstimatorSetup::views
  bool completes = false;  // uses EstimatorSpec::completion
  // Makes the access to its model file and training, see estimator_training.h. Null: it has
  // neither.
  std::unique_ptr<EstimatorTraining> (*make_training)() = nullptr;
};

// Returns all estimators.
std::span<const EstimatorRow> EstimatorTable();

// Returns the row with this name. Throws InputError with the known names if there is none.
const EstimatorRow& EstimatorNamed(const std::string& name);

// Throws InputError with the known names if the estimator of `spec` is unknown or has no such mode.
void RequireMode(const EstimatorSpec& spec);

// Makes the estimator setup.spec.name. With spec.calibration, its scores are the calibrated
// probabilities. It then searches with the minimum score of the run on which the calibration was
// fitted, and spec.min_score applies to the probabilities. Uncalibrated raw scores are replaced by
// ranks (MakeRanked()). Throws InputError for an unknown name, mode or refiner, for a calibration
// that does not fit, and as the estimator does.
std::unique_ptr<PoseEstimator> MakeEstimator(const EstimatorSetup& setup);

}  // namespace pickbed::perception
