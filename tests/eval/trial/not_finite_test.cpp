// Values that are not finite do not pass from one stage to the next. The timings count them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "eval/trial/trial.h"
#include "eval/trial/trial_setup.h"
#include "perception/cloud/organized_cloud.h"
#include "perception/icp/final_refinement.h"
#include "perception/model/model_points.h"
#include "scenes/base/finite_counts.h"
#include "tests/eval/cube_scenario.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

// Returns three grasps that no hand can reach.
class BrokenPlanner : public Planner {
 public:
  PlanResult Plan(const PlannerInput&) override {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    PlanResult plan;
    Grasp grasp;
    grasp.hypothesis = kNoHypothesis;
    plan.grasps.assign(3, grasp);
    plan.grasps[0].X_WG.translation().x() = kNaN;
    plan.grasps[1].width_m = std::numeric_limits<double>::infinity();
    plan.grasps[2].score = kNaN;
    return plan;
  }
};

// A refiner whose poses are not finite.
class BrokenRefiner : public PoseRefiner {
 public:
  void Visit(SettingsVisitor&) override {}
  RefinePose ForFrame(const OrganizedCloud&) const override {
    return [](const ModelPoints&, const Pose& X_CO) {
      IcpResult result;
      result.status = IcpStatus::kRefined;
      result.X_CO = X_CO;
      result.X_CO.translation().z() = std::numeric_limits<double>::quiet_NaN();
      return result;
    };
  }
};

// Measures an image with planted readings that are not finite, and refines two poses in it.
class PlannerOnBrokenImages : public Planner {
 public:
  static constexpr int kNoNumber = 7, kInfinite = 4, kPoses = 2;

  PlanResult Plan(const PlannerInput& input) override {
    RgbdFrame frame = input.frame;
    for (int x = 0; x < kNoNumber; ++x) {
      frame.depth_m(x, 0) = std::numeric_limits<float>::quiet_NaN();
    }
    for (int x = 0; x < kInfinite; ++x) {
      frame.depth_m(x, 1) = std::numeric_limits<float>::infinity();
    }
    const OrganizedCloud cloud = BuildCloud(frame, std::nullopt);
    const std::vector<ModelPoints> models = {MakeModelPoints(*EasyCube().front(), 50, 20)};
    std::vector<PoseHypothesis> poses(kPoses);
    for (PoseHypothesis& pose : poses) pose.X_CO = Translation({0, 0, 0.8});
    RefineFinally(BrokenRefiner(), cloud, models, 1, poses);
    for (const PoseHypothesis& pose : poses) {
      EXPECT_EQ(pose.X_CO.matrix(), Translation({0, 0, 0.8}).matrix()) << "it is not refined";
    }
    return {};
  }
};

TEST(NotFinite, ReadingsAndRefinedPosesAreCountedInTheTimingsOfTheTrial) {
  ScenarioSpec spec = CubeScenario(1);
  spec.planner.name = "cloud_antipodal";
  TrialSetup setup(spec, EasyCube(), {}, {});
  setup.planner = std::make_unique<PlannerOnBrokenImages>();
  TakeNotFiniteCounts();
  const TrialResult result = RunTrial(setup, BinIndex(0), nullptr);
  const auto images = static_cast<double>(result.attempts.size());
  ASSERT_GT(images, 0);
  const auto count_of = [&](const std::string& boundary) {
    const auto found = result.seconds.find("not_finite/" + boundary);
    return found == result.seconds.end() ? 0 : found->second;
  };
  using Planted = PlannerOnBrokenImages;
  EXPECT_EQ(count_of("depth"), images * (Planted::kNoNumber + Planted::kInfinite));
  EXPECT_EQ(count_of("refined_poses"), images * Planted::kPoses);
  for (const char* other : {"points", "normals", "scores", "poses", "grasps"}) {
    EXPECT_EQ(count_of(other), 0) << other;
  }
}

TEST(NotFinite, SoundTrialsHaveNoCounter) {
  TrialSetup setup(CubeScenario(1), EasyCube(), {}, {});
  TakeNotFiniteCounts();
  const TrialResult result = RunTrial(setup, BinIndex(0), nullptr);
  ASSERT_FALSE(result.attempts.empty());
  for (const auto& [stage, seconds] : result.seconds) EXPECT_FALSE(IsNotFiniteCount(stage));
}

TEST(NotFinite, GraspsAreDroppedAndCounted) {
  ScenarioSpec spec = CubeScenario(2);
  spec.planner.name = "cloud_antipodal";
  TrialSetup setup(spec, EasyCube(), {}, {});
  setup.planner = std::make_unique<BrokenPlanner>();
  TakeNotFiniteCounts();
  const TrialResult result = RunTrial(setup, BinIndex(0), nullptr);
  ASSERT_FALSE(result.attempts.empty());
  for (const AttemptRecord& attempt : result.attempts) EXPECT_FALSE(attempt.grasp.has_value());
  ASSERT_TRUE(result.seconds.contains("not_finite/grasps"));
  EXPECT_EQ(result.seconds.at("not_finite/grasps"),
            3 * static_cast<double>(result.attempts.size()));
  EXPECT_TRUE(TakeNotFiniteCounts().empty());
}

}  // namespace
}  // namespace pickbed::tests
