#include "grasp/plan/image_picks.h"

#include <gtest/gtest.h>

#include "grasp/execute/attempt_world.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// A low cube of 40 mm and a tall pillar.
class ImagePick : public testing::Test {
 protected:
  static EstimatedPose At(double x_m, double y_m, int object = 0) {
    const double height_m = object == 0 ? 0.04 : 0.12;
    return {ObjectId(object), Translation({x_m, y_m, 0.5 * height_m})};
  }

  static Grasp GraspOf(const EstimatedPose& pose, double closing_rad = 0) {
    Grasp grasp;
    Vector3d tips_W = pose.X_WO.translation();
    tips_W.z() = 0.01;
    grasp.X_WG = FromAbove(tips_W, closing_rad);
    grasp.width_m = 0.04;
    return grasp;
  }

  bool AreIndependent(const EstimatedPose& a, const EstimatedPose& b, double closing_rad = 0,
                      const ImagePicksOptions& options = {}) const {
    ImagePicks picks(objects_, options);
    picks.Add(GraspOf(a, closing_rad), a, gripper_);
    return picks.IsIndependent(GraspOf(b, closing_rad), b, gripper_);
  }

  ParallelJaw gripper_ = SmallJaw();
  ObjectSet objects_{BoxObject({0.04, 0.04, 0.04}, 0.1), BoxObject({0.04, 0.04, 0.12}, 0.1)};
};

TEST_F(ImagePick, ObjectsMustBeBeyondTheCircleInWhichAPickMovesNeighbors) {
  const double limit_m = objects_[0]->diameter_m + ImagePicksOptions().apart_m;
  EXPECT_TRUE(AreIndependent(At(0, 0), At(0, limit_m + 0.001)));
  EXPECT_FALSE(AreIndependent(At(0, 0), At(0, limit_m - 0.001)));
  EXPECT_FALSE(AreIndependent(At(0, 0), At(0, 0))) << "the same instance";
  // The height of the objects has no effect: one of them could be above the other.
  EstimatedPose above = At(0, limit_m - 0.001);
  above.X_WO.translation().z() += 0.5;
  EXPECT_FALSE(AreIndependent(At(0, 0), above));
}

TEST_F(ImagePick, DistanceIsTheOneBeyondWhichAnExecutionMovesNothing) {
  EXPECT_EQ(ImagePicksOptions().apart_m, AttemptWorldOptions().near_m);
}

// A lift that moves aside needs this much more distance, on either side of a pair.
TEST_F(ImagePick, SidewaysShiftOfALiftAddsToTheDistance) {
  const double limit_m = objects_[0]->diameter_m + ImagePicksOptions().apart_m;
  const EstimatedPose a = At(0, 0), b = At(0, limit_m + 0.02);
  Grasp shifted = GraspOf(a);
  shifted.lift_aside_m = {0, 0.03};
  ImagePicks picks(objects_), reversed(objects_);
  picks.Add(shifted, a, gripper_);
  EXPECT_FALSE(picks.IsIndependent(GraspOf(b), b, gripper_));
  reversed.Add(GraspOf(b), b, gripper_);
  EXPECT_FALSE(reversed.IsIndependent(shifted, a, gripper_));
  EXPECT_TRUE(AreIndependent(a, b)) << "straight up";
}

// The open fingers reach 50 mm beside the center. Without a minimum distance only the hand counts.
TEST_F(ImagePick, HandMustKeepOffTheOtherObject) {
  ImagePicksOptions options;
  options.apart_m = 0;
  gripper_.hand.palm_size_m = {0.30, 0.04, 0.04};
  const double beside_m = 0.5 * (objects_[0]->diameter_m + objects_[1]->diameter_m) + 0.005;
  // The palm passes above a cube and meets a pillar.
  EXPECT_TRUE(AreIndependent(At(0, 0), At(beside_m, 0), 0, options));
  EXPECT_FALSE(AreIndependent(At(0, 0), At(beside_m, 0, 1), 0, options));
  // Across the closing direction the palm is narrow.
  EXPECT_TRUE(AreIndependent(At(0, 0), At(0, beside_m, 1), 0, options));
}

// The hand waits beside the object and would pass it only on its way up.
TEST_F(ImagePick, LiftedHandMustKeepOffTheOtherObject) {
  ImagePicksOptions options;
  options.apart_m = 0;
  gripper_.hand.palm_size_m = {0.30, 0.04, 0.04};
  gripper_.approach_m = 0.001;
  EstimatedPose high = At(0.5 * (objects_[0]->diameter_m + objects_[1]->diameter_m) + 0.005, 0, 1);
  EXPECT_FALSE(AreIndependent(At(0, 0), high, 0, options));
  high.X_WO.translation().z() += 0.25;
  EXPECT_FALSE(AreIndependent(At(0, 0), high, 0, options)) << "the palm is lifted through it";
}

TEST_F(ImagePick, OrderOfTheTwoPicksHasNoEffect) {
  gripper_.hand.palm_size_m = {0.20, 0.04, 0.04};
  int independent = 0, dependent = 0;
  for (double x_m = 0.03; x_m < 0.2; x_m += 0.005) {
    for (const int object : {0, 1}) {
      const EstimatedPose a = At(0, 0), b = At(x_m, 0.02, object);
      const bool both = AreIndependent(a, b);
      EXPECT_EQ(both, AreIndependent(b, a)) << x_m;
      ++(both ? independent : dependent);
    }
  }
  EXPECT_GT(independent, 5);
  EXPECT_GT(dependent, 5);
}

}  // namespace
}  // namespace pickbed::tests
