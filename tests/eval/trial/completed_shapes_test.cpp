// Trials that pick unknown objects on completed shapes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/shapes/completion_choice.h"
#include "eval/shapes/segment_shapes.h"
#include "eval/sweep/run.h"
#include "eval/trial/trial.h"
#include "scenes/base/files.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TrialResult RunOnShapes(const std::string& planner, const std::string& completion) {
  ScenarioSpec spec = CubeScenario(2);
  spec.planner.name = planner;
  spec.planner.completion = completion;
  return TrialRunner(spec, EasyCube()).Run(BinIndex(0));
}

TEST(CompletedShapes, CubesAreClearedOnTheirTrueShapes) {
  const TrialResult result = RunOnShapes("completed", kTrueShapes);
  EXPECT_EQ(result.instances_cleared, 2);
  for (const AttemptRecord& attempt : result.attempts) {
    EXPECT_TRUE(attempt.pose_free);
    EXPECT_TRUE(attempt.hypotheses.empty());
  }
}

TEST(CompletedShapes, EqualSeedsGiveEqualGrasps) {
  const TrialResult a = RunOnShapes("skirt", "truth"), b = RunOnShapes("skirt", "truth");
  ASSERT_EQ(a.attempts.size(), b.attempts.size());
  ASSERT_FALSE(a.attempts.empty());
  for (size_t i = 0; i < a.attempts.size(); ++i) {
    EXPECT_EQ(a.attempts[i].hashes, b.attempts[i].hashes);
  }
}

TEST(CompletedShapes, ASuctionCupPicksThem) {
  ScenarioSpec spec = CubeScenario(2);
  spec.planner.name = "completed";
  spec.planner.completion = kTrueShapes;
  spec.gripper = "cup_20mm_long";
  EXPECT_EQ(TrialRunner(spec, EasyCube()).Run(BinIndex(0)).instances_cleared, 2);
}

// A trial that ends with an error must not leave the ground truth of its image behind.
TEST(CompletedShapes, TheTruthOfAnImageIsForgottenAfterAnError) {
  SegmentShapes shapes("convexity", kTrueShapes);
  SyntheticDepth depth(SmallCamera());
  depth.AddSphere({0.05, 0.02, 0.6}, 0.04);
  const grasp::PlannerInput input{depth.frame(), Pose::Identity(), std::nullopt, {}, {}, 1, 0};
  const Scene scene;
  const Image<uint16_t> ids;
  try {
    const TruthOfImage given(&shapes, {scene, EasyCube(), ids});
    throw InputError("a planner that fails");
  } catch (const InputError&) {
  }
  EXPECT_THAT(ErrorOf([&] { shapes.Shapes(input, 10); }), HasSubstr("truth"));
}

// A run must not resume with another model.
TEST(CompletedShapes, TheModelIsPartOfTheIdentityOfARun) {
  ScenarioSpec spec = CubeScenario(2);
  spec.planner.name = "completed";
  const auto identity = [&](const std::string& completion) {
    spec.planner.completion = completion;
    return RunIdentity(spec, EasyCube());
  };
  EXPECT_THAT(identity("network"), HasSubstr("\n# completion "));
  EXPECT_THAT(identity("skirt"), Not(HasSubstr("# completion ")));
  EXPECT_THAT(identity(kTrueShapes), Not(HasSubstr("# completion ")));
  EXPECT_THAT(identity("vae"), HasSubstr("\n# completion "));
  spec.planner.name = "skirt";
  EXPECT_THAT(identity("network"), Not(HasSubstr("# completion ")));
}

// The same path with another content is another model.
TEST(CompletedShapes, AnotherModelInTheSameFileIsAnotherIdentity) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.net";
  ScenarioSpec spec = CubeScenario(2);
  const auto changes = [&] {
    WriteFileAtomically(file, "first");
    const std::string first = RunIdentity(spec, EasyCube());
    WriteFileAtomically(file, "second");
    return RunIdentity(spec, EasyCube()) != first;
  };
  spec.planner.completion = file;
  EXPECT_FALSE(changes()) << "planner poses reads none";
  spec.planner.name = "completed";
  EXPECT_TRUE(changes());
  spec = CubeScenario(2);
  spec.estimator.completion_model = file;
  EXPECT_FALSE(changes()) << "no method reads it";
  spec.estimator.completion = "network";
  EXPECT_TRUE(changes());
}

// A model that was trained with `pickbed train completion` completes the shapes of a planner.
TEST(CompletedShapes, AModelFileIsAMethod) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "mine.net";
  std::filesystem::copy_file(AssetsDir() / "models/completion.net", file);
  EXPECT_EQ(CompletionNamed(file).method, "network");
  EXPECT_EQ(CompletionNamed(file).model, file);
  const TrialResult own = RunOnShapes("completed", file);
  const TrialResult shipped = RunOnShapes("completed", "network");
  ASSERT_FALSE(own.attempts.empty());
  EXPECT_EQ(own.attempts.front().hashes, shipped.attempts.front().hashes);
  EXPECT_THAT(ErrorOf([&] { RunOnShapes("completed", folder.path() / "none.net"); }),
              AllOf(HasSubstr("planner.completion"), HasSubstr("none.net")));
}

// The same path with another content is another network.
TEST(CompletedShapes, TheNetworkForGraspsIsPartOfTheIdentityOfARun) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.net";
  ScenarioSpec spec = CubeScenario(2);
  spec.planner.name = "completed";
  const auto identity = [&](const std::string& model) {
    spec.planner.success_model = model;
    return RunIdentity(spec, EasyCube());
  };
  EXPECT_THAT(identity(kNoSuccessModel), Not(HasSubstr("# success model ")));
  WriteFileAtomically(file, "first");
  const std::string first = identity(file);
  EXPECT_THAT(first, HasSubstr("\n# success model "));
  WriteFileAtomically(file, "second");
  EXPECT_NE(identity(file), first);
  spec.planner.name = "cloud_antipodal";
  EXPECT_THAT(identity(file), Not(HasSubstr("# success model "))) << "it reads none";
}

TEST(CompletedShapes, AnUnknownMethodIsNamedWithItsSetting) {
  EXPECT_THAT(ErrorOf([] { RunOnShapes("completed", "magic"); }),
              AllOf(HasSubstr("planner.completion"), HasSubstr("skirt"), HasSubstr("truth")));
  ScenarioSpec spec = CubeScenario(1);
  spec.planner.name = "skirt";
  spec.planner.segmentation = "magic";
  EXPECT_THAT(ErrorOf([&] { TrialRunner(spec, EasyCube()).Run(BinIndex(0)); }),
              HasSubstr("planner.segmentation"));
}

}  // namespace
}  // namespace pickbed::tests
