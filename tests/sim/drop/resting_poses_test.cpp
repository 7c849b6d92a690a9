#include "sim/drop/resting_poses.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

TEST(RestingPoses, BoxRestsOnItsFacesMostlyOnTheLargest) {
  const auto box = BoxObject({0.08, 0.06, 0.02}, 0.2);
  const auto poses = FindRestingPoses(*box, 120);
  ASSERT_GE(poses.size(), 2u);
  double sum = 0;
  for (const RestingPose& pose : poses) {
    EXPECT_GT(pose.up_O.cwiseAbs().maxCoeff(), 0.99) << pose.up_O.transpose();
    sum += pose.probability;
  }
  EXPECT_NEAR(sum, 1, 0.03);
  // No symmetry is declared, so the two large faces are separate poses. Seen from the center, each
  // covers 4 atan(ab / (d sqrt(a^2 + b^2 + d^2))) of the sphere, together 0.744 of it. Tumbling can
  // only increase this.
  EXPECT_GT(std::abs(poses[0].up_O.z()), 0.99);
  EXPECT_GT(std::abs(poses[1].up_O.z()), 0.99);
  EXPECT_GT(poses[0].probability + poses[1].probability, 0.744 - 0.06);
  EXPECT_LT(poses[0].probability + poses[1].probability, 0.95);
}

TEST(RestingPoses, SymmetriesMergeEquivalentPoses) {
  auto cube = std::make_shared<ObjectModel>(*BoxObject({0.05, 0.05, 0.05}, 0.2));
  EXPECT_EQ(FindRestingPoses(*cube, 100).size(), 6u);
  for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)}) {
    for (int i = 1; i < 4; ++i) {
      cube->symmetries_O.discrete_O.push_back(TurnAbout({axis, Vector3d::Zero()}, i * M_PI / 2));
    }
  }
  const auto poses = FindRestingPoses(*cube, 100);
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_NEAR(poses[0].probability, 1, 0.02);
}

TEST(RestingPoses, TouchThePlaneAndRepeat) {
  const auto box = BoxObject({0.08, 0.06, 0.02}, 0.2);
  const auto first = FindRestingPoses(*box, 40, 3), second = FindRestingPoses(*box, 40, 3);
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].up_O, second[i].up_O);
    double lowest = 1;
    for (const Vector3d& p : box->convex_pieces_O[0].vertices_O) {
      lowest = std::min(lowest, (first[i].X_WO * p).z());
    }
    EXPECT_NEAR(lowest, 0, 1e-12);
    EXPECT_LT((first[i].X_WO.linear() * first[i].up_O - Vector3d::UnitZ()).norm(), 1e-7);
  }
}

}  // namespace
}  // namespace pickbed::tests
