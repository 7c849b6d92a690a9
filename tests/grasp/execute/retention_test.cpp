#include "grasp/execute/retention.h"

#include <gtest/gtest.h>

#include "grasp/execute/execute.h"
#include "grasp/grippers/suction_cup.h"
#include "grasp/grippers/table.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

constexpr double kBoxSide_m = 0.05;
constexpr double kOneG_mps2 = 9.81;

// Picks a box from above with a jaw that pushes with 40 N.
GraspOutcome PickWithLoad(double mass_kg, double friction, const RetentionOptions& retention,
                          double shake_m = ExecuteOptions().shake_m) {
  const ObjectSet boxes{BoxObject({0.04, 0.05, kBoxSide_m}, mass_kg, friction)};
  Grasp grasp;
  grasp.X_WG = FromAbove({0, 0, 0.015});
  grasp.width_m = 0.04;
  ExecuteOptions options;
  options.retention = retention;
  options.shake_m = shake_m;
  return ExecuteGrasp(BoxesOnFloor({{0, 0}}, kBoxSide_m), boxes, grasp, SmallJaw(), InstanceId{10},
                      options)
      .outcome;
}

// Two pads hold a weight of 2 mu F. Sliding out takes a fraction of a second, in which the load
// grows on.
TEST(Retention, JawLosesABoxAtTwiceFrictionTimesForce) {
  for (const double mass_kg : {0.2, 0.4}) {
    const GraspOutcome outcome = PickWithLoad(mass_kg, 0.1, {.max_g = 8});
    ASSERT_TRUE(outcome.success);
    const double limit_g = 2 * 0.1 * 40 / (mass_kg * kOneG_mps2);
    EXPECT_GT(outcome.retention_g, 0.95 * limit_g) << mass_kg;
    EXPECT_LT(outcome.retention_g, 1.05 * limit_g + 0.6) << mass_kg;
  }
}

// Across the closing direction the pads hold the resultant of weight and lateral load.
TEST(Retention, LateralLoadAddsToTheWeight) {
  const double mass_kg = 0.2;
  const GraspOutcome outcome = PickWithLoad(mass_kg, 0.1, {.max_g = 8, .is_lateral = true});
  ASSERT_TRUE(outcome.success);
  const double total_g = 2 * 0.1 * 40 / (mass_kg * kOneG_mps2);
  const double lateral_g = std::sqrt(total_g * total_g - 1);
  EXPECT_GT(outcome.retention_g, 0.9 * lateral_g);
  EXPECT_LT(outcome.retention_g, 1.05 * lateral_g + 0.8);
}

TEST(Retention, LoadIsLimited) {
  EXPECT_DOUBLE_EQ(PickWithLoad(0.1, 0.5, {.max_g = 3}).retention_g, 3);
}

// The cup holds its vacuum force, less what the tilting moment takes.
TEST(Retention, CupLosesABoxAtItsCapacity) {
  const auto cup = LoadGripper("cup_30mm");
  const ObjectSet boxes{BoxObject({0.06, 0.06, 0.04}, 0.3)};
  Grasp grasp;
  const double press_m = dynamic_cast<const SuctionCup&>(*cup).cup.press_m;
  grasp.X_WG = FromAbove({0, 0, 0.04 + 0.0006 - press_m});
  ExecuteOptions options;
  options.retention.max_g = 50;
  const GraspOutcome outcome =
      ExecuteGrasp(BoxesOnFloor({{0, 0}}, 0.04), boxes, grasp, *cup, InstanceId{10}, options)
          .outcome;
  ASSERT_TRUE(outcome.success);
  const double limit_g = cup->Capacity_n(boxes[0]->friction) / (0.3 * kOneG_mps2);
  EXPECT_NEAR(outcome.retention_g, limit_g, 0.15 * limit_g);
}

TEST(Retention, TestChangesNoOtherResult) {
  GraspOutcome with = PickWithLoad(0.2, 0.1, {.max_g = 4}), without = PickWithLoad(0.2, 0.1, {});
  EXPECT_GT(with.retention_g, 1);
  EXPECT_LT(without.retention_g, 0);
  EXPECT_EQ(with.slip_m, without.slip_m);
  EXPECT_EQ(with.place_error_m, without.place_error_m);
  EXPECT_EQ(with.contact_force_n, without.contact_force_n);
  EXPECT_EQ(with.verdicts, without.verdicts);
}

// The grip holds twice the weight, but not a shake with 5 cm at 5 Hz.
TEST(Retention, TimeOfADropIsWithinHoldAndShake) {
  const ExecuteOptions options;
  const GraspOutcome held = PickWithLoad(0.2, 0.1, {.max_g = 2});
  EXPECT_LT(held.drop_time_s, 0);
  const GraspOutcome lost = PickWithLoad(0.4, 0.1, {.max_g = 2}, 0.05);
  ASSERT_EQ(FailureName(lost.failure), FailureName(FailureReason::kDropped));
  EXPECT_LT(lost.retention_g, 0) << "only successful picks are tested";
  EXPECT_GT(lost.drop_time_s, options.hold_s);
  EXPECT_LE(lost.drop_time_s, options.hold_s + options.shake_s);
  EXPECT_LT(PickWithLoad(0.4, 0.1, {}, 0.05).drop_time_s, 0) << "not timed";
}

}  // namespace
}  // namespace pickbed::tests
