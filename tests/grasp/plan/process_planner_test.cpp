#include "grasp/plan/process_planner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grasp/execute/execute.h"
#include "grasp/grippers/table.h"
#include "sim/render/renderer.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/error_of.h"
#include "tests/support/plugin_scripts.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

class ProcessPlannerTest : public testing::Test {
 protected:
  ProcessPlannerTest() {
    frame_.intrinsics = {64, 48, 60, 60, 31.5, 23.5};
    frame_.depth_m = Image<float>(64, 48, 0.8f);
    setup_.objects = {BoxObject({0.03, 0.04, 0.05}, 0.1)};
    setup_.grippers = {LoadGripper("jaw_8cm"), LoadGripper("cup_30mm")};
    setup_.intrinsics = frame_.intrinsics;
    setup_.mesh_dir = folder_.path() / "meshes";
  }

  ProcessPlanner Make(const std::string& body) {
    setup_.address.command =
        PythonCommand(folder_, "planner.py",
                      "import os\nimport numpy as np\nimport pickbed_plugin as pb\n@pb.planner\n"
                      "def tested(frame, poses):\n    X = np.eye(4)\n" +
                          body + "\npb.serve()\n");
    return ProcessPlanner(setup_);
  }

  TemporaryFolder folder_;
  RgbdFrame frame_;
  ProcessPlannerSetup setup_;
};

TEST_F(ProcessPlannerTest, GraspsAreRankedAndNameTheirToolAndPose) {
  ProcessPlanner planner = Make(
      "    assert [g.mechanism for g in frame.setup.grippers] == ['parallel_jaw', 'suction_cup']\n"
      "    assert abs(frame.setup.grippers[0].max_opening_m - 0.08) < 0.01\n"
      "    X[:3, 3] = (frame.X_WC @ np.append(poses[1].t_m, 1))[:3]\n"
      "    return [pb.Grasp(np.eye(4), 0.01, 0.2), pb.Grasp(X, 0.03, 0.8, 'cup_30mm', 1)]");
  EXPECT_EQ(planner.identity().name, "tested");
  const std::vector<EstimatedPose> poses{{ObjectId(0), Translation({0, 0, 0.1}), 0.5},
                                         {ObjectId(0), Translation({0.1, 0, 0.02}), 0.5}};
  ProcessPlannerInput input{frame_};
  input.X_WC = LookAt({0.1, -0.2, 0.8}, {0, 0, 0}, Eigen::Vector3d::UnitZ());
  input.poses = poses;
  const ProcessPlan plan = planner.Plan(input);
  ASSERT_EQ(plan.grasps.size(), 2u) << plan.text;
  EXPECT_EQ(plan.grasps[0].tool, "cup_30mm");
  EXPECT_EQ(plan.grasps[0].hypothesis, 1);
  EXPECT_EQ(plan.grasps[0].width_m, 0.03);
  EXPECT_TRUE(plan.grasps[0].X_WG.translation().isApprox(poses[1].X_WO.translation(), 1e-9));
  EXPECT_EQ(plan.grasps[1].tool, "jaw_8cm");
  EXPECT_EQ(plan.grasps[1].hypothesis, -1);
}

TEST_F(ProcessPlannerTest, WithoutPosesThePlannerGetsNone) {
  ProcessPlanner planner = Make(
      "    return [pb.Grasp(X, 0.01, 0.2)] if poses is None and frame.X_CB is not None else []");
  EXPECT_EQ(planner.Plan({frame_}).grasps.size(), 1u);
  ProcessPlannerInput input{frame_};
  input.poses = std::span<const EstimatedPose>();
  EXPECT_EQ(planner.Plan(input).grasps.size(), 0u) << "no pose was found";
}

TEST_F(ProcessPlannerTest, AFailureCostsOneImage) {
  ProcessPlanner planner = Make(
      "    if frame.seed == 1: os._exit(1)\n    if frame.seed == 2: X[0, 0] = -1\n"
      "    return [pb.Grasp(X, 0.01, 0.2)]");
  ProcessPlannerInput input{frame_};
  input.seed = 1;
  EXPECT_EQ(planner.Plan(input).fault, PluginFault::kCrashed);
  input.seed = 2;
  const ProcessPlan wrong = planner.Plan(input);
  EXPECT_EQ(wrong.fault, PluginFault::kMalformed);
  EXPECT_THAT(wrong.text, HasSubstr("planner 'tested' gave a wrong grasp (number 0): X_WG is a "
                                    "reflection"));
  input.seed = 3;
  EXPECT_EQ(planner.Plan(input).grasps.size(), 1u);
}

TEST_F(ProcessPlannerTest, AnEstimatorIsNoPlanner) {
  setup_.address.command = PythonCommand(folder_, "estimator.py", EstimatorCode("    return []"));
  EXPECT_THAT(ErrorOf([&] { ProcessPlanner planner(setup_); }),
              HasSubstr("is no planner, but has the roles [estimator]"));
}

// The example plans on the depth image of separate boxes, and physics lifts one.
TEST(CloudGraspsExample, ItsBestGraspLiftsAnInstance) {
  const TemporaryFolder folder;
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
  const auto jaw = LoadGripper("jaw_8cm");
  ProcessPlannerSetup setup;
  setup.address.command = {kPython, (PythonDir() / "examples/cloud_grasps.py").string()};
  setup.objects = objects;
  setup.grippers = {jaw};
  setup.intrinsics = camera.intrinsics;
  setup.bin = bin;
  setup.mesh_dir = folder.path();
  ProcessPlannerInput input{frame};
  input.X_WC = camera.X_WC();
  const ProcessPlan plan = ProcessPlanner(setup).Plan(input);
  ASSERT_GE(plan.grasps.size(), 3u) << plan.text;
  const GraspOutcome outcome =
      ExecuteGrasp(scene, objects, plan.grasps.front(), *jaw, GraspTarget()).outcome;
  EXPECT_EQ(outcome.instances_lifted, 1) << FailureName(outcome.failure);
}

}  // namespace
}  // namespace pickbed::tests
