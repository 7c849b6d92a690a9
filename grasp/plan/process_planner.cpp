#include "grasp/plan/process_planner.h"

#include <fmt/format.h>

#include <algorithm>

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

PluginSetup MessageOf(const ProcessPlannerSetup& setup, const ObjectSet& objects,
                      const std::vector<PluginGripper>& grippers) {
  PluginSetup message{objects};
  message.intrinsics = setup.intrinsics;
  message.working_distance_m = setup.working_distance_m;
  message.bin = setup.bin ? &*setup.bin : nullptr;
  message.grippers = grippers;
  return message;
}

}  // namespace

ProcessPlanner::ProcessPlanner(const ProcessPlannerSetup& setup)
    : objects_(setup.objects),
      grippers_(DescriptionsOf(setup.grippers)),
      client_(setup.address, "planner", [&](MessageWriter& message) {
        WriteSetup(MessageOf(setup, objects_, grippers_), setup.mesh_dir, message);
      }) {}

ProcessPlan ProcessPlanner::Plan(const ProcessPlannerInput& input) {
  const Pose X_CW = input.X_WC.inverse();
  PluginFrame frame{input.frame};
  frame.X_WC = input.X_WC;
  frame.X_CB = input.X_WB ? X_CW * *input.X_WB : X_CW;
  frame.seed = input.seed;
  std::vector<PluginPose> poses;
  if (input.poses) {
    for (const EstimatedPose& pose : *input.poses) {
      poses.push_back({pose.object, X_CW * pose.X_WO, pose.confidence});
    }
  }
  MessageWriter request;
  WritePlanGrasps(frame, objects_, input.poses ? &poses : nullptr, request);
  ProcessPlan plan;
  try {
    for (PluginGrasp& planned :
         ReadGrasps(client_.Ask(request), grippers_, static_cast<int>(poses.size()))) {
      Grasp& grasp = plan.grasps.emplace_back();
      grasp.X_WG = planned.X_WG;
      grasp.width_m = planned.width_m;
      grasp.score = planned.score;
      grasp.hypothesis = planned.pose;
      grasp.tool = planned.gripper.empty() ? grippers_.front().name : planned.gripper;
    }
  } catch (const PluginError& error) {
    plan.fault = error.fault;
    plan.text = fmt::format("planner '{}' {}", client_.identity().name, error.what());
    plan.traceback = error.traceback;
  }
  std::stable_sort(plan.grasps.begin(), plan.grasps.end(),
                   [](const Grasp& a, const Grasp& b) { return a.score > b.score; });
  return plan;
}

}  // namespace pickbed::grasp
