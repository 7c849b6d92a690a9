#include "grasp/execute/pick_up.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

// One box between the fingers and one beside them.
class PickUpTest : public testing::Test {
 protected:
  static Grasp FirstBox() {
    Grasp grasp;
    grasp.X_WG = FromAbove({0, 0, 0.015});
    grasp.width_m = 0.04;
    return grasp;
  }

  PickUp Make(InstanceId target) const {
    return PickUp(scene_, boxes_, FirstBox(), gripper_, target, options_, no_listener_);
  }

  const Scene scene_ = BoxesOnFloor({{0, 0}, {0, 0.1}}, 0.05);
  const ObjectSet boxes_{BoxObject({0.04, 0.05, 0.05}, 0.2, 0.5)};
  const ParallelJaw gripper_ = SmallJaw();
  const ExecuteOptions options_;
  const MotionListener no_listener_;
};

TEST_F(PickUpTest, OnlyTheBoxBetweenTheFingersIsHeld) {
  PickUp pick = Make(InstanceId{10});
  EXPECT_THAT(pick.Held(), testing::IsEmpty()) << "before the lift";
  GraspOutcome outcome;
  ASSERT_EQ(pick.Run(outcome), FailureReason::kNone);
  EXPECT_THAT(pick.Held(), testing::ElementsAre(0));
  EXPECT_TRUE(pick.IsGripped(0));
  EXPECT_FALSE(pick.IsGripped(1));
  EXPECT_TRUE(pick.hand().X_WG().isApprox(pick.Lifted(), 1e-9)) << "the shake ends where it began";
}

TEST_F(PickUpTest, HeldBoxThatIsNotTheTargetIsStillPicked) {
  PickUp pick = Make(InstanceId{11});
  GraspOutcome outcome;
  ASSERT_EQ(pick.Run(outcome), FailureReason::kNone);
  EXPECT_EQ(pick.PickedOf(pick.Held()), 0);
  EXPECT_FALSE(pick.IsTarget(0));
  EXPECT_TRUE(pick.IsTarget(1));
  EXPECT_EQ(pick.PickedOf({}), -1);
}

}  // namespace
}  // namespace pickbed::tests
