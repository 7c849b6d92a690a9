#pragma once

// Planner on estimated poses: plans in the bin that the cell assumes (grasp/plan/plan.h), with the
// observed points as obstacles.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "grasp/plan/plan.h"
#include "grasp/plan/planner.h"

namespace pickbed::grasp {

// Returns the observed points of every stride_px-th column and row in W.
std::vector<Eigen::Vector3d> ObservedPoints(const RgbdFrame& frame, const Pose& X_WC,
                                            int stride_px);

// Moves poses and points from the world to the frame of the bin.
void MoveToBin(const Pose& X_WB, std::vector<EstimatedPose>& poses,
               std::vector<Eigen::Vector3d>& cloud_W);

class PosePlanner : public Planner {
 public:
  explicit PosePlanner(const PlannerSetup& setup) : setup_(setup) {}

  // Throws InputError without a bin.
  PlanResult Plan(const PlannerInput& input) override;

  // Plans with other options as if the image showed these points only and hid nothing.
  PlanResult PlanAmong(const PlannerInput& input, std::vector<Eigen::Vector3d> cloud_W,
                       const PlanOptions& options) const;

 private:
  PlanResult PlanInBin(const PlannerInput& input, std::vector<Eigen::Vector3d> cloud_W,
                       const PlanOptions& options, bool knows_hidden) const;

  const PlannerSetup setup_;
};

}  // namespace pickbed::grasp
