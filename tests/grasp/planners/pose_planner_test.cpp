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

// A second cube covers the side of the first one, so that its lift is pulled aside.
TEST(PosePlanner, GraspsAndTheirLiftsMoveWithTheBin) {
  const CubeOnFloor cube;
  PosePlanner planner(cube.Setup());
  const EstimatedPose cover{ObjectId(0), Translation({0.044, 0.01, 0.046}), 1};
  const std::vector<EstimatedPose> here{cube.pose, cover};
  std::vector<EstimatedPose> there = here;
  const Pose X_WB =
      Translation({0.1, -0.2, 0.3}) * Pose(Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()));
  for (EstimatedPose& pose : there) pose.X_WO = X_WB * pose.X_WO;
  const auto plan = [&](const std::vector<EstimatedPose>& poses, const Pose& bin_pose) {
    PlannerInput input{cube.frame, Pose::Identity(), BinPlacement{cube.bin, bin_pose}};
    input.poses = poses;
    input.max_grasps = 1000;
    return planner.Plan(input).grasps;
  };
  const std::vector<Grasp> before = plan(here, Pose::Identity()), after = plan(there, X_WB);
  ASSERT_EQ(before.size(), after.size());
  const Eigen::Matrix2d R_WB = X_WB.linear().topLeftCorner<2, 2>();
  int aside = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_TRUE(after[i].X_WG.isApprox(X_WB * before[i].X_WG, 1e-9)) << i;
    EXPECT_LT((after[i].lift_aside_m - R_WB * before[i].lift_aside_m).norm(), 1e-12) << i;
    aside += before[i].lift_aside_m.norm() > 0.001;
  }
  EXPECT_GT(aside, 0);
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
