#include "grasp/cloud/cloud_suction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grasp/plan/clearance.h"
#include "tests/grasp/cloud/cloud_scene.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

// A planner with one cup and no objects.
class SuctionPlan {
 public:
  explicit SuctionPlan(std::shared_ptr<const Gripper> tool = std::make_shared<SuctionCup>())
      : tools_{std::move(tool)},
        planner_(PlannerSetup{PlannerSpec(), tools_, objects_, candidates_, {}, 2}) {}

  PlanResult Of(const PlannerInput& input) { return planner_.Plan(input); }
  const Gripper& cup() const { return *tools_.front(); }

 private:
  std::vector<std::shared_ptr<const Gripper>> tools_;
  ObjectSet objects_;
  std::vector<std::vector<std::vector<GraspCandidate>>> candidates_;
  CloudSuction planner_;
};

double RadiusOf(const Gripper& tool) { return dynamic_cast<const SuctionCup&>(tool).cup.radius_m; }

TEST(CloudSuction, SealsNearTheMiddleOfTheTopOfABox) {
  CloudScene scene;
  const Vector3d size(0.07, 0.05, 0.03);
  scene.AddBox(size, OnFloor(0.02, -0.03, size.z(), 0.4));
  SuctionPlan plan;
  const PlanResult result = plan.Of(scene.Input());
  ASSERT_FALSE(result.grasps.empty());
  const Grasp& best = result.grasps.front();
  const double press_m = dynamic_cast<const SuctionCup&>(plan.cup()).cup.press_m;
  EXPECT_NEAR(best.X_WG.translation().z(), size.z() - press_m, 0.001);
  EXPECT_LT((best.X_WG.translation() - Vector3d(0.02, -0.03, 0)).head<2>().norm(), 0.012);
  EXPECT_LT(best.X_WG.linear()(2, 2), -0.999) << "straight down";
  EXPECT_EQ(best.hypothesis, kNoHypothesis);
}

// The whole lip is on the top at each rotation of the box.
TEST(CloudSuction, TheLipStaysOffTheEdges) {
  for (const double yaw_rad : {0.0, 0.5, 1.1}) {
    CloudScene scene;
    const Vector3d size(0.08, 0.045, 0.03);
    const Pose pose = OnFloor(0, 0.02, size.z(), yaw_rad);
    scene.AddBox(size, pose);
    SuctionPlan plan;
    const PlanResult result = plan.Of(scene.Input(100));
    ASSERT_FALSE(result.grasps.empty());
    for (const Grasp& grasp : result.grasps) {
      const Vector3d p_O = pose.inverse() * grasp.X_WG.translation();
      const double free_m = (0.5 * size - p_O.cwiseAbs()).head<2>().minCoeff();
      EXPECT_GT(free_m, 0.75 * RadiusOf(plan.cup()));
    }
  }
}

// A sphere of 50 mm is 5 mm lower at the rim of the lip than in its middle.
TEST(CloudSuction, NarrowOrCurvedSurfaceGivesNoGrasp) {
  CloudScene narrow;
  narrow.AddBox({0.08, 0.02, 0.03}, OnFloor(0, 0, 0.03, 0.3));
  EXPECT_TRUE(SuctionPlan().Of(narrow.Input()).grasps.empty());
  CloudScene round;
  round.AddMesh(SphereMesh(0.025), OnFloor(0, 0, 0.05, 0));
  EXPECT_TRUE(SuctionPlan().Of(round.Input()).grasps.empty());
}

// The palm is wider than the lip, and lower than the top of the neighbor.
TEST(CloudSuction, KeepsThePalmOffATallNeighbor) {
  CloudScene scene;
  const Vector3d size(0.06, 0.06, 0.02), tall(0.05, 0.05, 0.14);
  scene.AddBox(size, OnFloor(0, 0, size.z(), 0));
  scene.AddBox(tall, OnFloor(0.060, 0, tall.z(), 0));
  SuctionPlan plan;
  const PlanResult result = plan.Of(scene.Input(100));
  EXPECT_GT(result.rejected.at("stem or palm meets an instance"), 0);
  const AxisAlignedBox neighbor{{0.060, 0, 0.5 * tall.z()}, 0.5 * tall};
  for (const Grasp& grasp : result.grasps) {
    if (grasp.X_WG.translation().z() > 0.1) continue;  // on the neighbor
    EXPECT_FALSE(FindBinContact(HandSweep(plan.cup(), 0), grasp.X_WG, {&neighbor, 1}, 0));
  }
}

TEST(CloudSuction, EqualImagesGiveEqualGraspsAndAnEmptyBinNone) {
  CloudScene scene;
  SuctionPlan plan;
  EXPECT_TRUE(plan.Of(scene.Input()).grasps.empty());
  scene.AddBox({0.07, 0.05, 0.03}, OnFloor(0, 0, 0.03, 0));
  const PlanResult a = plan.Of(scene.Input()), b = plan.Of(scene.Input());
  ASSERT_EQ(a.grasps.size(), b.grasps.size());
  for (size_t i = 0; i < a.grasps.size(); ++i) {
    EXPECT_EQ(a.grasps[i].X_WG.matrix(), b.grasps[i].X_WG.matrix());
  }
}

TEST(CloudSuction, RefusesJaws) {
  EXPECT_THAT(ErrorOf([] { SuctionPlan plan(std::make_shared<ParallelJaw>(SmallJaw())); }),
              HasSubstr("cloud_suction needs suction cups"));
}

}  // namespace
}  // namespace pickbed::tests
