#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "grasp/candidates/antipodal.h"
#include "grasp/plan/plan.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {

// Plans grasps of 5 cm cubes in a bin, at the poses that a test adds.

class PlanFixture : public testing::Test {
 protected:
  PlanFixture() : candidates_{BoxGrasps()} {}

  // Computed once, because they take longer than all plans.
  static const std::vector<GraspCandidate>& BoxGrasps() {
    static const auto grasps = [] {
      Rng rng(1);
      const ParallelJaw jaw = SmallJaw();
      return AntipodalGrasps(*BoxObject({0.05, 0.05, 0.05}, 0.2), jaw.hand, jaw.clearance_m, rng,
                             {.candidates = 400, .max_pairs = 200});
    }();
    return grasps;
  }

  void AddPose(const Eigen::Vector3d& p_W, double confidence = 1) {
    poses_.push_back({ObjectId{0}, Translation(p_W), confidence});
  }

  PlanResult Run(const PlanOptions& options = {}) const {
    return PlanGrasps(
        {bin_, poses_, candidates_, cloud_, objects_, *selected_gripper_, {}, hidden_}, options);
  }

  int Rejected(const PlanResult& result) const {
    return std::accumulate(result.rejected.begin(), result.rejected.end(), 0,
                           [](int sum, const auto& entry) { return sum + entry.second; });
  }

  // Adds points of an upright cylinder around the origin.
  void AddRing(double radius_m, double height_m) {
    for (int step = 0; step < 180; ++step) {
      const double angle = step * std::numbers::pi / 90;
      for (double z = 0.01; z < height_m; z += 0.002) {
        cloud_.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), z);
      }
    }
  }

  Bin bin_;
  ParallelJaw gripper_ = SmallJaw();
  const Gripper* selected_gripper_ = &gripper_;
  ObjectSet objects_{BoxObject({0.05, 0.05, 0.05}, 0.2)};
  std::vector<std::vector<GraspCandidate>> candidates_;
  std::vector<EstimatedPose> poses_;
  std::vector<Eigen::Vector3d> cloud_;
  const HiddenSpace* hidden_ = nullptr;
};
}  // namespace pickbed::tests
