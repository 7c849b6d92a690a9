#include "grasp/execute/stir.h"

#include <gtest/gtest.h>

#include "grasp/candidates/antipodal.h"
#include "grasp/plan/clearance.h"
#include "grasp/plan/plan.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// A plate of 60 x 60 x 12 mm. Flat on the floor, only its long sides of 60 mm can be grasped.
class Stir : public testing::Test {
 protected:
  static constexpr double kSide_m = 0.06, kThickness_m = 0.012;

  static Scene LeaningAtTheCenter(double lean_rad) {
    Scene scene = BoxesOnFloor({{0, 0}}, kSide_m);
    const double half_m = 0.5 * kSide_m, thin_m = 0.5 * kThickness_m;
    scene.objects[0].X_WO =
        MakePose(Eigen::AngleAxisd(lean_rad, Vector3d::UnitY()).toRotationMatrix(),
                 {0, 0, half_m * std::cos(lean_rad) + thin_m * std::sin(lean_rad) + 0.001});
    return scene;
  }

  ParallelJaw gripper_ = SmallJaw();
  ObjectSet objects_{BoxObject({kThickness_m, kSide_m, kSide_m}, 0.1)};
};

// Paths alternate; each stays off the walls and the floor, and meets the only instance.
TEST_F(Stir, PathsStayInTheBinAndMeetTheInstances) {
  const Scene scene = LeaningAtTheCenter(0);
  for (int number = 0; number < 8; ++number) {
    const StirPath path = PlanStir(scene, objects_, gripper_, number);
    const Vector3d from = path.X_WG_from.translation(), to = path.X_WG_to.translation();
    EXPECT_LT((from + to).head<2>().norm(), 1e-9) << "the instance is in the center";
    EXPECT_GT((to - from).norm(), 0.1) << number;
    EXPECT_GT(from.z(), 0);
    EXPECT_LT(from.z(), kSide_m) << "the tips are below the highest instance";
    for (const Pose& X_WG : {path.X_WG_from, path.X_WG_to}) {
      EXPECT_FALSE(FindBinContact(gripper_.Boxes(0), X_WG, BinBoxes(scene.bin), 0.004)) << number;
    }
    const StirPath next = PlanStir(scene, objects_, gripper_, number + 1);
    EXPECT_FALSE(next.X_WG_to.isApprox(path.X_WG_to)) << number;
  }
}

// The path along the bin follows the instances to the wall.
TEST_F(Stir, PathGoesWhereMostInstancesAre) {
  const Scene scene = BoxesOnFloor({{-0.1, 0.12}, {0, 0.12}, {0.1, 0.12}, {0.05, -0.05}}, kSide_m);
  const StirPath path = PlanStir(scene, objects_, gripper_, 0);
  EXPECT_GT(path.X_WG_from.translation().y(), 0.05);
  EXPECT_EQ(path.X_WG_from.translation().y(), path.X_WG_to.translation().y());
  EXPECT_LT(path.X_WG_from.translation().x(), path.X_WG_to.translation().x());
}

// Nine cubes in a tight block: no finger fits beside any of them. The stir breaks the block up.
TEST_F(Stir, TightBlockBecomesGraspable) {
  constexpr double kCube_m = 0.03;
  const ObjectSet cubes{BoxObject({kCube_m, kCube_m, kCube_m}, 0.1)};
  Rng rng(1);
  const std::vector<std::vector<GraspCandidate>> candidates{AntipodalGrasps(
      *cubes[0], gripper_.hand, gripper_.clearance_m, rng, {.candidates = 400, .max_pairs = 200})};
  const auto graspable = [&](const Scene& scene) {
    std::vector<EstimatedPose> poses;
    for (const PosedObject& posed : scene.objects) poses.push_back({posed.object, posed.X_WO});
    return !PlanGrasps({scene.bin, poses, candidates, {}, cubes, gripper_}).grasps.empty();
  };
  std::vector<Eigen::Vector2d> places_m;
  for (int i = 0; i < 9; ++i) {
    places_m.push_back((kCube_m + 0.0005) * Eigen::Vector2d(i / 3 - 1, i % 3 - 1));
  }
  const Scene scene = BoxesOnFloor(places_m, kCube_m);
  EXPECT_FALSE(graspable(scene));
  const ExecuteResult stirred = StirBin(scene, cubes, gripper_, 0);
  EXPECT_EQ(FailureName(stirred.outcome.failure), "stirred");
  EXPECT_FALSE(stirred.outcome.success);
  EXPECT_GT(stirred.outcome.neighbors_displaced, 0);
  EXPECT_EQ(stirred.after.objects.size(), 9u);
  EXPECT_TRUE(graspable(stirred.after));
}

TEST_F(Stir, EqualInputsGiveEqualBytes) {
  const Scene scene = LeaningAtTheCenter(0.05);
  const Scene a = StirBin(scene, objects_, gripper_, 0).after;
  const Scene b = StirBin(scene, objects_, gripper_, 0).after;
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (size_t i = 0; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].X_WO.matrix(), b.objects[i].X_WO.matrix());
    EXPECT_NE(a.objects[i].X_WO.matrix(), scene.objects[i].X_WO.matrix());
  }
}

}  // namespace
}  // namespace pickbed::tests
