// Executed grasps, stirs and settling in degenerate scenes: no instance, instances inside of each
// other, foils, hands far away, and poses that are not numbers.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "grasp/execute/execute.h"
#include "grasp/execute/settle.h"
#include "grasp/execute/stir.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kCubeSide_m = 0.04;
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

ObjectSet Cubes() { return {BoxObject({kCubeSide_m, kCubeSide_m, kCubeSide_m}, 0.1)}; }

Grasp DownTo(const Vector3d& tips_W, double width_m = kCubeSide_m) {
  Grasp grasp;
  grasp.X_WG = FromAbove(tips_W);
  grasp.width_m = width_m;
  return grasp;
}

ExecuteResult Executed(const Scene& scene, const Grasp& grasp, const ObjectSet& objects = Cubes(),
                       InstanceId target = InstanceId{10}) {
  return ExecuteGrasp(scene, objects, grasp, SmallJaw(), target);
}

void ExpectSound(const ExecuteResult& result, const std::string& name) {
  const GraspOutcome& o = result.outcome;
  for (const double value : {o.slip_m, o.in_hand_rotation_error_rad, o.final_opening_m,
                             o.lift_height_m, o.retreat_opening, o.place_error_m}) {
    EXPECT_TRUE(std::isfinite(value)) << name;
  }
  for (const PosedObject& posed : result.after.objects) {
    EXPECT_TRUE(posed.X_WO.matrix().allFinite()) << name;
    EXPECT_TRUE(result.after.bin.Holds(posed.X_WO.translation())) << name;
  }
}

TEST(DegenerateExecute, AHandFarAwayMeetsNothing) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kCubeSide_m);
  for (const double distance_m : {10.0, 1e4, 1e6}) {
    const ExecuteResult result = Executed(scene, DownTo({distance_m, 0, 0.3}));
    EXPECT_EQ(FailureName(result.outcome.failure), FailureName(FailureReason::kClosedOnNothing))
        << distance_m;
    ASSERT_EQ(result.after.objects.size(), 1u);
    EXPECT_LT(
        (result.after.objects[0].X_WO.translation() - scene.objects[0].X_WO.translation()).norm(),
        0.001);
    ExpectSound(result, "far away");
  }
}

TEST(DegenerateExecute, InstancesInsideOfEachOtherComeApart) {
  for (const int count : {2, 5}) {
    const Scene scene =
        BoxesOnFloor(std::vector<Eigen::Vector2d>(count, Eigen::Vector2d::Zero()), kCubeSide_m);
    const ExecuteResult result = Executed(scene, DownTo({0, 0, 0.015}));
    ExpectSound(result, std::to_string(count));
    const std::vector<PosedObject>& after = result.after.objects;
    EXPECT_LE(after.size(), static_cast<size_t>(count));
    // Solid cubes end beside or on top of each other.
    for (size_t i = 0; i < after.size(); ++i) {
      for (size_t k = 0; k < i; ++k) {
        const double distance_m =
            (after[i].X_WO.translation() - after[k].X_WO.translation()).norm();
        EXPECT_GT(distance_m, 0.9 * kCubeSide_m) << count << " cubes, " << k << " and " << i;
      }
    }
  }
}

TEST(DegenerateExecute, OpeningsOutsideOfTheStrokeAreTheNearestOnes) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kCubeSide_m);
  const ExecuteResult widest = Executed(scene, DownTo({0, 0, 0.015}, 1e3));
  EXPECT_TRUE(widest.outcome.success);
  // Closed fingers come down on top of the cube.
  for (const double width_m : {0.0, -1.0}) {
    const ExecuteResult result = Executed(scene, DownTo({0, 0, 0.015}, width_m));
    EXPECT_FALSE(result.outcome.success) << width_m;
    ExpectSound(result, "closed");
  }
}

TEST(DegenerateExecute, AFoilOrANeedleEndsInAResult) {
  for (const Vector3d& size_m : {Vector3d(0.06, 0.06, 2e-5), Vector3d(0.06, 1e-4, 1e-4)}) {
    const ObjectSet objects{BoxObject(size_m, 0.001)};
    const ExecuteResult result =
        Executed(BoxesOnFloor({{0, 0}}, size_m.z()), DownTo({0, 0, 0.002}), objects);
    ExpectSound(result, "thin");
  }
}

TEST(DegenerateExecute, PosesThatAreNotNumbersAreRefused) {
  const Scene scene = BoxesOnFloor({{0, 0}}, kCubeSide_m);
  for (const double value : {kNotANumber, std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(ErrorOf([&] {
                  Executed(scene, DownTo({0, value, 0.1}));
                }),
                testing::HasSubstr("the pose or width of the grasp is not finite"));
    EXPECT_THAT(ErrorOf([&] {
                  Executed(scene, DownTo({0, 0, 0.1}, value));
                }),
                testing::HasSubstr("the pose or width of the grasp is not finite"));
    const StirPath path{FromAbove({value, 0, 0.01}), FromAbove({0, 0, 0.01}), 0.1};
    EXPECT_THAT(ErrorOf([&] { StirBin(scene, Cubes(), SmallJaw(), path); }),
                testing::HasSubstr("the path of the stir is not finite"));
  }
}

TEST(DegenerateStir, AnEmptyBinAndAPathWithoutLengthLeaveTheSceneAsItIs) {
  const StirPath path{FromAbove({0.1, 0, 0.01}), FromAbove({0.1, 0, 0.01}), 0};
  const ExecuteResult empty = StirBin(Scene(), Cubes(), SmallJaw(), path);
  EXPECT_EQ(FailureName(empty.outcome.failure), FailureName(FailureReason::kStirred));
  EXPECT_TRUE(empty.after.objects.empty());
  const Scene scene = BoxesOnFloor({{-0.1, 0}}, kCubeSide_m);
  const ExecuteResult beside = StirBin(scene, Cubes(), SmallJaw(), path);
  EXPECT_EQ(beside.outcome.neighbors_displaced, 0);
  ASSERT_EQ(beside.after.objects.size(), 1u);
  EXPECT_LT(
      (beside.after.objects[0].X_WO.translation() - scene.objects[0].X_WO.translation()).norm(),
      0.001);
}

TEST(DegenerateSettle, EmptyScenesAndNewInstancesStayAsTheyAre) {
  const PhysicsOptions physics = ExecuteOptions().physics;
  const Scene scene = BoxesOnFloor({{0, 0}}, kCubeSide_m);
  EXPECT_TRUE(SettleDisturbed(Scene(), Scene(), Cubes(), {}, physics).objects.empty());
  EXPECT_TRUE(SettleDisturbed(scene, Scene(), Cubes(), {}, physics).objects.empty());
  // An instance that was not there before has not moved.
  const Scene settled = SettleDisturbed(Scene(), scene, Cubes(), {}, physics);
  ASSERT_EQ(settled.objects.size(), 1u);
  EXPECT_EQ(settled.objects[0].X_WO.matrix(), scene.objects[0].X_WO.matrix());
}

}  // namespace
}  // namespace pickbed::tests
