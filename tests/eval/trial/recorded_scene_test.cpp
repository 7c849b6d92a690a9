#include "eval/trial/recorded_scene.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/replay/replay.h"
#include "eval/replay/stage_files.h"
#include "eval/report/views_3d.h"
#include "grasp/grippers/tools.h"
#include "scenes/base/error.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// Noisy poses, so that some picks fail and displace instances.
ScenarioSpec NoisyCubes(int count) {
  ScenarioSpec spec = CubeScenario(count);
  spec.estimator.noise_mm = 7;
  spec.policy.max_failures_in_row = 4;
  return spec;
}

ScenarioSpec OccludedCubes() {
  ScenarioSpec spec = CubeScenario(4);
  spec.occlusion.enabled = true;
  spec.occlusion.bands = {{0.3, 0.6}, {0.6, 0.9}, {0.9, 1}};
  return spec;
}

class RecordedSceneTest : public testing::Test {
 protected:
  explicit RecordedSceneTest(const ScenarioSpec& spec = NoisyCubes(6)) : spec_(spec) {}
  Scene Make(const TrialResult& trial, size_t attempt) {
    return SceneOfAttempt(trial, attempt, {cell_, tools_, spec_.policy.success});
  }
  ScenarioSpec spec_;
  SimulatedCell cell_{spec_, EasyCube()};
  Tools tools_ = LoadTools(spec_.gripper.names);
};

TEST_F(RecordedSceneTest, LaterAttemptHasTheSceneLeftByEarlierPicks) {
  int after_failure = 0;
  for (const int number : {0, 1}) {
    const TrialResult trial = TrialRunner(spec_, EasyCube()).Run(BinIndex(number));
    ASSERT_GE(trial.attempts.size(), 3u);
    for (size_t attempt = 0; attempt < trial.attempts.size(); ++attempt) {
      EXPECT_EQ(HashOf(Make(trial, attempt)), trial.attempts[attempt].hashes[TrialStage::kScene])
          << attempt;
      after_failure += attempt > 0 && trial.attempts[attempt - 1].failure != FailureReason::kNone;
    }
  }
  EXPECT_GT(after_failure, 0) << "the case did not occur";
}

TEST_F(RecordedSceneTest, SceneThatDiffersFromTheRecordIsRefused) {
  TrialResult trial = TrialRunner(spec_, EasyCube()).Run(BinIndex{0});
  trial.attempts[1].hashes[TrialStage::kScene] ^= 1;
  EXPECT_NO_THROW(Make(trial, 0));
  EXPECT_THAT(ErrorOf([&] { Make(trial, 1); }),
              HasSubstr("the scene of trial 0, attempt 1 cannot be reproduced"));
  // Without hashes, the recorded hypothesis poses are compared with the scene.
  trial.attempts[1].hashes = {};
  EXPECT_NO_THROW(Make(trial, 1));
  for (HypothesisRecord& score : trial.attempts[1].hypotheses) score.X_WO.translation().x() += 1e-3;
  EXPECT_THAT(ErrorOf([&] { Make(trial, 1); }), HasSubstr("cannot be reproduced"));
}

struct RecordedOcclusionSceneTest : RecordedSceneTest {
  RecordedOcclusionSceneTest() : RecordedSceneTest(OccludedCubes()) {}
};

TEST_F(RecordedOcclusionSceneTest, EachAttemptHasTheSceneOfItsBand) {
  const TrialResult trial = TrialRunner(spec_, EasyCube()).Run(BinIndex{0});
  ASSERT_EQ(trial.attempts.size(), 3u);
  size_t instances = 0;
  for (size_t attempt = 0; attempt < 3; ++attempt) {
    const Scene scene = Make(trial, attempt);
    EXPECT_EQ(HashOf(scene), trial.attempts[attempt].hashes[TrialStage::kScene]);
    EXPECT_GE(scene.objects.size(), instances);
    instances = scene.objects.size();
  }
  EXPECT_GT(instances, 4u) << "the scene has no blocker";
  ViewMaker views(spec_, EasyCube(), {});
  EXPECT_NE(views.Glb(trial, 0), views.Glb(trial, 2));
}

// The record has neither hashes nor hypotheses to compare a scene with.
TEST_F(RecordedOcclusionSceneTest, BandThatTheSeriesDoesNotHaveIsRefused) {
  TrialResult trial = TrialRunner(spec_, EasyCube()).Run(BinIndex{0});
  trial.attempts[0].hashes = {};
  trial.attempts[0].hypotheses.clear();
  EXPECT_NO_THROW(Make(trial, 0));
  trial.attempts[0].band = 7;
  EXPECT_THAT(ErrorOf([&] { Make(trial, 0); }), HasSubstr("no scene for this band"));
}

TEST_F(RecordedOcclusionSceneTest, ReplayIsIdenticalAndWritesAllAttempts) {
  RecordedTrial recorded;
  recorded.spec = spec_;
  recorded.objects = EasyCube();
  recorded.result = TrialRunner(spec_, EasyCube()).Run(BinIndex{1});
  const TemporaryFolder folder;
  StageFiles files(folder.path());
  const ReplayReport report = ReplayTrial(recorded, &files, {});
  EXPECT_EQ(report.FirstDifference(), nullptr);
  EXPECT_EQ(report.stages.size(), 5 * recorded.result.attempts.size());
  for (const AttemptRecord& attempt : recorded.result.attempts) {
    for (const char* what : {"color.png", "overlay.png", "after.png", "scene.glb", "cloud.ply"}) {
      EXPECT_TRUE(std::filesystem::exists(folder.path() /
                                          fmt::format("attempt_{:02}_{}", attempt.attempt, what)));
    }
  }
  recorded.spec.occlusion.scatter_diameters = 0.1;
  EXPECT_NE(ReplayTrial(recorded, nullptr, {}).FirstDifference(), nullptr);
}

}  // namespace
}  // namespace pickbed::tests
