#include "grasp/planners/pose_planner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grasp/candidates/candidates.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

// A cube on the floor, with the candidates of a jaw.
struct CubeOnFloor {
  ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.1, 0.5)};
  std::vector<std::shared_ptr<const Gripper>> tools{std::make_shared<ParallelJaw>(SmallJaw())};
  std::vector<std::vector<std::vector<GraspCandidate>>> candidates;
  Bin bin;
  RgbdFrame frame;  // without readings: no observed obstacle
  EstimatedPose pose{ObjectId(0), Translation({0.02, 0.01, 0.015}), 1};

  CubeOnFloor() {
    Rng rng(1);
    AntipodalOptions options;
    options.candidates = 50;
    const ParallelJaw jaw = SmallJaw();
    candidates = {{AntipodalGrasps(*objects[0], jaw.hand, jaw.clearance_m, rng, options)}};
  }
  PlannerSetup Setup() const { return {{}, tools, objects, candidates, {}, 2}; }
};

TEST(PosePlanner, PlansAsPlanGraspsDoes) {
  const CubeOnFloor cube;
  PosePlanner planner(cube.Setup());
  PlannerInput input{cube.frame, Pose::Identity(), BinPlacement{cube.bin, Pose::Identity()}};
  input.poses = {&cube.pose, 1};
  const PlanResult planned = planner.Plan(input);
  const PlanResult direct =
      PlanGrasps({cube.bin, input.poses, cube.candidates[0], {}, cube.objects, *cube.tools[0]});
  ASSERT_FALSE(planned.grasps.empty());
  ASSERT_EQ(planned.grasps.size(), direct.grasps.size());
  for (size_t i = 0; i < planned.grasps.size(); ++i) {
    EXPECT_EQ(planned.grasps[i].X_WG.matrix(), direct.grasps[i].X_WG.matrix());
    EXPECT_EQ(planned.grasps[i].score, direct.grasps[i].score);
  }
}

TEST(PosePlanner, GraspsMoveWithTheBin) {
  const CubeOnFloor cube;
  PosePlanner planner(cube.Setup());
  const Pose X_WB = Translation({0.1, -0.2, 0.3});
  PlannerInput here{cube.frame, Pose::Identity(), BinPlacement{cube.bin, Pose::Identity()}};
  here.poses = {&cube.pose, 1};
  EstimatedPose moved = cube.pose;
  moved.X_WO = X_WB * moved.X_WO;
  PlannerInput there{cube.frame, Pose::Identity(), BinPlacement{cube.bin, X_WB}};
  there.poses = {&moved, 1};
  const Grasp a = planner.Plan(here).grasps.at(0), b = planner.Plan(there).grasps.at(0);
  EXPECT_TRUE(b.X_WG.isApprox(X_WB * a.X_WG, 1e-9));
}

TEST(PosePlanner, NeedsABin) {
  const CubeOnFloor cube;
  PosePlanner planner(cube.Setup());
  EXPECT_THAT(ErrorOf([&] {
                planner.Plan({cube.frame, Pose::Identity(), std::nullopt});
              }),
              HasSubstr("needs a known bin"));
}

}  // namespace
}  // namespace pickbed::tests
