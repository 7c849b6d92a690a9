#include <cmath>

#include "eval/grasps/grasp_file.h"
#include "grasp/grippers/table.h"
#include "grasp/tolerance/model_files.h"
#include "perception/estimators/score_calibration.h"
#include "scenes/base/random.h"
#include "tests/eval/cube_scenario.h"
#include "tests/fuzz/format_targets.h"
#include "tests/fuzz/target_parts.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGripper = "jaw_8cm";

std::vector<GraspCandidate> Candidates() {
  Rng rng(5);
  std::vector<GraspCandidate> candidates(4);
  for (GraspCandidate& candidate : candidates) {
    candidate.X_OG = MakePose(rng.Rotation().toRotationMatrix(), 0.02 * rng.UnitVector());
    candidate.width_m = 0.03 * rng.Uniform();
    candidate.robust = rng.Uniform();
  }
  return candidates;
}

// Reads grasps of the cube, as `pickbed grasps --test` does.
void ReadGraspsOfCube(const fs::path& path) {
  const auto gripper = LoadGripper(kGripper);
  const ObjectSet cube = EasyCube();
  const GripperFrame frame;
  const GraspFile file = ReadGraspFile(path);
  RequireGraspsOf(file, *cube[0], *gripper, frame);
  for (const GraspCandidate& candidate : CandidatesOf(file, *cube[0], *gripper, frame)) {
    RequireLaw(candidate.X_OG.matrix().allFinite() && candidate.X_OG.linear().isUnitary(1e-2),
               "a grasp has a pose");
    RequireLaw(candidate.width_m >= 0 && candidate.width_m < 1, "a grasp has a width");
    RequireLaw(candidate.robust >= 0 && candidate.robust <= 1, "a confidence is a share");
  }
}

FuzzTarget GraspsTarget(const std::string& extension) {
  const std::string name = "grasps." + extension;
  const auto seeds = [name] {
    return Contents{BytesOfFile(name, [](const fs::path& file) {
      WriteGraspFile(file, *EasyCube()[0], *LoadGripper(kGripper), {}, Candidates());
    })};
  };
  return OneFile("grasps_" + extension, name, ReadGraspsOfCube, seeds);
}

ToleranceModel Tolerance() {
  const std::vector<GraspCandidate> candidates = Candidates();
  ToleranceModel model =
      EmptyToleranceModel(*EasyCube()[0], kGripper, {candidates[0].X_OG, candidates[1].X_OG});
  for (size_t i = 0; i < model.weights.size(); ++i) {
    model.weights[i] = i == 0 ? 3 : -0.25 * static_cast<double>(i % 4);
  }
  model.symmetries_O.discrete_O = {
      MakePose(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
               Eigen::Vector3d::Zero())};
  return model;
}

void ReadTolerance(const fs::path& file) {
  const auto model = LoadToleranceModels({file.string()}, EasyCube(), kGripper).at(0);
  for (const Pose& X_OG : model->X_OG) {
    RequireLaw(X_OG.matrix().allFinite() && X_OG.linear().isUnitary(1e-5), "a grasp has a pose");
  }
  for (const double error_m : {0.0, 0.002, 0.01}) {
    const double chance = SuccessProbability(*model, Translation({error_m, 0, error_m}));
    RequireLaw(chance >= 0 && chance <= 1, "a chance is a share");
  }
}

FuzzTarget ToleranceTarget() {
  return OneFile("tolerance_model", kToleranceModelFile, ReadTolerance, [] {
    return Contents{BytesOfFile(
        kToleranceModelFile, [](const fs::path& file) { WriteToleranceModel(file, Tolerance()); })};
  });
}

void ReadScores(const fs::path& file) {
  const ScoreCalibration calibration = ReadCalibration(file);
  double last = 0;
  for (const double score : {-1e300, -1.0, 0.0, 0.2, 0.5, 0.9, 1.0, 1e300}) {
    const double probability = calibration.pose_right.At(score);
    RequireLaw(probability >= last && probability <= 1, "a calibration rises to at most 1");
    last = probability;
  }
  RequireLaw(calibration.right <= calibration.poses && calibration.picked <= calibration.picks,
             "at most all poses are right, and at most all picks succeed");
}

FuzzTarget CalibrationTarget() {
  return OneFile("calibration", "calibration.yaml", ReadScores, [] {
    ScoreCalibration calibration;
    calibration.run = "results/a";
    calibration.estimator = "descriptor";
    calibration.mode = "accurate";
    calibration.bins = 20;
    calibration.poses = 70;
    calibration.right = 50;
    calibration.picks = 30;
    calibration.picked = 22;
    calibration.pose_right.knots = {{0.1, 0.05}, {0.4, 0.375}, {0.9, 0.97}};
    calibration.pick_succeeds.knots = {{0.2, 0.5}, {0.8, 0.75}};
    return Contents{WriteCalibration(calibration)};
  });
}

}  // namespace

std::vector<FuzzTarget> GraspTargets() {
  return {
      GraspsTarget("yaml"),
      GraspsTarget("csv"),
      ToleranceTarget(),
      CalibrationTarget(),
  };
}

}  // namespace pickbed::tests
