// Several picks after one image.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "eval/summary/run_summary.h"
#include "eval/trial/observer.h"
#include "eval/trial/trial.h"
#include "scenes/scenario/find_scenario.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

ScenarioSpec PicksPerImage(int instances, int picks) {
  ScenarioSpec spec = CubeScenario(instances);
  spec.policy.picks_per_image = picks;
  return spec;
}

TrialResult RunCubes(const ScenarioSpec& spec, TrialObserver* observer = nullptr) {
  return TrialRunner(spec, EasyCube()).Run(BinIndex{0}, observer);
}

// Pose of each instance before each attempt.
class ScenesBefore : public TrialObserver {
 public:
  void OnStage(TrialStage stage, const AttemptState& attempt) override {
    if (stage != TrialStage::kScene) return;
    auto& poses = poses_.emplace_back();
    for (const PosedObject& posed : attempt.scene.objects) poses[posed.instance] = posed.X_WO;
  }
  const Pose& Of(int attempt, int instance) const { return poses_.at(attempt).at(instance); }

 private:
  std::vector<std::map<int, Pose>> poses_;
};

TEST(ImagePickTrial, OneImageServesSeveralPicksOfInstancesThatDidNotMove) {
  ScenesBefore scenes;
  const TrialResult result = RunCubes(PicksPerImage(8, 3), &scenes);
  EXPECT_EQ(result.instances_cleared, 8);
  int image = 0, further = 0;
  for (const AttemptRecord& attempt : result.attempts) {
    if (attempt.has_own_image()) image = attempt.attempt;
    EXPECT_EQ(attempt.pick_of_image, attempt.attempt - image);
    EXPECT_LT(attempt.pick_of_image, 3);
    EXPECT_EQ(attempt.instances.size(), 8u - attempt.attempt) << "no instance that was picked";
    if (attempt.pick_of_image == 0) continue;
    ++further;
    const int target = attempt.matched_instance;
    EXPECT_EQ(scenes.Of(image, target).matrix(), scenes.Of(attempt.attempt, target).matrix());
  }
  EXPECT_GE(further, 3) << "the case did not occur";
}

TEST(ImagePickTrial, DefaultCapturesAnImageForEachPick) {
  const TrialResult result = RunCubes(CubeScenario(4));
  ASSERT_GT(result.attempts.size(), 1u);
  for (const AttemptRecord& attempt : result.attempts) {
    EXPECT_TRUE(attempt.has_own_image());
  }
}

// Cubes of 2.5 kg with little friction slip, so each attempt fails.
TEST(ImagePickTrial, FailedPickIsFollowedByANewImage) {
  ScenarioSpec spec = PicksPerImage(4, 3);
  spec.policy.max_failures_in_row = 3;
  const TrialResult result = TrialRunner(spec, {Cube(0.05, 5, 0.2)}).Run(BinIndex{0});
  ASSERT_GE(result.attempts.size(), 2u);
  for (const AttemptRecord& attempt : result.attempts) {
    EXPECT_NE(attempt.failure, FailureReason::kNone);
    EXPECT_TRUE(attempt.has_own_image());
  }
}

TEST(ImagePickTrial, ImagesAreCountedOnce) {
  const TrialResult result = RunCubes(PicksPerImage(8, 3));
  std::vector<TrialResult> only_images{result};
  std::erase_if(only_images[0].attempts,
                [](const AttemptRecord& attempt) { return !attempt.has_own_image(); });
  const RunSummary all = Summarize({result}, {1, 2, 6}), images = Summarize(only_images);
  EXPECT_EQ(all.images, images.images);
  EXPECT_LT(all.images, all.executed_grasps);
  EXPECT_EQ(all.frames, images.frames);
  EXPECT_EQ(all.recall.samples, images.recall.samples);
  EXPECT_EQ(all.precision.samples, images.precision.samples);
  EXPECT_EQ(all.in_view, images.in_view);
  EXPECT_EQ(all.executed_grasps, 8);
  // One capture and one estimate for all picks of an image.
  EXPECT_DOUBLE_EQ(all.cycle.sense_s, all.images / 8.0);
  EXPECT_DOUBLE_EQ(all.cycle.compute_s, 2 * all.images / 8.0);
  EXPECT_DOUBLE_EQ(all.cycle.move_s, 6);
}

TEST(ImagePickTrial, ScenarioRefusesContradictions) {
  const auto load = [](const std::string& more) {
    return ErrorOf(
        [&] { LoadScenarioText("objects: [{name: rod, count: 2}]\n" + more, ".", "test.yaml"); });
  };
  EXPECT_THAT(load("policy: {picks_per_image: 0}\n"),
              HasSubstr("test.yaml:2: policy.picks_per_image = 0"));
  EXPECT_THAT(load("cycle: {overlap: true, move_s: 1}\n"), HasSubstr("cycle.in_bin_s = 2"));
  EXPECT_THAT(load("policy: {retention_g: 0.5}\n"), HasSubstr("policy.retention_g = 0.5"));
  EXPECT_EQ(load("policy: {retention_g: 0.5, retention_load: lateral}\n"), "no error");
  EXPECT_THAT(load("policy: {picks_per_image: 2}\nocclusion: {enabled: true}\n"),
              HasSubstr("own scene and image"));
}

}  // namespace
}  // namespace pickbed::tests
