#include "grasp/execute/stir.h"

#include <gtest/gtest.h>

#include "grasp/candidates/antipodal.h"
#include "grasp/plan/plan.h"
#include "grasp/plan/plan_stir.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// A cube of 30 mm.
constexpr double kCube_m = 0.03;

class Stir : public testing::Test {
 protected:
  ParallelJaw gripper_ = SmallJaw();
  ObjectSet cubes_{BoxObject({kCube_m, kCube_m, kCube_m}, 0.1)};

  // Along x through the center, with the tips 1 cm above the floor.
  static StirPath AlongTheBin() {
    Eigen::Matrix3d R_WG;
    R_WG.col(1) = Vector3d::UnitX();
    R_WG.col(2) = -Vector3d::UnitZ();
    R_WG.col(0) = R_WG.col(1).cross(R_WG.col(2));
    return {MakePose(R_WG, {-0.15, 0, 0.01}), MakePose(R_WG, {0.15, 0, 0.01}), 0.15};
  }
};

// Nine cubes in a tight block: no finger fits beside any of them. The stir breaks the block up.
TEST_F(Stir, TightBlockBecomesGraspable) {
  Rng rng(1);
  const std::vector<std::vector<GraspCandidate>> candidates{AntipodalGrasps(
      *cubes_[0], gripper_.hand, gripper_.clearance_m, rng, {.candidates = 400, .max_pairs = 200})};
  const auto graspable = [&](const Scene& scene) {
    std::vector<EstimatedPose> poses;
    for (const PosedObject& posed : scene.objects) poses.push_back({posed.object, posed.X_WO});
    return !PlanGrasps({scene.bin, poses, candidates, {}, cubes_, gripper_}).grasps.empty();
  };
  std::vector<Eigen::Vector2d> places_m;
  for (int i = 0; i < 9; ++i) {
    places_m.push_back((kCube_m + 0.0005) * Eigen::Vector2d(i / 3 - 1, i % 3 - 1));
  }
  const Scene scene = BoxesOnFloor(places_m, kCube_m);
  EXPECT_FALSE(graspable(scene));
  const ExecuteResult stirred = StirBin(scene, cubes_, gripper_, AlongTheBin());
  EXPECT_EQ(FailureName(stirred.outcome.failure), "stirred");
  EXPECT_FALSE(stirred.outcome.success);
  EXPECT_GT(stirred.outcome.neighbors_displaced, 0);
  // A finger that presses on the edge of a cube can make it jump over the wall. In 41 stirs at
  // other places, this happened to 3 of 369 cubes.
  EXPECT_GE(stirred.after.objects.size(), 8u);
  EXPECT_TRUE(graspable(stirred.after));
}

// A cube that touches a wall or two. The planned drag moves it to where a finger fits beside it.
TEST_F(Stir, DragFreesACubeAtAWall) {
  gripper_.hand.finger_size_m.z() = 0.2;  // the palm stays above the walls
  const double side = 0.5 * kCube_m + 0.0005;
  for (const Eigen::Vector2d& place :
       {Eigen::Vector2d(0.2 - side, 0.03), Eigen::Vector2d(side - 0.2, 0.15 - side)}) {
    const Scene scene = BoxesOnFloor({place}, kCube_m);
    std::vector<Vector3d> top_W;
    for (int i = 0; i < 225; ++i) {
      const Eigen::Vector2d offset = 0.002 * Eigen::Vector2d(i / 15 - 7, i % 15 - 7);
      top_W.emplace_back(place.x() + offset.x(), place.y() + offset.y(), kCube_m);
    }
    const StirPath path = PlanStir(scene.bin, top_W, gripper_, 0);
    const Scene after = StirBin(scene, cubes_, gripper_, path).after;
    ASSERT_EQ(after.objects.size(), 1u);
    const Vector3d center = after.objects[0].X_WO.translation();
    EXPECT_LT(std::abs(center.x()), 0.2 - side - 0.03);
    EXPECT_LT(std::abs(center.y()), 0.15 - side - 0.03);
  }
}

TEST_F(Stir, EqualInputsGiveEqualBytes) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kCube_m);
  const Scene a = StirBin(scene, cubes_, gripper_, AlongTheBin()).after;
  const Scene b = StirBin(scene, cubes_, gripper_, AlongTheBin()).after;
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (size_t i = 0; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].X_WO.matrix(), b.objects[i].X_WO.matrix());
    EXPECT_NE(a.objects[i].X_WO.matrix(), scene.objects[i].X_WO.matrix());
  }
}

}  // namespace
}  // namespace pickbed::tests
