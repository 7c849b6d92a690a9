#include "grasp/planners/program_planner.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::grasp {
namespace {

std::vector<PluginGripper> DescriptionsOf(
    std::span<const std::shared_ptr<const Gripper>> grippers) {
  std::vector<PluginGripper> descriptions;
  for (const auto& gripper : grippers) {
    descriptions.push_back({gripper->name, gripper->mechanism(), gripper->MaxOpening_m(),
                            gripper->approach_m, gripper->SettingsText()});
  }
  return descriptions;
}

PluginAddress AddressOf(const PlannerSetup& setup) {
  return {setup.spec.command, setup.spec.connect, setup.spec.timeout_s, setup.log_dir};
}

PluginSetup MessageOf(const PlannerSetup& setup, const ObjectSet& objects,
                      const std::vector<PluginGripper>& grippers) {
  PluginSetup message{objects};
  message.intrinsics = setup.intrinsics;
  message.working_distance_m = setup.working_distance_m;
  message.bin = setup.bin ? &*setup.bin : nullptr;
  message.grippers = grippers;
  return message;
}

}  // namespace

ProgramPlanner::ProgramPlanner(const PlannerSetup& setup, bool gives_poses)
    : gives_poses_(gives_poses),
      objects_(gives_poses ? setup.objects : ObjectSet()),
      grippers_(DescriptionsOf(setup.tools)),
      client_(AddressOf(setup), "planner", [&](MessageWriter& message) {
        WriteSetup(MessageOf(setup, objects_, grippers_), CacheDir() / kPluginMeshesFolder,
                   message);
      }) {}

void ProgramPlanner::RequireNeeds(const PlannerInput& input) const {
  const auto require = [&](const char* need, bool is_there, const char* reason) {
    const auto& needs = identity().needs;
    CheckInput(is_there || std::find(needs.begin(), needs.end(), need) == needs.end(),
               fmt::format("planner '{}' needs '{}'; {}", identity().name, need, reason));
  };
  require(kNeedsColor, !input.frame.color.empty(), "the images have no color");
  require(kNeedsBin, input.bin.has_value(), "the pose of the bin is unknown");
  require(kNeedsCounts, false, "planners do not get the number of instances");
}

// Returns the grasps, best first. Throws PluginError.
std::vector<Grasp> ProgramPlanner::Ask(const PlannerInput& input) {
  const Pose X_CW = input.X_WC.inverse();
  PluginFrame frame{input.frame};
  frame.X_WC = input.X_WC;
  if (input.bin) frame.X_CB = X_CW * input.bin->X_WB;
  frame.seed = input.seed;
  std::vector<PluginPose> poses;
  if (gives_poses_) {
    for (const EstimatedPose& pose : input.poses) {
      poses.push_back({pose.object, X_CW * pose.X_WO, pose.confidence});
    }
  }
  MessageWriter request;
  WritePlanGrasps(frame, objects_, gives_poses_ ? &poses : nullptr, request);
  std::vector<Grasp> grasps;
  for (const PluginGrasp& planned :
       ReadGrasps(client_.Ask(request), grippers_, static_cast<int>(poses.size()))) {
    Grasp& grasp = grasps.emplace_back();
    grasp.X_WG = planned.X_WG;
    grasp.width_m = planned.width_m;
    grasp.score = planned.score;
    grasp.hypothesis = gives_poses_ ? planned.pose : kNoHypothesis;
    grasp.tool = planned.gripper.empty() ? grippers_.front().name : planned.gripper;
  }
  std::stable_sort(grasps.begin(), grasps.end(),
                   [](const Grasp& a, const Grasp& b) { return a.score > b.score; });
  return grasps;
}

PlanResult ProgramPlanner::Plan(const PlannerInput& input) {
  RequireNeeds(input);
  PlanResult result;
  std::vector<Grasp> grasps;
  try {
    grasps = Ask(input);
  } catch (const PluginError& error) {
    const bool is_late = error.fault == PluginFault::kTimeout;
    result.failure = {is_late ? FailureReason::kPlannerTimeout : FailureReason::kPlannerCrashed,
                      fmt::format("planner '{}' {}", identity().name, error.what()),
                      error.traceback, error.fault == PluginFault::kMalformed};
    return result;
  }
  const auto is_target = [&](int pose) {
    return input.targets.empty() ||
           std::find(input.targets.begin(), input.targets.end(), pose) != input.targets.end();
  };
  for (Grasp& grasp : grasps) {
    if (gives_poses_ && grasp.hypothesis == kNoHypothesis) {
      ++result.rejected["names no pose"];
    } else if (gives_poses_ && !is_target(grasp.hypothesis)) {
      ++result.rejected["on another pose"];
    } else if (static_cast<int>(result.grasps.size()) == input.max_grasps) {
      ++result.rejected["outranked"];
    } else {
      result.grasps.push_back(std::move(grasp));
    }
  }
  return result;
}

}  // namespace pickbed::grasp
