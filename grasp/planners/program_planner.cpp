#include "grasp/planners/program_planner.h"

#include <algorithm>

#include "scenes/base/files.h"
#include "scenes/plugin/plugin_messages.h"

namespace pickbed::grasp {
namespace {

ProcessPlannerSetup ProgramOf(const PlannerSetup& setup, bool gives_poses) {
  ProcessPlannerSetup program;
  const PlannerSpec& spec = setup.spec;
  program.address = {spec.command, spec.connect, spec.timeout_s, setup.log_dir};
  if (gives_poses) program.objects = setup.objects;
  program.grippers = setup.tools;
  program.intrinsics = setup.intrinsics;
  program.working_distance_m = setup.working_distance_m;
  program.bin = setup.bin;
  program.mesh_dir = CacheDir() / kPluginMeshesFolder;
  return program;
}

}  // namespace

ProgramPlanner::ProgramPlanner(const PlannerSetup& setup, bool gives_poses)
    : gives_poses_(gives_poses), program_(ProgramOf(setup, gives_poses)) {}

PlanResult ProgramPlanner::Plan(const PlannerInput& input) {
  ProcessPlannerInput request{input.frame, input.X_WC};
  if (input.bin) request.X_WB = input.bin->X_WB;
  if (gives_poses_) request.poses = input.poses;
  request.seed = input.seed;
  ProcessPlan plan = program_.Plan(request);

  PlanResult result;
  if (plan.fault) {
    const bool is_late = *plan.fault == PluginFault::kTimeout;
    result.failure = {is_late ? FailureReason::kPlannerTimeout : FailureReason::kPlannerCrashed,
                      std::move(plan.text), std::move(plan.traceback)};
    return result;
  }
  const auto is_target = [&](int pose) {
    return input.targets.empty() ||
           std::find(input.targets.begin(), input.targets.end(), pose) != input.targets.end();
  };
  for (Grasp& grasp : plan.grasps) {
    if (!gives_poses_) grasp.hypothesis = kNoHypothesis;
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
