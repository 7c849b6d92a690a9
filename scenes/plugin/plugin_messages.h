#pragma once

// The messages of the plug-in protocol: what pickbed sends, and the checks of what it gets.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenes/base/ids.h"
#include "scenes/bin/bin.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/objects/object_model.h"
#include "scenes/plugin/message.h"
#include "scenes/plugin/plugin_client.h"

namespace pickbed::scenes {

// The gripper of a planner. Frame G is drawn in grasp/gripper.h.
struct PluginGripper {
  std::string name;
  std::string mechanism;  // "parallel_jaw", "suction_cup"
  double max_opening_m = 0;
  double approach_m = 0;
  std::string settings = {};  // all settings as YAML
};

// Content of the message "setup". References must outlive the client.
struct PluginSetup {
  const ObjectSet& objects;
  CameraIntrinsics intrinsics = {};
  double working_distance_m = 0;             // camera to objects
  const Bin* bin = nullptr;                  // null: unknown
  double min_score = 0;                      // poses with a lower score are not used
  std::string model = {};                    // the setting estimator.model
  std::string mode = {};                     // the setting estimator.mode
  std::vector<PluginGripper> grippers = {};  // of a planner
};
// Folder in the cache for the meshes.
inline constexpr char kPluginMeshesFolder[] = "plugin_meshes";

// Writes the message. Writes the mesh of each object in metres as an OBJ file into `mesh_dir`,
// unless it is there. Throws InputError if a file cannot be written.
void WriteSetup(const PluginSetup& setup, const std::filesystem::path& mesh_dir,
                MessageWriter& message);

// A pose for the planner.
struct PluginPose {
  ObjectId object{0};
  Pose X_CO = Pose::Identity();
  double score = 0;
};

// Content of the messages "estimate" and "plan_grasps". References must outlive the message.
struct PluginFrame {
  const RgbdFrame& frame;
  std::optional<Pose> X_WC = {};     // none: unknown
  std::optional<Pose> X_CB = {};     // pose of the bin; none: unknown
  std::span<const int> counts = {};  // number of instances by object; empty = unknown
  uint64_t seed = 0;
};
void WriteEstimate(const PluginFrame& frame, const ObjectSet& objects, MessageWriter& message);
// `poses` are in C; null: not estimated.
void WritePlanGrasps(const PluginFrame& frame, const ObjectSet& objects,
                     const std::vector<PluginPose>* poses, MessageWriter& message);

// Maximum number of poses or grasps of one answer.
inline constexpr size_t kMaxPluginItems = 10000;

// Which scores of poses are accepted.
enum class PluginScores {
  kProbabilities,  // 0 to 1
  kAny             // any finite number; higher is better
};

// Reads the answer to "estimate". Checks each pose: known object, proper rotation, finite numbers,
// score as in `scores`, and a distance that fits `working_distance_m`. A rotation that is nearly
// orthonormal is corrected (ProperRotation() in scenes/geometry/pose.h). Throws PluginError with
// kMalformed, which names the pose and what to correct. With `faults`, adds the texts of these
// errors to it instead, and returns the other poses.
std::vector<PluginPose> ReadPoses(const MessageValue& answer, const ObjectSet& objects,
                                  double working_distance_m,
                                  std::vector<std::string>* faults = nullptr,
                                  PluginScores scores = PluginScores::kProbabilities);

// A planned grasp in the world.
struct PluginGrasp {
  Pose X_WG = Pose::Identity();
  double width_m = 0;
  double score = 0;     // any finite number; higher is better
  std::string gripper;  // empty: the first one
  int pose = -1;        // index into the poses of the request; -1 = none
};
// Reads the answer to "plan_grasps". Checks rotation, numbers, gripper, pose index and width.
// Throws PluginError with kMalformed. `faults`: as for ReadPoses().
std::vector<PluginGrasp> ReadGrasps(const MessageValue& answer,
                                    std::span<const PluginGripper> grippers, int poses,
                                    std::vector<std::string>* faults = nullptr);

}  // namespace pickbed::scenes
