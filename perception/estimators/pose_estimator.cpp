#include "perception/estimators/pose_estimator.h"

#include <fmt/format.h>

#include <algorithm>

#include "perception/cloud/search_cloud.h"
#include "perception/estimators/calibrated.h"
#include "perception/estimators/descriptor.h"
#include "perception/estimators/doumanoglou.h"
#include "perception/estimators/estimator_training.h"
#include "perception/estimators/kehl.h"
#include "perception/estimators/ppf.h"
#include "perception/estimators/ppf_verified.h"
#include "perception/estimators/process.h"
#include "perception/estimators/score_calibration.h"
#include "perception/estimators/wohlhart.h"
#include "perception/icp/final_refinement.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

constexpr const char* kSearchModes[] = {"fast", "accurate"};
constexpr const char* kPatchModes[] = {"fast", "accurate", "first"};
constexpr const char* kPpfModes[] = {"fast", "accurate", kVerifiedMode};

constexpr EstimatorRow kEstimators[] = {
    {.name = "descriptor",
     .help = "learned patch descriptors that vote through a codebook, ICP and verifier",
     .modes = kPatchModes,
     .make = &MakeDescriptorEstimator,
     .explains = true,
     .renders = true,
     .completes = true,
     .make_training = &MakeDescriptorTraining},
    {.name = "kehl",
     .help = "patches described by an auto-encoder; votes filtered to modes; ICP and verifier of "
             "descriptor",
     .modes = kPatchModes,
     .make = &MakeKehlEstimator,
     .renders = true,
     .make_training = &MakeKehlTraining},
    {.name = "doumanoglou",
     .help = "poses regressed from patches by a siamese network; ICP and verifier of descriptor",
     .modes = kPatchModes,
     .make = &MakeDoumanoglouEstimator,
     .make_training = &MakeDoumanoglouTraining},
    {.name = "union",
     .help = "votes of descriptor together with poses regressed by the network of doumanoglou",
     .modes = kPatchModes,
     .make = &MakeUnionEstimator,
     .renders = true,
     .make_training = &MakeUnionTraining},
    {.name = "wohlhart",
     .help = "descriptors of whole objects compared with templates; ICP and verifier of descriptor",
     .modes = kSearchModes,
     .make = &MakeWohlhartEstimator,
     .renders = true,
     .make_training = &MakeWohlhartTraining},
    {.name = "ppf",
     .help = "point pair features with ICP, OpenCV's surface matching; mode verified: its poses "
             "with the ICP of descriptor and a verifier",
     .modes = kPpfModes,
     .make = &MakePpfEstimator,
     .make_training = &MakePpfTraining},
    {.name = kProcessName,
     .help = "your own program in any language, by messages over its input and output or over TCP",
     .modes = kSearchModes,
     .make = &MakeProcessEstimator},
};

void RequireScores(const EstimatorSpec& spec) {
  CheckInput(
      !HasRawScores(spec) || spec.name == kProcessName,
      fmt::format("scores = raw is only for estimator {}; the scores of {} are probabilities",
                  kProcessName, spec.name));
}

}  // namespace

std::span<const EstimatorRow> EstimatorTable() { return kEstimators; }

const EstimatorRow& EstimatorNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const EstimatorRow& row : kEstimators) {
    if (row.name == name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("estimator", name, names));
}

void RequireMode(const EstimatorSpec& spec) {
  const EstimatorRow& row = EstimatorNamed(spec.name);
  if (std::ranges::find(row.modes, spec.mode) != row.modes.end()) return;
  throw InputError(UnknownNameMessage(fmt::format("mode of estimator {}", row.name), spec.mode,
                                      {row.modes.begin(), row.modes.end()}));
}

int SearchBinning(const EstimatorSetup& setup) {
  return BinningFor(setup.intrinsics, setup.working_distance_m, SmallestDiameter_m(setup.objects));
}

std::unique_ptr<PoseEstimator> MakeEstimator(const EstimatorSetup& setup) {
  const EstimatorRow& row = EstimatorNamed(setup.spec.name);
  RequireMode(setup.spec);
  CheckSettings("EstimatorSpec", setup.spec);
  RefinerNamed(setup.refiner);
  RequireScores(setup.spec);
  CheckInput(row.completes || setup.spec.completion == kNoCompletion,
             fmt::format("estimator.completion: estimator {} does not complete shapes; use "
                         "estimator descriptor, or set it to none",
                         setup.spec.name));
  if (!setup.spec.calibration.empty()) {
    const ScoreCalibration calibration = CalibrationFor(setup.spec);
    EstimatorSetup as_fitted = setup;
    as_fitted.spec.scores = calibration.scores;
    as_fitted.spec.min_score = calibration.min_score;
    return MakeCalibrated(row.make(as_fitted), calibration.CurveFor(setup.spec),
                          setup.spec.min_score);
  }
  if (HasRawScores(setup.spec)) return MakeRanked(row.make(setup));
  return row.make(setup);
}

}  // namespace pickbed::perception
