#include <gtest/gtest.h>

#include "grasp/plan/plan.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// A cube with a wing, 1.5 mm beside the place where a finger of 20 mm touches its center.
ObjectSet WingedCube() {
  auto model = std::make_shared<ObjectModel>(*BoxObject({0.05, 0.05, 0.05}, 0.2));
  const TriangleMesh wing = BoxMesh({0.02, 0.006, 0.05}, {0.035, -0.0145, 0});
  const int first = static_cast<int>(model->mesh_O.vertices.size());
  for (const Vector3d& p : wing.vertices) model->mesh_O.vertices.push_back(p);
  for (const Eigen::Vector3i& t : wing.triangles) {
    model->mesh_O.triangles.push_back(t + Eigen::Vector3i::Constant(first));
  }
  return {model};
}

// Returns the number of planned grasps for one candidate at the center of the cube, `from_wall_m`
// from the wall at +y.
size_t GraspsBesideAWall(const ObjectSet& objects, double from_wall_m) {
  const Bin bin;
  ParallelJaw gripper = SmallJaw();
  gripper.hand.palm_size_m.y() = 0.02;
  GraspCandidate center;
  center.X_OG = FromAbove({0, 0, -0.010});
  center.width_m = 0.05;
  center.depth_m = 0.010;
  center.quality = 1;
  const std::vector<std::vector<GraspCandidate>> candidates{{center}};
  const double y_m = 0.5 * bin.inner_size_m.y() - from_wall_m;
  const std::vector<EstimatedPose> poses{{ObjectId{0}, Translation({0, y_m, 0.025}), 1}};
  return PlanGrasps({bin, poses, candidates, {}, objects, gripper}).grasps.size();
}

// At 9 mm from the wall the hand must shift by 3 mm, into the wing. Far from the wall it need not.
TEST(PlanAside, HandIsNotShiftedIntoItsTarget) {
  const ObjectSet plain{BoxObject({0.05, 0.05, 0.05}, 0.2)};
  EXPECT_EQ(GraspsBesideAWall(plain, 0.009), 1u);
  EXPECT_EQ(GraspsBesideAWall(WingedCube(), 0.06), 1u);
  EXPECT_EQ(GraspsBesideAWall(WingedCube(), 0.009), 0u);
}

}  // namespace
}  // namespace pickbed::tests
