#include "eval/benchmark/completed_grasps.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/layer.h"
#include "tests/support/temporary_folder.h"

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
  const Cluster grasps = AddTrial(trial, {"mug", "gear"}, shapes);
  EXPECT_EQ(grasps.hits, 2);
  EXPECT_EQ(grasps.samples, 3);
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(shapes["mug"].picked.hits, 1);
  EXPECT_EQ(shapes["mug"].picked.samples, 1);
  EXPECT_EQ(shapes["gear"].picked.hits, 1);
  EXPECT_EQ(shapes["gear"].picked.samples, 2);
  EXPECT_EQ(shapes["gear"].grasps.hits, 1);
  EXPECT_EQ(shapes["gear"].grasps.samples, 2);
}

// Eight shapes, each dropped four times. `completed` picks two or three of four, `skirt` one. In
// each of eight bins `skirt` has one success less, and bins differ much more than planners.
CompletedGrasps PlantedGrasps() {
  CompletedGrasps grasps;
  grasps.planners = {"completed", "skirt"};
  for (const char* condition : kGraspConditions) {
    for (int shape = 0; shape < 8; ++shape) {
      const std::string name = fmt::format("shape_{}", shape);
      const int more = shape % 2;
      grasps.shapes[condition]["completed"][name] = {{3, 5}, {2 + more, 4}};
      grasps.shapes[condition]["skirt"][name] = {{1, 5}, {1, 4}};
      grasps.bins[condition]["completed"].push_back({1 + shape % 2 * 4, 5});
      grasps.bins[condition]["skirt"].push_back({shape % 2 * 4, 5});
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

TEST(CompletedGrasps, DifferencesOfSuccessArePairedByBin) {
  CompletedGrasps planted = PlantedGrasps();
  const PairedStatistic paired = SuccessDifference(planted, "bins", "skirt");
  EXPECT_NEAR(paired.difference(), -0.2, 1e-9);
  EXPECT_LT(paired.difference_ci95.high, 0);
  EXPECT_LT(paired.p_value, 0.05);
  EXPECT_EQ(paired.scenes, 8);
  // The same grasps in another order of the bins: easy bins are compared with difficult ones.
  auto& bins = planted.bins["bins"]["skirt"];
  std::rotate(bins.begin(), bins.begin() + 1, bins.end());
  const PairedStatistic unpaired = SuccessDifference(planted, "bins", "skirt");
  EXPECT_NEAR(unpaired.difference(), -0.2, 1e-9);
  EXPECT_GT(unpaired.difference_ci95.high, 0);
  EXPECT_GT(unpaired.p_value, 0.05);
}

TEST(CompletedGrasps, FilesHaveOneLinePerPlannerAndPerShape) {
  const std::string csv = CompletedGraspsCsv(PlantedGrasps());
  EXPECT_THAT(csv, HasSubstr("\nsingle,completed,8,32,20,"));
  EXPECT_THAT(csv, HasSubstr("\nbins,skirt,8,32,8,"));
  EXPECT_THAT(csv, HasSubstr(",40,8,-0.2000,-"));
  EXPECT_THAT(CompletedGraspsShapesCsv(PlantedGrasps()),
              HasSubstr("\nbins,completed,shape_3,4,3,5,3\n"));
  EXPECT_THAT(CompletedGraspsText(PlantedGrasps()), HasSubstr("-37.5 ["));
  EXPECT_THAT(CompletedGraspsText(PlantedGrasps()), HasSubstr("-20.0 ["));
}

// A scenario that draws two of two cartons.
std::string SmallPool() {
  const auto file = std::filesystem::path(testing::TempDir()) / "grasp_pool.yaml";
  WriteFileAtomically(file,
                      "bin: {inner_size_m: [0.2, 0.2, 0.05]}\n"
                      "objects:\n  - {name: sampled/carton/1-2, count: 1}\n"
                      "draw: 2\n"
                      "camera: {eye_m: [0.0, -0.11, 0.62], target_m: [0.0, 0.0, 0.02]}\n"
                      "planner: {name: cloud_antipodal}\n");
  return file.string();
}

TEST(CompletedGrasps, AllPlannersGetTheSameBins) {
  CompletedGraspsOptions options;
  options.scenario = SmallPool();
  options.planners = {"cloud_antipodal", kTrueShapes};
  options.single = 1;
  options.bins = 0;
  options.pictures = true;
  std::vector<std::pair<int, int>> progress;
  const CompletedGrasps grasps = RunCompletedGrasps(options, [&](int done, int total) {
    progress.emplace_back(done, total);
    return true;
  });
  EXPECT_THAT(progress,
              testing::ElementsAre(testing::Pair(0, 2), testing::Pair(1, 2), testing::Pair(2, 2)));
  const auto& single = grasps.shapes.at("single");
  ASSERT_EQ(single.at("cloud_antipodal").size(), 1u);
  EXPECT_EQ(single.at("cloud_antipodal").begin()->first, single.at(kTrueShapes).begin()->first);
  EXPECT_EQ(single.at(kTrueShapes).begin()->second.picked.samples, 1);
  EXPECT_TRUE(grasps.shapes.at("bins").at(kTrueShapes).empty());
  EXPECT_EQ(grasps.bins.at("single").at(kTrueShapes).size(), 1u);
  // Each executed grasp has a picture, and the page shows it.
  const TemporaryFolder folder;
  HtmlPage page("Grasps");
  AddCompletedGrasps(folder.path(), grasps, page);
  for (const std::string& planner : options.planners) {
    const int executed = SumOf(grasps.bins.at("single").at(planner)).samples;
    const std::vector<GraspTile>& tiles = grasps.gallery.at("single").at(planner);
    ASSERT_EQ(static_cast<int>(tiles.size()), executed) << planner;
    const std::string file = "gallery_grasps_single_" + planner + ".png";
    EXPECT_EQ(std::filesystem::exists(folder.path() / file), executed > 0);
    EXPECT_EQ(page.body().find(file) != std::string::npos, executed > 0);
  }
  const std::vector<GraspTile>& tiles = grasps.gallery.at("single").at(kTrueShapes);
  ASSERT_EQ(tiles.size(), 1u) << "the carton is graspable on its true shape";
  EXPECT_TRUE(tiles[0].succeeded);
  EXPECT_THAT(tiles[0].caption, HasSubstr("picked"));
}

TEST(CompletedGrasps, AStoppedBenchmarkHasOnlyBinsOfAllPlanners) {
  CompletedGraspsOptions options;
  options.scenario = SmallPool();
  options.planners = {"cloud_antipodal", "skirt"};
  options.single = 2;
  options.bins = 0;
  const CompletedGrasps grasps =
      RunCompletedGrasps(options, [](int done, int) { return done < 3; });
  for (const std::string& planner : options.planners) {
    EXPECT_EQ(grasps.bins.at("single").at(planner).size(), 1u);
    EXPECT_EQ(grasps.shapes.at("single").at(planner).size(), 1u);
  }
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
