// A suction cup through the whole of an attempt.

#include <gtest/gtest.h>

#include "grasp/execute.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed {
namespace {

constexpr double kHeight_m = 0.04;

// Down on the top of a box of 6 x 6 x 4 cm in the bin, pressed on as the cup's file says.
GraspOutcome PickWithCup(double mass_kg, double aside_m) {
  const GripperSpec cup = LoadGripper("cup_30mm");
  const ObjectSet boxes{BoxPart({0.06, 0.06, kHeight_m}, mass_kg)};
  Grasp grasp;
  grasp.X_WG = FromAbove({aside_m, 0, kHeight_m + 0.0006 - cup.cup.press_m});
  return ExecuteGrasp(BoxesOnFloor({{0, 0}, {0.1, 0}}, kHeight_m), boxes, grasp, cup, 10).outcome;
}

TEST(CupExecute, CarriesABoxThroughTheShake) {
  const GraspOutcome outcome = PickWithCup(0.3, 0);
  EXPECT_EQ(LossName(outcome.loss), LossName(Loss::kNone));
  EXPECT_EQ(outcome.picked_instance, 10);
  EXPECT_EQ(outcome.parts_lifted, 1);
  EXPECT_EQ(outcome.disturbed, 0);
  EXPECT_LT(outcome.slip_m, 5e-4);
}

TEST(CupExecute, OverTheEdgeItDoesNotSeal) {
  EXPECT_EQ(LossName(PickWithCup(0.3, 0.025).loss), LossName(Loss::kClosedOnNothing));
}

// The palm behind the stem reaches 3 cm from its middle, the lip half of that.
TEST(CupExecute, APalmThatMeetsTheWallIsACollision) {
  const GripperSpec cup = LoadGripper("cup_30mm");
  const ObjectSet boxes{BoxPart({0.06, 0.06, kHeight_m}, 0.3)};
  const auto pick = [&](double from_wall_m) {
    Scene scene = BoxesOnFloor({{0, 0.118}}, kHeight_m);
    scene.bin.inner_size_m.z() = 0.25;
    const double wall_m = 0.5 * scene.bin.inner_size_m.y();
    Grasp grasp;
    grasp.X_WG = FromAbove({0, wall_m - from_wall_m, kHeight_m + 0.0006 - cup.cup.press_m});
    return ExecuteGrasp(scene, boxes, grasp, cup, 10).outcome.loss;
  };
  EXPECT_EQ(LossName(pick(0.025)), LossName(Loss::kCollision));
  EXPECT_EQ(LossName(pick(0.035)), LossName(Loss::kNone));
}

// A stem beside the box goes into the floor, the palm stays above.
TEST(CupExecute, AStemThatMeetsTheFloorIsACollision) {
  const GripperSpec cup = LoadGripper("cup_30mm");
  const ObjectSet boxes{BoxPart({0.06, 0.06, kHeight_m}, 0.3)};
  const auto pick = [&](double lip_z_m) {
    Grasp grasp;
    grasp.X_WG = FromAbove({0.1, 0, lip_z_m});
    return ExecuteGrasp(BoxesOnFloor({{0, 0}}, kHeight_m), boxes, grasp, cup, 10).outcome.loss;
  };
  EXPECT_EQ(LossName(pick(-cup.cup.bellows_travel_m - 0.003)), LossName(Loss::kCollision));
  EXPECT_EQ(LossName(pick(-cup.cup.bellows_travel_m + 0.003)), LossName(Loss::kClosedOnNothing));
}

// Its weight of 42 N is below the cup's 45, with the lift's 1.15 m/s^2 it is 47.
TEST(CupExecute, ItComesOffABoxThatIsTooHeavyToLiftSoFast) {
  EXPECT_EQ(LossName(PickWithCup(4.3, 0).loss), LossName(Loss::kSlipped));
}

// It seals on 20 kg that stand on the floor, and comes off when the hand goes up.
TEST(CupExecute, FarTooHeavyIsSealedAndThenNotLifted) {
  const GraspOutcome outcome = PickWithCup(20, 0);
  EXPECT_EQ(LossName(outcome.loss), LossName(Loss::kSlipped));
  EXPECT_EQ(outcome.parts_touched, 1);
  EXPECT_LT(outcome.lift_height_m, 0.001);
}

}  // namespace
}  // namespace pickbed
