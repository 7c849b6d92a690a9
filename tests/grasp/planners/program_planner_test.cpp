#include "grasp/planners/program_planner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grasp/execute/execute.h"
#include "grasp/grippers/table.h"
#include "scenes/base/files.h"
#include "sim/render/renderer.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/error_of.h"
#include "tests/support/plugin_scripts.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;

class ProgramPlannerTest : public testing::Test {
 protected:
  ProgramPlannerTest() {
    frame_.intrinsics = {64, 48, 60, 60, 31.5, 23.5};
    frame_.depth_m = Image<float>(64, 48, 0.8f);
  }

  // A planner whose function has this body, indented by four spaces.
  PlannerSetup SetupOf(const std::string& body) {
    PlannerSetup setup{{}, tools_, objects_, candidates_, {}};
    setup.spec.command = PythonCommand(
        folder_, "planner.py",
        "import os, time\nimport numpy as np\nimport pickbed_plugin as pb\n@pb.planner\n"
        "def tested(frame, poses):\n    X = np.eye(4)\n" +
            body + "\npb.serve()\n");
    setup.intrinsics = frame_.intrinsics;
    return setup;
  }

  TemporaryFolder folder_;
  RgbdFrame frame_;
  std::vector<std::shared_ptr<const Gripper>> tools_{LoadGripper("jaw_8cm")};
  ObjectSet objects_{BoxObject({0.03, 0.04, 0.05}, 0.1)};
  std::vector<std::vector<std::vector<GraspCandidate>>> candidates_;
  const std::vector<EstimatedPose> poses_{{ObjectId(0), Translation({0, 0, 0.1}), 0.5},
                                          {ObjectId(0), Translation({0.1, 0, 0.02}), 0.5}};
};

TEST_F(ProgramPlannerTest, ProgramWithoutPosesKnowsNoObject) {
  ProgramPlanner planner(SetupOf("    assert poses is None and not frame.setup.objects\n"
                                 "    return [pb.Grasp(X, 0.01, s) for s in (0.2, 0.8, 0.5)]"),
                         false);
  PlannerInput input{frame_, Pose::Identity(), std::nullopt};
  input.max_grasps = 2;
  const PlanResult plan = planner.Plan(input);
  ASSERT_FALSE(plan.failure) << plan.failure->text;
  ASSERT_EQ(plan.grasps.size(), 2u);
  EXPECT_EQ(plan.grasps[0].score, 0.8);
  EXPECT_EQ(plan.grasps[1].score, 0.5);
  EXPECT_EQ(plan.grasps[0].hypothesis, kNoHypothesis);
  EXPECT_THAT(plan.rejected, ElementsAre(Pair("outranked", 1)));
}

TEST_F(ProgramPlannerTest, GraspsOnPosesNameATarget) {
  ProgramPlanner planner(SetupOf("    assert len(poses) == 2 and len(frame.setup.objects) == 1\n"
                                 "    return [pb.Grasp(X, 0.01, 0.9),\n"
                                 "            pb.Grasp(X, 0.01, 0.8, pose=0),\n"
                                 "            pb.Grasp(X, 0.01, 0.7, pose=1)]"),
                         true);
  const std::vector<int> targets{1};
  PlannerInput input{frame_, Pose::Identity(), std::nullopt};
  input.poses = poses_;
  input.targets = targets;
  const PlanResult plan = planner.Plan(input);
  ASSERT_FALSE(plan.failure) << plan.failure->text;
  ASSERT_EQ(plan.grasps.size(), 1u);
  EXPECT_EQ(plan.grasps[0].hypothesis, 1);
  EXPECT_THAT(plan.rejected, ElementsAre(Pair("names no pose", 1), Pair("on another pose", 1)));
}

TEST_F(ProgramPlannerTest, TheProgramKnowsGrippersPosesAndBin) {
  tools_ = {LoadGripper("jaw_8cm"), LoadGripper("cup_30mm")};
  ProgramPlanner planner(
      SetupOf("    tools = frame.setup.grippers\n"
              "    assert [g.mechanism for g in tools] == ['parallel_jaw', 'suction_cup']\n"
              "    assert abs(tools[0].max_opening_m - 0.08) < 0.01\n"
              "    X[:3, 3] = (frame.X_WC @ np.append(poses[1].t_m, 1))[:3]\n"
              "    assert frame.X_CB is None or np.allclose((frame.X_WC @ frame.X_CB)[:3, 3], "
              "[0.01, 0, 0])\n"
              "    return [pb.Grasp(X, 0.02, -7, pose=0),\n"
              "            pb.Grasp(X, 0.03, -1.5, 'cup_30mm', 1 if frame.X_CB is None else 0)]"),
      true);
  EXPECT_EQ(planner.identity().name, "tested");
  PlannerInput input{frame_, LookAt({0.1, -0.2, 0.8}, {0, 0, 0}, Eigen::Vector3d::UnitZ()),
                     std::nullopt};
  input.poses = poses_;
  PlanResult plan = planner.Plan(input);
  ASSERT_FALSE(plan.failure) << plan.failure->text;
  ASSERT_EQ(plan.grasps.size(), 2u);
  EXPECT_EQ(plan.grasps[0].tool, "cup_30mm") << "scores have any scale";
  EXPECT_EQ(plan.grasps[0].hypothesis, 1);
  EXPECT_EQ(plan.grasps[0].width_m, 0.03);
  EXPECT_TRUE(plan.grasps[0].X_WG.translation().isApprox(poses_[1].X_WO.translation(), 1e-9));
  EXPECT_EQ(plan.grasps[1].tool, "jaw_8cm");
  const Bin bin;
  input.bin.emplace(BinPlacement{bin, Translation({0.01, 0, 0})});
  plan = planner.Plan(input);
  ASSERT_FALSE(plan.failure) << plan.failure->text;
  EXPECT_EQ(plan.grasps[0].hypothesis, 0);
}

TEST_F(ProgramPlannerTest, AWrongAnswerIsNamed) {
  ProgramPlanner planner(SetupOf("    X[0, 0] = -1\n    return [pb.Grasp(X, 0.01, 0.2)]"), false);
  const PlanResult plan = planner.Plan({frame_, Pose::Identity(), std::nullopt});
  ASSERT_TRUE(plan.failure);
  EXPECT_TRUE(plan.failure->is_malformed);
  EXPECT_THAT(plan.failure->text, HasSubstr("planner 'tested' gave a wrong grasp (number 0): X_WG "
                                            "is a reflection"));
}

TEST_F(ProgramPlannerTest, AnEstimatorIsNoPlanner) {
  PlannerSetup setup = SetupOf("    return []");
  setup.spec.command = PythonCommand(folder_, "estimator.py", EstimatorCode("    return []"));
  EXPECT_THAT(ErrorOf([&] { ProgramPlanner planner(setup, false); }),
              HasSubstr("is no planner, but has the roles [estimator]"));
}

TEST_F(ProgramPlannerTest, MissingInputsAreNamed) {
  PlannerSetup setup = SetupOf("    return []");
  setup.spec.command = PythonCommand(folder_, "needs.py",
                                     "import pickbed_plugin as pb\n@pb.planner(needs=['bin'])\n"
                                     "def tested(frame, poses):\n    return []\npb.serve()\n");
  ProgramPlanner planner(setup, false);
  EXPECT_THAT(ErrorOf([&] {
                planner.Plan({frame_, Pose::Identity(), std::nullopt});
              }),
              HasSubstr("planner 'tested' needs 'bin'; the pose of the bin is unknown"));
}

TEST_F(ProgramPlannerTest, FailureIsAResult) {
  PlannerSetup setup = SetupOf(
      "    if frame.seed == 1: os._exit(1)\n    if frame.seed == 2: time.sleep(60)\n"
      "    return [pb.Grasp(X, 0.01, 0.2)]");
  setup.spec.timeout_s = 0.5;
  ProgramPlanner planner(setup, false);
  PlannerInput input{frame_, Pose::Identity(), std::nullopt};
  const auto reason_of = [&](uint64_t seed) {
    input.seed = seed;
    const PlanResult plan = planner.Plan(input);
    EXPECT_THAT(plan.grasps, IsEmpty());
    EXPECT_FALSE(plan.failure.value().is_malformed);
    return plan.failure.value().reason;
  };
  EXPECT_EQ(reason_of(1), FailureReason::kPlannerCrashed);
  EXPECT_EQ(reason_of(2), FailureReason::kPlannerTimeout);
  input.seed = 3;
  EXPECT_EQ(planner.Plan(input).grasps.size(), 1u) << "the program is started again";
}

TEST_F(ProgramPlannerTest, MissingProgramIsRefused) {
  PlannerSetup setup = SetupOf("    return []");
  setup.spec.command = {"/no/such/program"};
  EXPECT_THAT(ErrorOf([&] { ProgramPlanner planner(setup, false); }),
              HasSubstr("/no/such/program"));
}

// The example plans on the depth image of separate boxes, and physics lifts one.
TEST(CloudGraspsExample, ItsBestGraspLiftsAnInstance) {
  const ObjectSet objects{BoxObject({0.03, 0.05, 0.04}, 0.1)};
  const Bin bin;
  Scene scene{bin, {}};
  for (int i = 0; i < 3; ++i) {
    const Eigen::AngleAxisd rotation(0.4 + i, Eigen::Vector3d::UnitZ());
    scene.objects.push_back(
        {InstanceId(i), ObjectId(0),
         MakePose(rotation.toRotationMatrix(), {0.1 * (i - 1), 0.02 * i, 0.02})});
  }
  const Camera camera(CameraIntrinsics(),
                      LookAt({0, -0.1, 0.8}, {0, 0, 0}, Eigen::Vector3d::UnitZ()));
  const RenderedImage image = SceneRenderer(objects, bin).Render(scene, camera);
  const RgbdFrame frame{camera.intrinsics, image.color, image.depth_m};
  const std::vector<std::shared_ptr<const Gripper>> tools{LoadGripper("jaw_8cm")};
  const std::vector<std::vector<std::vector<GraspCandidate>>> candidates;
  PlannerSetup setup{{}, tools, objects, candidates, {}};
  setup.spec.command = {kPython, (PythonDir() / "examples/cloud_grasps.py").string()};
  setup.intrinsics = camera.intrinsics;
  setup.bin = bin;
  const PlanResult plan =
      ProgramPlanner(setup, false).Plan({frame, camera.X_WC(), BinPlacement{bin}});
  ASSERT_GE(plan.grasps.size(), 3u) << (plan.failure ? plan.failure->text : "");
  const GraspOutcome outcome =
      ExecuteGrasp(scene, objects, plan.grasps.front(), *tools[0], GraspTarget()).outcome;
  EXPECT_EQ(outcome.instances_lifted, 1) << FailureName(outcome.failure);
}

}  // namespace
}  // namespace pickbed::tests
