#include "grasp/execute/settle.h"

#include <gtest/gtest.h>

#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kSide_m = 0.04;

// Cubes with their centers at these positions, one instance each.
Scene Cubes(const std::vector<Vector3d>& centers_W) {
  std::vector<Eigen::Vector2d> plan;
  for (const Vector3d& center_W : centers_W) plan.push_back(center_W.head<2>());
  Scene scene = BoxesOnFloor(plan, kSide_m);
  for (size_t i = 0; i < centers_W.size(); ++i) {
    scene.objects[i].X_WO = Translation(centers_W[i]);
  }
  return scene;
}

class Settling : public testing::Test {
 protected:
  Scene Settled(const Scene& before, const Scene& after, const SettleOptions& options = {}) const {
    return grasp::SettleDisturbed(before, after, objects_, options, physics_);
  }
  static double HeightOf(const Scene& scene, int i) {
    return scene.objects[i].X_WO.translation().z();
  }

  static constexpr double kHalf_m = 0.5 * kSide_m;
  ObjectSet objects_{BoxObject({kSide_m, kSide_m, kSide_m}, 0.1)};
  PhysicsOptions physics_ = ExecuteOptions().physics;
};

TEST_F(Settling, InstanceWithoutSupportFalls) {
  const Scene before = Cubes({{0, 0, kHalf_m}, {0, 0, 3 * kHalf_m}});
  Scene after = before;
  after.objects[0].X_WO = Translation({0.1, 0, kHalf_m});
  const Scene settled = Settled(before, after);
  EXPECT_NEAR(HeightOf(settled, 1), kHalf_m, 0.001);
  EXPECT_NEAR((settled.objects[0].X_WO.translation() - Vector3d(0.1, 0, kHalf_m)).norm(), 0, 0.001);
}

// The upper cube is no neighbor of the one that moved. It falls with the cube below it.
TEST_F(Settling, MovementSpreadsFromNeighborToNeighbor) {
  const Scene before = Cubes({{0, 0, kHalf_m}, {0, 0, 3 * kHalf_m}, {0, 0, 5 * kHalf_m}});
  Scene after = before;
  after.objects[0].X_WO = Translation({0.1, 0, kHalf_m});
  EXPECT_NEAR(HeightOf(Settled(before, after), 2), 3 * kHalf_m, 0.002);
  SettleOptions one_round;
  one_round.max_rounds = 1;
  EXPECT_EQ(HeightOf(Settled(before, after, one_round), 2), 5 * kHalf_m);
}

TEST_F(Settling, NothingMovesWithoutADisturbance) {
  // The second cube hovers, but nothing near it moved.
  const Scene before = Cubes({{-0.1, 0, kHalf_m}, {0.1, 0, 5 * kHalf_m}});
  Scene after = before;
  after.objects[0].X_WO = Translation({-0.12, 0, kHalf_m});
  const Scene settled = Settled(before, after);
  EXPECT_EQ(settled.objects[1].X_WO.matrix(), after.objects[1].X_WO.matrix());
  EXPECT_EQ(Settled(before, before).objects[1].X_WO.matrix(), before.objects[1].X_WO.matrix());
}

TEST_F(Settling, InstanceThatLeavesTheBinIsRemoved) {
  const Scene before = Cubes({{0, 0, kHalf_m}, {0, 0, 3 * kHalf_m}});
  Scene after = before;
  after.objects[0].X_WO = Translation({0.1, 0, kHalf_m});
  after.objects[1].X_WO = Translation({1, 0, 0.1});
  const Scene settled = Settled(before, after);
  ASSERT_EQ(settled.objects.size(), 1u);
  EXPECT_EQ(settled.objects[0].instance, before.objects[0].instance);
}

}  // namespace
}  // namespace pickbed::tests
