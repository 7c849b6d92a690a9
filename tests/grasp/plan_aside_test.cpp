#include <gtest/gtest.h>

#include "grasp/plan.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed {
namespace {

using Eigen::Vector3d;

// A cube with a wing beside where a finger of 20 mm comes down on its middle, 1.5 mm from it.
ObjectSet WingedCube() {
  auto model = std::make_shared<ObjectModel>(*BoxPart({0.05, 0.05, 0.05}, 0.2));
  const TriangleMesh wing = BoxMesh({0.02, 0.006, 0.05}, {0.035, -0.0145, 0});
  const int first = static_cast<int>(model->mesh_O.vertices.size());
  for (const Vector3d& p : wing.vertices) model->mesh_O.vertices.push_back(p);
  for (const Eigen::Vector3i& t : wing.triangles) {
    model->mesh_O.triangles.push_back(t + Eigen::Vector3i::Constant(first));
  }
  return {model};
}

// Grasps found of one candidate on the cube's middle, this far from the wall that y points at.
size_t GraspsBesideAWall(const ObjectSet& objects, double from_wall_m) {
  const Bin bin;
  GripperSpec gripper = SmallJaw();
  gripper.hand.palm_size_m.y() = 0.02;
  GraspCandidate middle;
  middle.X_OG = FromAbove({0, 0, -0.010});
  middle.width_m = 0.05;
  middle.depth_m = 0.010;
  middle.quality = 1;
  const std::vector<std::vector<GraspCandidate>> candidates{{middle}};
  const double y_m = 0.5 * bin.inner_size_m.y() - from_wall_m;
  const std::vector<BelievedPose> poses{{0, Translation({0, y_m, 0.025}), 1}};
  return PlanGrasps({bin, poses, candidates, {}, objects, gripper}).grasps.size();
}

// 9 mm from the wall the hand has to move 3 mm aside, into the wing; free of the wall it need not.
TEST(PlanAside, AHandIsNotMovedIntoItsOwnPart) {
  const ObjectSet plain{BoxPart({0.05, 0.05, 0.05}, 0.2)};
  EXPECT_EQ(GraspsBesideAWall(plain, 0.009), 1u);
  EXPECT_EQ(GraspsBesideAWall(WingedCube(), 0.06), 1u);
  EXPECT_EQ(GraspsBesideAWall(WingedCube(), 0.009), 0u);
}

}  // namespace
}  // namespace pickbed
