#pragma once

// Draws the errors of a cell (scenes/scenario/cell_errors.h) and applies them. Each kind of error
// has its own random stream, so that one does not change another. A draw is the setting times a
// deviate that depends only on seed, bin and attempt: a sweep of the setting scales one error.
//
//     true camera C ---- hand-eye error ----> calibrated camera D, which the cell assumes
//          |                                          |
//        X_WC                                       X_WD
//          |                                          |
//     true world W <---------- robot ----------> true world W
//
//     true bin: its frame is W      assumed bin: frame B in W

#include <cstdint>
#include <optional>
#include <vector>

#include "eval/layer.h"
#include "grasp/execute/execute.h"
#include "grasp/grippers/tools.h"
#include "scenes/base/ids.h"
#include "scenes/camera/camera.h"
#include "scenes/image/image.h"
#include "scenes/scenario/cell_errors.h"
#include "scenes/scenario/scenario_spec.h"
#include "scenes/scene.h"

namespace pickbed::eval {

// Errors of one bin; all zero in an exact cell. Rotations are rotation vectors.
struct BinErrors {
  Eigen::Vector3d hand_eye_m = Eigen::Vector3d::Zero();             // origin of D in C
  Eigen::Vector3d hand_eye_rotation_rad = Eigen::Vector3d::Zero();  // of D in C
  double focal = 0;                                                 // share of the focal length
  Eigen::Vector2d principal_px = Eigen::Vector2d::Zero();
  double depth_bias_m = 0;
  double depth_scale = 0;                                      // share of the depth
  Eigen::Vector3d bin_m = Eigen::Vector3d::Zero();             // origin of B in W
  Eigen::Vector3d bin_rotation_rad = Eigen::Vector3d::Zero();  // of B in W
};

// Errors of one attempt; all zero in an exact cell.
struct AttemptErrors {
  Eigen::Vector3d robot_m = Eigen::Vector3d::Zero();  // executed minus planned grasp position, in W
  double force = 0;                                   // share of the gripper's force
};

BinErrors DrawBinErrors(const CellErrorsSpec& spec, uint64_t seed, BinIndex bin_index);
AttemptErrors DrawAttemptErrors(const CellErrorsSpec& spec, uint64_t seed, BinIndex bin_index,
                                int attempt);
InstanceDeviation DrawDeviation(const CellErrorsSpec& spec, uint64_t seed, BinIndex bin_index,
                                InstanceId instance);
// Returns the size deviation of the instances of each object in this bin, as a share: 0.01 = 1 %
// larger than CAD. Parts in a bin come from one batch, whose sizes deviate together by shrinkage
// and tool wear; so it is drawn per bin and object, not per instance.
std::vector<double> DrawSizes(const CellErrorsSpec& spec, uint64_t seed, BinIndex bin_index,
                              size_t objects);

// Returns the objects of the bin in their true sizes. The models keep their frames.
ObjectSet ObjectsOfSizes(const ObjectSet& objects, const std::vector<double>& sizes);

// The objects must fit into the bin and be light enough for one of the tools in the sizes that are
// drawn for the bins 0 .. spec.trials - 1. Throws InputError that names cell.size_percent. Nominal
// sizes are checked elsewhere.
void RequireSizesFit(const ScenarioSpec& spec, const ObjectSet& objects, const Tools& tools);

// What a cell assumes about its camera and its bin.
struct CellCalibration {
  Camera camera;             // intrinsics and X_WD
  std::optional<Pose> X_WB;  // pose of the bin; none = exactly W
  Pose X_BD() const;         // pose of the camera in the assumed bin
  // Returns the assumed background of an image.
  KnownBackground Background(const Bin& bin) const;
};
CellCalibration CalibrationOf(const Camera& camera, const BinErrors& errors);

// Adds the errors to depth readings: depth * (1 + depth_scale) + depth_bias_m. A reading that is
// not positive then becomes 0, no reading.
void AddDepthErrors(const BinErrors& errors, Image<float>& depth_m);

// Returns the pose that a perfect estimator reports for an object at X_CO: the point p_O of the
// object is where the erroneous image shows it, and the rotation is right. `intrinsics`: of the
// true camera.
Pose PoseInImage(const Pose& X_CO, const Eigen::Vector3d& p_O, const CameraIntrinsics& intrinsics,
                 const CameraIntrinsics& calibrated, const BinErrors& errors);

// The true scene of an attempt, and the objects in their true sizes.
struct TrueScene {
  const Scene& scene;
  const ObjectSet& objects;
};

// Executes the planned grasp with the errors of the attempt. The placement is planned from the
// planned grasp, because the cell does not know its errors. See ExecuteGrasp().
ExecuteResult ExecuteWithErrors(const TrueScene& truth, const Grasp& planned,
                                const Gripper& gripper, const GraspTarget& target,
                                const ExecuteOptions& options, const AttemptErrors& errors,
                                const MotionListener& on_step = {});

}  // namespace pickbed::eval
