#include "sim/drop/penetration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "scenes/base/random.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kHigh_m = 0.5;  // above the bin

double DepthOf(const ObjectSet& objects, const std::vector<Pose>& poses) {
  Scene scene;
  for (size_t i = 0; i < poses.size(); ++i) {
    scene.objects.push_back({InstanceId(i), ObjectId(i % objects.size()), poses[i]});
  }
  return DeepestPenetration(scene, objects);
}

Pose Rotated(double angle_rad, const Vector3d& axis, const Vector3d& p_WO) {
  return MakePose(Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix(), p_WO);
}

TEST(DeepestPenetration, ZeroForSeparateInstances) {
  const ObjectSet cube{BoxObject(Vector3d::Constant(0.04), 0.1)};
  EXPECT_EQ(DepthOf(cube, {Translation({0, 0, 0.03}), Translation({0.0401, 0, 0.03})}), 0);
}

TEST(DeepestPenetration, MatchesTwoCubesFaceToFace) {
  const ObjectSet cube{BoxObject(Vector3d::Constant(0.04), 0.1)};
  const Pose low = Translation({0, 0, kHigh_m});
  EXPECT_NEAR(DepthOf(cube, {low, Translation({0.037, 0.005, kHigh_m})}), 0.003, 1e-12);
  EXPECT_NEAR(DepthOf(cube, {low, Translation({0.01, 0.005, kHigh_m + 0.0395})}), 0.0005, 1e-12);
}

// Each cube rests on an edge. The edges cross at right angles, one above the other.
TEST(DeepestPenetration, MatchesTwoCubesEdgeToEdge) {
  const ObjectSet cube{BoxObject(Vector3d::Constant(0.04), 0.1)};
  const double quarter = std::numbers::pi / 4, half_diagonal_m = 0.02 * std::sqrt(2.0);
  const double depth_m = 0.002;
  const Pose low = Rotated(quarter, Vector3d::UnitX(), {0, 0, kHigh_m});
  const Pose high =
      Rotated(quarter, Vector3d::UnitY(), {0.003, 0.002, kHigh_m + 2 * half_diagonal_m - depth_m});
  EXPECT_NEAR(DepthOf(cube, {low, high}), depth_m, 1e-12);
}

TEST(DeepestPenetration, MatchesACornerInAFace) {
  const ObjectSet cube{BoxObject(Vector3d::Constant(0.04), 0.1)};
  const double corner_m = 0.02 * std::sqrt(3.0);
  const Eigen::Quaterniond on_corner =
      Eigen::Quaterniond::FromTwoVectors(Vector3d(1, 1, 1), Vector3d(0, 0, -1));
  const Pose high =
      MakePose(on_corner.toRotationMatrix(), {0, 0, kHigh_m + 0.02 + corner_m - 0.0015});
  EXPECT_NEAR(DepthOf(cube, {Translation({0, 0, kHigh_m}), high}), 0.0015, 1e-12);
}

TEST(DeepestPenetration, MatchesACubeInTheFloorOrAWall) {
  const ObjectSet cube{BoxObject(Vector3d::Constant(0.04), 0.1)};
  EXPECT_NEAR(DepthOf(cube, {Translation({0, 0, 0.018})}), 0.002, 1e-12);
  EXPECT_NEAR(DepthOf(cube, {Translation({0.181, 0, 0.05})}), 0.001, 1e-12);
}

TEST(DeepestPenetration, IgnoresOverlapOfPiecesOfOneInstance) {
  const ObjectSet object{ObjectOfBoxes(
      "cross", {{Vector3d::Zero(), {0.03, 0.01, 0.01}}, {Vector3d::Zero(), {0.01, 0.03, 0.01}}},
      0.1)};
  EXPECT_EQ(DepthOf(object, {Translation({0, 0, kHigh_m})}), 0);
}

TEST(DeepestPenetration, IsTheMaximumOverAllPairs) {
  const ObjectSet cube{BoxObject(Vector3d::Constant(0.04), 0.1)};
  EXPECT_NEAR(DepthOf(cube, {Translation({0, 0, kHigh_m}), Translation({0.039, 0, kHigh_m}),
                             Translation({0.075, 0, kHigh_m}), Translation({0.112, 0, kHigh_m})}),
              0.004, 1e-12);
}

// The overlap of two convex point sets along a direction is an upper bound of the depth. The
// minimum over all directions equals the depth.
TEST(DeepestPenetration, IsTheMinimumOverlapOverAllDirections) {
  Rng rng(2);
  int overlapping = 0;
  for (int trial = 0; trial < 12; ++trial) {
    auto cloud = std::make_shared<ObjectModel>();
    ConvexPiece piece;
    for (int i = 0; i < 14; ++i) piece.vertices_O.push_back(0.02 * rng.UnitVector());
    cloud->convex_pieces_O = {piece};
    const Pose A = MakePose(rng.Rotation().toRotationMatrix(), {0, 0, kHigh_m});
    const Pose B = MakePose(rng.Rotation().toRotationMatrix(),
                            Vector3d(0, 0, kHigh_m) + 0.03 * rng.UnitVector());
    const double depth_m = DepthOf({cloud}, {A, B});
    if (depth_m == 0) continue;
    ++overlapping;
    double min_overlap_m = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 40000; ++i) {
      const Vector3d d = rng.UnitVector();
      double max_a = -1, min_b = 1;
      for (const Vector3d& p : piece.vertices_O) {
        max_a = std::max(max_a, d.dot(A * p));
        min_b = std::min(min_b, d.dot(B * p));
      }
      min_overlap_m = std::min(min_overlap_m, max_a - min_b);
    }
    EXPECT_LE(depth_m, min_overlap_m + 1e-12);
    EXPECT_NEAR(depth_m, min_overlap_m, 0.0004);
  }
  EXPECT_GE(overlapping, 4);
}

// Cube 1 is 2 mm in cube 0, cube 2 is 0.3 mm in cube 1, and cube 3 is 1 mm in the floor.
TEST(OverlapsDeeperThan, NamesTheTwoBodiesOfEachDeepOverlap) {
  const ObjectSet cube{BoxObject(Vector3d::Constant(0.04), 0.1)};
  Scene scene;
  const std::vector<Vector3d> places{
      {0, 0, 0.1}, {0.038, 0, 0.1}, {0.0777, 0, 0.1}, {-0.1, 0, 0.019}};
  for (const Vector3d& p_WO : places) {
    scene.objects.push_back({InstanceId(scene.objects.size()), ObjectId(0), Translation(p_WO)});
  }
  const std::vector<Overlap> overlaps = OverlapsDeeperThan(0.0005, scene, cube);
  ASSERT_EQ(overlaps.size(), 2u);
  EXPECT_EQ(overlaps[0].first, 0);
  EXPECT_EQ(overlaps[0].second, 1);
  EXPECT_EQ(overlaps[1].first, 3);
  EXPECT_EQ(overlaps[1].second, -1);
  EXPECT_EQ(OverlapsDeeperThan(0.0002, scene, cube).size(), 3u);
  EXPECT_TRUE(OverlapsDeeperThan(0.0021, scene, cube).empty());
}

}  // namespace
}  // namespace pickbed::tests
