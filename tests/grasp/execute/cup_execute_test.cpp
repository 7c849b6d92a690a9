// Complete attempts with a suction cup.

#include <gtest/gtest.h>

#include "grasp/execute/execute.h"
#include "grasp/grippers/suction_cup.h"
#include "grasp/grippers/table.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

constexpr double kHeight_m = 0.04;

// The 30 mm cup that is shipped with the program.
SuctionCup LoadedCup() { return dynamic_cast<const SuctionCup&>(*LoadGripper("cup_30mm")); }

// Picks a box of 6 x 6 x 4 cm in the bin from above, `aside_m` beside its center, with the
// compression from the cup's file.
GraspOutcome PickWithCup(double mass_kg, double aside_m) {
  const SuctionCup cup = LoadedCup();
  const ObjectSet boxes{BoxObject({0.06, 0.06, kHeight_m}, mass_kg)};
  Grasp grasp;
  grasp.X_WG = FromAbove({aside_m, 0, kHeight_m + 0.0006 - cup.cup.press_m});
  return ExecuteGrasp(BoxesOnFloor({{0, 0}, {0.1, 0}}, kHeight_m), boxes, grasp, cup,
                      InstanceId{10})
      .outcome;
}

TEST(CupExecute, HoldsABoxDuringTheShake) {
  const GraspOutcome outcome = PickWithCup(0.3, 0);
  EXPECT_EQ(FailureName(outcome.failure), FailureName(FailureReason::kNone));
  EXPECT_EQ(outcome.picked_instance, 10);
  EXPECT_EQ(outcome.instances_lifted, 1);
  EXPECT_EQ(outcome.neighbors_displaced, 0);
  EXPECT_LT(outcome.slip_m, 5e-4);
}

TEST(CupExecute, DoesNotSealAcrossTheEdge) {
  EXPECT_EQ(FailureName(PickWithCup(0.3, 0.025).failure),
            FailureName(FailureReason::kClosedOnNothing));
}

// The palm behind the stem extends 3 cm from its center, the lip half of that.
TEST(CupExecute, PalmAgainstTheWallIsACollision) {
  const SuctionCup cup = LoadedCup();
  const ObjectSet boxes{BoxObject({0.06, 0.06, kHeight_m}, 0.3)};
  const auto pick = [&](double from_wall_m) {
    Scene scene = BoxesOnFloor({{0, 0.118}}, kHeight_m);
    scene.bin.inner_size_m.z() = 0.25;
    const double wall_m = 0.5 * scene.bin.inner_size_m.y();
    Grasp grasp;
    grasp.X_WG = FromAbove({0, wall_m - from_wall_m, kHeight_m + 0.0006 - cup.cup.press_m});
    return ExecuteGrasp(scene, boxes, grasp, cup, InstanceId{10}).outcome.failure;
  };
  EXPECT_EQ(FailureName(pick(0.025)), FailureName(FailureReason::kCollision));
  EXPECT_EQ(FailureName(pick(0.035)), FailureName(FailureReason::kNone));
}

// The vacuum is on during the approach, which ends where the lip seals. So an object that is higher
// than planned, here by more than the travel of the bellows, is neither missed nor pushed.
TEST(CupExecute, StopsWhereTheLipSeals) {
  const SuctionCup cup = LoadedCup();
  const ObjectSet boxes{BoxObject({0.06, 0.06, kHeight_m}, 0.3)};
  Grasp grasp;
  grasp.X_WG = FromAbove({0, 0, kHeight_m + 0.0006 - cup.cup.bellows_travel_m - 0.007});
  const GraspOutcome outcome =
      ExecuteGrasp(BoxesOnFloor({{0, 0}}, kHeight_m), boxes, grasp, cup, InstanceId{10}).outcome;
  EXPECT_EQ(FailureName(outcome.failure), FailureName(FailureReason::kNone));
  EXPECT_NEAR(outcome.final_opening_m, cup.cup.bellows_travel_m, 0.001);
}

// The bellows yield 5 mm more than planned. The cup searches so far for a surface that is lower
// than planned, and no further.
TEST(CupExecute, SearchesALowerSurfaceWithinTheTravelOfTheBellows) {
  const SuctionCup cup = LoadedCup();
  const ObjectSet boxes{BoxObject({0.06, 0.06, kHeight_m}, 0.3)};
  const double rest_m = cup.cup.bellows_travel_m - cup.cup.press_m;
  const auto pick = [&](double lower_m) {
    Grasp grasp;
    grasp.X_WG = FromAbove({0, 0, kHeight_m + 0.0006 - cup.cup.press_m + lower_m});
    return ExecuteGrasp(BoxesOnFloor({{0, 0}}, kHeight_m), boxes, grasp, cup, InstanceId{10})
        .outcome.failure;
  };
  EXPECT_EQ(FailureName(pick(cup.cup.press_m + 0.5 * rest_m)), FailureName(FailureReason::kNone));
  EXPECT_EQ(FailureName(pick(cup.cup.bellows_travel_m + 0.002)),
            FailureName(FailureReason::kClosedOnNothing));
}

// Beside the box the stem hits the floor, and the palm stays above it.
TEST(CupExecute, StemAgainstTheFloorIsACollision) {
  const SuctionCup cup = LoadedCup();
  const ObjectSet boxes{BoxObject({0.06, 0.06, kHeight_m}, 0.3)};
  const auto pick = [&](double lip_z_m) {
    Grasp grasp;
    grasp.X_WG = FromAbove({0.1, 0, lip_z_m});
    return ExecuteGrasp(BoxesOnFloor({{0, 0}}, kHeight_m), boxes, grasp, cup, InstanceId{10})
        .outcome.failure;
  };
  EXPECT_EQ(FailureName(pick(-cup.cup.bellows_travel_m - 0.003)),
            FailureName(FailureReason::kCollision));
  EXPECT_EQ(FailureName(pick(-cup.cup.bellows_travel_m + 0.003)),
            FailureName(FailureReason::kClosedOnNothing));
}

// The weight of 42 N is below the vacuum force of 45 N. With the acceleration of the lift of 1.15
// m/s^2 the load is 47 N.
TEST(CupExecute, LiftAccelerationCanExceedTheVacuumForce) {
  EXPECT_EQ(FailureName(PickWithCup(4.3, 0).failure), FailureName(FailureReason::kSlipped));
}

// The cup seals on a box of 20 kg on the floor, and comes off when the hand goes up.
TEST(CupExecute, FarTooHeavyBoxIsSealedButNotLifted) {
  const GraspOutcome outcome = PickWithCup(20, 0);
  EXPECT_EQ(FailureName(outcome.failure), FailureName(FailureReason::kSlipped));
  EXPECT_EQ(outcome.instances_touched, 1);
  EXPECT_LT(outcome.lift_height_m, 0.001);
}

}  // namespace
}  // namespace pickbed::tests
