#include "grasp/tolerance/tolerance_trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "grasp/tolerance/tolerance_model.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

// Half sizes of a box of 4 x 3 x 6 cm, which rests on any side. It is grasped across x at its upper
// end.
constexpr double kHalfWidth_m = 0.02, kHalfHeight_m = 0.03;

GraspCandidate CandidateFromAbove(double depth_m) {
  GraspCandidate candidate;
  candidate.X_OG = FromAbove({0, 0, kHalfHeight_m - 2 * depth_m});
  candidate.width_m = 2 * kHalfWidth_m;
  candidate.depth_m = depth_m;
  candidate.quality = 0.9;
  return candidate;
}

Table BoxOnTable(double depth_m = 0.012) {
  return MakeTable(BoxObject({0.04, 0.03, 0.06}, 0.1, 0.5),
                   std::make_shared<ParallelJaw>(SmallJaw()), {CandidateFromAbove(depth_m)});
}

Pose Shift(double x, double y, double z) { return Translation({x, y, z}); }

TEST(ToleranceTrial, ErrorsBeyondTheOpeningAreCollisions) {
  const Table table = BoxOnTable();
  Rng rng(0);
  const auto grasps = DrawTableGrasps(table, 1, rng);
  ASSERT_EQ(grasps.size(), 1u);
  EXPECT_TRUE(ExecuteWithError(table, grasps[0], Pose::Identity()).success);
  // The open fingers are 3 mm beside the box, and 10 mm thick.
  for (const double x : {-0.0015, 0.0015}) {
    EXPECT_TRUE(ExecuteWithError(table, grasps[0], Shift(x, 0, 0)).success) << x;
  }
  for (const double x : {-0.008, 0.008}) {
    const GraspOutcome outcome = ExecuteWithError(table, grasps[0], Shift(x, 0, 0));
    EXPECT_FALSE(outcome.success) << x;
    EXPECT_EQ(outcome.failure, FailureReason::kCollision) << x;
  }
}

TEST(ToleranceTrial, HandAboveTheBoxClosesEmpty) {
  const Table table = BoxOnTable();
  Rng rng(0);
  const auto grasps = DrawTableGrasps(table, 1, rng);
  const GraspOutcome outcome = ExecuteWithError(table, grasps[0], Shift(0, 0, 0.05));
  EXPECT_FALSE(outcome.success);
  EXPECT_EQ(outcome.failure, FailureReason::kClosedOnNothing);
}

TEST(ToleranceTrial, HandStaysAboveTheTableForLowEstimates) {
  const Table table = BoxOnTable(0.014);
  Rng rng(0);
  const auto grasps = DrawTableGrasps(table, 1, rng);
  // The tips are 28 mm below the top at 60 mm, that is 32 mm above the table. For an estimate 38 mm
  // lower, the hand is retracted and its palm is still above the box. For 60 mm lower, no contact
  // remains.
  const GraspOutcome outcome = ExecuteWithError(table, grasps[0], Shift(0, 0, -0.060));
  EXPECT_FALSE(outcome.success);
  EXPECT_EQ(outcome.failure, FailureReason::kNoGrasp);
}

TEST(ToleranceTrial, PlacesAreRestingPosesOnTheTable) {
  const Table table = BoxOnTable();
  ASSERT_GE(table.places.size(), 2u);
  std::set<int> graspable;
  double total = 0;
  for (size_t i = 0; i < table.places.size(); ++i) {
    const Pose& X_WO = table.places[i].scene.objects[0].X_WO;
    double lowest = 1;
    for (const Eigen::Vector3d& v : table.objects[0]->mesh_O.vertices) {
      lowest = std::min(lowest, (X_WO * v).z());
    }
    EXPECT_NEAR(lowest, 0.0005, 0.0004) << i;  // the margin of the hulls
    total += table.places[i].probability;
    if (table.places[i].graspable) graspable.insert(static_cast<int>(i));
  }
  EXPECT_GT(total, 0.9);
  EXPECT_LE(total, 1 + 1e-9);
  // A place is graspable only if the single candidate approaches from above.
  EXPECT_LT(graspable.size(), table.places.size());
  Rng rng(0);
  for (const TableGrasp& grasp : DrawTableGrasps(table, 5, rng)) {
    EXPECT_TRUE(graspable.contains(grasp.place));
  }
}

TEST(ToleranceTrial, ObjectWithoutGraspsIsRefused) {
  EXPECT_THAT(ErrorOf([] {
                MakeTable(BoxObject({0.04, 0.03, 0.06}, 0.1, 0.5),
                          std::make_shared<ParallelJaw>(SmallJaw()), {});
              }),
              testing::AllOf(testing::HasSubstr("test jaw"), testing::HasSubstr("no grasp")));
}

}  // namespace
}  // namespace pickbed::tests
