#include "eval/look_scene.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/replay.h"
#include "eval/replay_files.h"
#include "eval/report_views.h"
#include "scenes/check.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed {
namespace {

using testing::HasSubstr;

// Poses that are wrong at times, so that there are lost picks and parts pushed about.
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

class LookScene : public testing::Test {
 protected:
  explicit LookScene(const ScenarioSpec& spec = NoisyCubes(6)) : spec_(spec) {}
  Scene Make(const TrialResult& trial, size_t look) {
    return SceneOfLook(trial, look, {cell_, gripper_, spec_.policy.success});
  }
  ScenarioSpec spec_;
  VirtualCell cell_{spec_, EasyCube()};
  GripperSpec gripper_ = LoadGripper(spec_.gripper);
};

TEST_F(LookScene, OfALaterLookIsWhatThePicksBeforeLeft) {
  int after_loss = 0;
  for (const int number : {0, 1}) {
    const TrialResult trial = TrialRunner(spec_, EasyCube()).Run(number);
    ASSERT_GE(trial.picks.size(), 3u);
    for (size_t look = 0; look < trial.picks.size(); ++look) {
      EXPECT_EQ(HashOf(Make(trial, look)), trial.picks[look].hashes[TrialStage::kScene]) << look;
      after_loss += look > 0 && trial.picks[look - 1].loss != Loss::kNone;
    }
  }
  EXPECT_GT(after_loss, 0) << "the case did not occur";
}

TEST_F(LookScene, ThatIsNotTheRecordedOneIsRefused) {
  TrialResult trial = TrialRunner(spec_, EasyCube()).Run(0);
  trial.picks[1].hashes[TrialStage::kScene] ^= 1;
  EXPECT_NO_THROW(Make(trial, 0));
  EXPECT_THAT(ErrorOf([&] { Make(trial, 1); }),
              HasSubstr("the scene of trial 0, look 1 cannot be made again"));
  // A record without hashes tells by where its poses stand.
  trial.picks[1].hashes = {};
  EXPECT_NO_THROW(Make(trial, 1));
  for (HypothesisScore& score : trial.picks[1].hypotheses) score.X_WO.translation().x() += 1e-3;
  EXPECT_THAT(ErrorOf([&] { Make(trial, 1); }), HasSubstr("cannot be made again"));
}

struct OccludedLookScene : LookScene {
  OccludedLookScene() : LookScene(OccludedCubes()) {}
};

TEST_F(OccludedLookScene, IsThatOfItsBand) {
  const TrialResult trial = TrialRunner(spec_, EasyCube()).Run(0);
  ASSERT_EQ(trial.picks.size(), 3u);
  size_t parts = 0;
  for (size_t look = 0; look < 3; ++look) {
    const Scene scene = Make(trial, look);
    EXPECT_EQ(HashOf(scene), trial.picks[look].hashes[TrialStage::kScene]);
    EXPECT_GE(scene.objects.size(), parts);
    parts = scene.objects.size();
  }
  EXPECT_GT(parts, 4u) << "no blocker lies there";
  ViewMaker views(spec_, EasyCube(), {});
  EXPECT_NE(views.Glb(trial, 0), views.Glb(trial, 2));
}

TEST_F(OccludedLookScene, AReplayIsTheSameAndWritesAllLooks) {
  RecordedTrial recorded;
  recorded.spec = spec_;
  recorded.objects = EasyCube();
  recorded.result = TrialRunner(spec_, EasyCube()).Run(1);
  const TemporaryFolder folder;
  StageFiles files(folder.path());
  const ReplayReport report = ReplayTrial(recorded, &files, {});
  EXPECT_EQ(report.FirstDifference(), nullptr);
  EXPECT_EQ(report.stages.size(), 5 * recorded.result.picks.size());
  for (const PickRecord& look : recorded.result.picks) {
    for (const char* what : {"color.png", "overlay.png", "after.png", "scene.glb", "cloud.ply"}) {
      EXPECT_TRUE(
          std::filesystem::exists(folder.path() / fmt::format("look_{:02}_{}", look.pick, what)));
    }
  }
  recorded.spec.occlusion.scatter_diameters = 0.1;
  EXPECT_NE(ReplayTrial(recorded, nullptr, {}).FirstDifference(), nullptr);
}

}  // namespace
}  // namespace pickbed
