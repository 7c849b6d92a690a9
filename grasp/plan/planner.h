#pragma once

// Interface of a grasp planner. Each planner is one class and one row of the table in
// grasp/planners/table.cpp. A planner works on estimated poses, or on the image only.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "grasp/plan/plan.h"
#include "scenes/bin/bin.h"
#include "scenes/camera/camera.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/scenario/planner_spec.h"

namespace pickbed::grasp {

// A bin and its pose in the world. The bin must outlive it, so a temporary one is refused.
struct BinPlacement {
  BinPlacement(const Bin& the_bin, const Pose& the_X_WB = Pose::Identity())
      : bin(the_bin), X_WB(the_X_WB) {}
  BinPlacement(Bin&&, const Pose& = Pose::Identity()) = delete;

  const Bin& bin;
  Pose X_WB;
};

// What a planner gets for one image. References must outlive the call. It never contains ground
// truth.
struct PlannerInput {
  const RgbdFrame& frame;
  Pose X_WC = Pose::Identity();               // pose of the camera, as calibrated
  std::optional<BinPlacement> bin;            // none = unknown
  std::span<const EstimatedPose> poses = {};  // in W; empty for planners without poses
  std::span<const int> targets = {};          // indices of poses that may be grasped; empty = all
  int max_grasps = 5;                         // maximum number of returned grasps
  uint64_t seed = 0;                          // of planners with random choices
};

// Plans grasps in the world.
class Planner {
 public:
  virtual ~Planner() = default;
  // Returns grasps in W, best first, each with the name of its gripper, and the numbers of rejected
  // candidates by cause. An empty list is a result. A planner without poses sets
  // Grasp::hypothesis to kNoHypothesis. Equal inputs give equal grasps.
  virtual PlanResult Plan(const PlannerInput& input) = 0;
};

class ShapeSource;      // grasp/completed/occupancy_shape.h
struct SuccessNetwork;  // grasp/completed/success_network.h

// What a planner is made of. References must outlive the planner.
struct PlannerSetup {
  PlannerSpec spec;
  const std::vector<std::shared_ptr<const Gripper>>& tools;
  // Only for planners on poses; empty for others.
  const ObjectSet& objects;
  const std::vector<std::vector<std::vector<GraspCandidate>>>& candidates;  // by tool and object
  PlanOptions options;      // ranking and limits of the planner on poses
  int cloud_stride_px = 2;  // step of the observed points that it keeps clear of
  // Only for planners that are programs.
  CameraIntrinsics intrinsics = {};
  double working_distance_m = 0.85;    // camera to objects
  std::optional<Bin> bin = {};         // none = unknown
  std::filesystem::path log_dir = {};  // for the standard error of the program; empty = no file
  // Only for planners on completed shapes.
  ShapeSource* shapes = nullptr;
  std::shared_ptr<const SuccessNetwork> network = nullptr;  // of jaws; null: a logistic function
};

}  // namespace pickbed::grasp
