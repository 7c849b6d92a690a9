#include "eval/benchmark/completed_grasps.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

AttemptRecord GraspAttempt(int instance, FailureReason failure) {
  AttemptRecord attempt;
  attempt.pose_free = true;
  attempt.matched_instance = InstanceId(instance);
  attempt.grasp.emplace();
  attempt.failure = failure;
  return attempt;
}

InstanceOutcome DroppedInstance(int instance, int object) {
  InstanceOutcome outcome;
  outcome.instance = InstanceId(instance);
  outcome.object = ObjectId(object);
  return outcome;
}

TEST(CompletedGrasps, AGraspBelongsToTheShapeThatCameOrWasNearest) {
  TrialResult trial;
  trial.outcomes = {DroppedInstance(0, 0), DroppedInstance(1, 1), DroppedInstance(2, 1)};
  trial.attempts = {GraspAttempt(0, FailureReason::kNone), GraspAttempt(1, FailureReason::kSlipped),
                    GraspAttempt(2, FailureReason::kNone)};
  trial.attempts.emplace_back();  // found no grasp
  std::map<std::string, ShapeGrasps> shapes;
  AddTrial(trial, {"mug", "gear"}, shapes);
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(shapes["mug"].picked.hits, 1);
  EXPECT_EQ(shapes["mug"].picked.samples, 1);
  EXPECT_EQ(shapes["gear"].picked.hits, 1);
  EXPECT_EQ(shapes["gear"].picked.samples, 2);
  EXPECT_EQ(shapes["gear"].grasps.hits, 1);
  EXPECT_EQ(shapes["gear"].grasps.samples, 2);
}

// Eight shapes, each dropped four times. `completed` picks three of four, `skirt` one.
CompletedGrasps PlantedGrasps() {
  CompletedGrasps grasps;
  grasps.planners = {"completed", "skirt"};
  for (const char* condition : kGraspConditions) {
    for (int shape = 0; shape < 8; ++shape) {
      const std::string name = fmt::format("shape_{}", shape);
      const int more = shape % 2;
      grasps.shapes[condition]["completed"][name] = {{3, 5}, {2 + more, 4}};
      grasps.shapes[condition]["skirt"][name] = {{1, 5}, {1, 4}};
    }
  }
  return grasps;
}

TEST(CompletedGrasps, DifferencesArePairedByShape) {
  const CompletedGrasps planted = PlantedGrasps();
  const GraspRate skirt = GraspRateOf(planted, "single", "skirt", &ShapeGrasps::picked);
  EXPECT_EQ(skirt.rate.hits, 8);
  EXPECT_EQ(skirt.rate.samples, 32);
  EXPECT_LT(skirt.difference.high, 0);
  EXPECT_GT(skirt.difference.low, -0.6);
  EXPECT_EQ(GraspRateOf(planted, "bins", "completed", &ShapeGrasps::grasps).rate.samples, 40);
}

TEST(CompletedGrasps, FilesHaveOneLinePerPlannerAndPerShape) {
  const std::string csv = CompletedGraspsCsv(PlantedGrasps());
  EXPECT_THAT(csv, HasSubstr("\nsingle,completed,8,32,20,"));
  EXPECT_THAT(csv, HasSubstr("\nbins,skirt,8,32,8,"));
  EXPECT_THAT(CompletedGraspsShapesCsv(PlantedGrasps()),
              HasSubstr("\nbins,completed,shape_3,4,3,5,3\n"));
  EXPECT_THAT(CompletedGraspsText(PlantedGrasps()), HasSubstr("-37.5 ["));
}

TEST(CompletedGrasps, AllPlannersGetTheSameBins) {
  const auto file = std::filesystem::path(testing::TempDir()) / "grasp_pool.yaml";
  WriteFileAtomically(file,
                      "bin: {inner_size_m: [0.2, 0.2, 0.05]}\n"
                      "objects:\n  - {name: sampled/carton/1-2, count: 1}\n"
                      "draw: 2\n"
                      "camera: {eye_m: [0.0, -0.11, 0.62], target_m: [0.0, 0.0, 0.02]}\n"
                      "planner: {name: cloud_antipodal}\n");
  CompletedGraspsOptions options;
  options.scenario = file.string();
  options.planners = {"cloud_antipodal", kTrueShapes};
  options.single = 1;
  options.bins = 0;
  std::vector<std::pair<int, int>> progress;
  const CompletedGrasps grasps = RunCompletedGrasps(options, [&](int done, int total) {
    progress.emplace_back(done, total);
    return true;
  });
  EXPECT_THAT(progress, testing::ElementsAre(testing::Pair(0, 2), testing::Pair(2, 2)));
  const auto& single = grasps.shapes.at("single");
  ASSERT_EQ(single.at("cloud_antipodal").size(), 1u);
  EXPECT_EQ(single.at("cloud_antipodal").begin()->first, single.at(kTrueShapes).begin()->first);
  EXPECT_EQ(single.at(kTrueShapes).begin()->second.picked.samples, 1);
  EXPECT_TRUE(grasps.shapes.at("bins").at(kTrueShapes).empty());
}

TEST(CompletedGrasps, RefusesPlannersOnPosesRepeatedPlannersAndScenariosWithoutAPool) {
  const auto error_of = [](const CompletedGraspsOptions& options) {
    return ErrorOf([&] { RunCompletedGrasps(options, {}); });
  };
  CompletedGraspsOptions options;
  options.planners = {"poses"};
  EXPECT_THAT(error_of(options), HasSubstr("planner poses needs poses"));
  options.planners = {"skirt", "skirt"};
  EXPECT_THAT(error_of(options), HasSubstr("each only once"));
  options.planners = {"skirt"};
  options.single = options.bins = 0;
  EXPECT_THAT(error_of(options), HasSubstr("no bins"));
  options.bins = 1;
  options.scenario = "clutter";
  EXPECT_THAT(error_of(options), HasSubstr("draws no objects from a pool"));
}

}  // namespace
}  // namespace pickbed::tests
