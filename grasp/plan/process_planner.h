#pragma once

// Grasps planned by another program, in any language: a child process or a server (scenes/plugin).
// The program gets the image, and the estimated poses if there are any.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "grasp/plan/plan.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/objects/object_model.h"
#include "scenes/plugin/plugin_client.h"
#include "scenes/plugin/plugin_messages.h"

namespace pickbed::grasp {

// What the program knows before the first image.
struct ProcessPlannerSetup {
  PluginAddress address;
  ObjectSet objects;
  std::vector<std::shared_ptr<const Gripper>> grippers;  // at least one
  CameraIntrinsics intrinsics;
  double working_distance_m = 0.85;  // camera to objects
  std::optional<Bin> bin = {};
  std::filesystem::path mesh_dir;  // for the meshes of the objects
};

// Input for one image. References must outlive the call.
struct ProcessPlannerInput {
  const RgbdFrame& frame;
  Pose X_WC = Pose::Identity();
  std::optional<Pose> X_WB = {};                             // pose of the bin; none: equal to W
  std::optional<std::span<const EstimatedPose>> poses = {};  // none: not estimated
  uint64_t seed = 0;
};

// Result for one image.
struct ProcessPlan {
  // Best first. `hypothesis` is -1 for a grasp without a pose; `tool` is always set.
  std::vector<Grasp> grasps;
  std::optional<PluginFault> fault = {};  // why there are no grasps
  std::string text;                       // one line about the fault
  std::vector<std::string> traceback;     // the program's own report, by line
};

class ProcessPlanner {
 public:
  // Starts the program. Throws InputError as PluginClient() does.
  explicit ProcessPlanner(const ProcessPlannerSetup& setup);

  // Plans for one image. A program that failed is started again by the next call.
  ProcessPlan Plan(const ProcessPlannerInput& input);

  const PluginIdentity& identity() const { return client_.identity(); }

 private:
  ObjectSet objects_;                    // the setup message refers to them
  std::vector<PluginGripper> grippers_;  // as the program knows them
  PluginClient client_;
};

}  // namespace pickbed::grasp
