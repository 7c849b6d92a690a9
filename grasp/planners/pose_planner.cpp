#include "grasp/planners/pose_planner.h"

#include "scenes/base/error.h"
#include "scenes/camera/depth_points.h"

namespace pickbed::grasp {

std::vector<Eigen::Vector3d> ObservedPoints(const RgbdFrame& frame, const Pose& X_WC,
                                            int stride_px) {
  std::vector<Eigen::Vector3d> points_W;
  ForEachDepthPoint(
      frame.intrinsics, frame.depth_m,
      [&](int, int, const Eigen::Vector3d& p_C) { points_W.push_back(X_WC * p_C); }, stride_px);
  return points_W;
}

void MoveToBin(const Pose& X_WB, std::vector<EstimatedPose>& poses,
               std::vector<Eigen::Vector3d>& cloud_W) {
  const Pose X_BW = X_WB.inverse();
  for (EstimatedPose& pose : poses) pose.X_WO = X_BW * pose.X_WO;
  for (Eigen::Vector3d& point : cloud_W) point = X_BW * point;
}

PlanResult PosePlanner::Plan(const PlannerInput& input) {
  PlanOptions options = setup_.options;
  options.max_grasps = input.max_grasps;
  options.seed = input.seed;
  return PlanInBin(input, ObservedPoints(input.frame, input.X_WC, setup_.cloud_stride_px), options,
                   /*knows_hidden=*/true);
}

PlanResult PosePlanner::PlanAmong(const PlannerInput& input, std::vector<Eigen::Vector3d> cloud_W,
                                  const PlanOptions& options) const {
  return PlanInBin(input, std::move(cloud_W), options, /*knows_hidden=*/false);
}

PlanResult PosePlanner::PlanInBin(const PlannerInput& input, std::vector<Eigen::Vector3d> cloud_W,
                                  const PlanOptions& options, bool knows_hidden) const {
  CheckInput(input.bin.has_value(), "planner poses needs a known bin");
  const Pose& X_WB = input.bin->X_WB;
  // No pose is multiplied by the identity, so that results without cell errors keep their bytes.
  const bool moved = X_WB.matrix() != Pose::Identity().matrix();
  std::vector<EstimatedPose> poses(input.poses.begin(), input.poses.end());
  if (moved) MoveToBin(X_WB, poses, cloud_W);
  std::optional<HiddenSpace> hidden;
  if (knows_hidden) {
    const Pose X_CW = input.X_WC.inverse();
    hidden.emplace(input.frame.depth_m, input.frame.intrinsics, moved ? X_CW * X_WB : X_CW,
                   options.hidden_behind_m);
  }
  std::vector<PlanInput> inputs;
  for (size_t k = 0; k < setup_.tools.size(); ++k) {
    inputs.push_back({input.bin->bin, poses, setup_.candidates[k], cloud_W, setup_.objects,
                      *setup_.tools[k], input.targets, hidden ? &*hidden : nullptr});
  }
  PlanResult plan = PlanWithTools(inputs, options);
  if (!moved) return plan;
  const Eigen::Matrix2d R_WB = X_WB.linear().topLeftCorner<2, 2>();
  for (Grasp& grasp : plan.grasps) {
    grasp.X_WG = X_WB * grasp.X_WG;
    grasp.lift_aside_m = R_WB * grasp.lift_aside_m;
  }
  return plan;
}

}  // namespace pickbed::grasp
