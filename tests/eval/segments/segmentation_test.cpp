#include "eval/segments/segmentation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(SegmentBins, FindsCubesAndWritesOneLineForEach) {
  const TemporaryFolder folder;
  ScenarioSpec spec = CubeScenario(4);
  spec.trials = 2;
  SegmentationOptions options;
  options.methods = {"convexity", "depth_steps"};
  options.pictures = folder.path() / "pictures";
  options.pictured_images = 1;
  const std::vector<SegmentationRow> rows =
      SegmentBins(spec, EasyCube(), options, [](int, int) { return true; });
  ASSERT_EQ(rows.size(), 2u);
  int instances = 0, found = 0;
  for (const SegmentedImage& image : rows.front().images) {
    for (const SegmentedInstance& instance : image.scores.instances) {
      ++instances;
      found += instance.iou > 0.5;
    }
  }
  EXPECT_EQ(instances, 8);
  EXPECT_GE(found, 6);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "pictures/trial_0000.png"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "pictures/trial_0001.png"));
  const std::string csv = SegmentsCsv(rows);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 16);
  EXPECT_THAT(csv, StartsWith("method,image,label,"));
  EXPECT_THAT(SegmentScoresCsv(rows), HasSubstr("depth_steps,trial_0001,"));
  EXPECT_THAT(SegmentationTable(rows), HasSubstr("weighted overlap"));
  EXPECT_THAT(SegmentationJson(rows), HasSubstr("\"recall_50\""));
}

TEST(SegmentBins, EndsWhenTheListenerSaysSo) {
  ScenarioSpec spec = CubeScenario(1);
  spec.trials = 3;
  SegmentationOptions options;
  options.methods = {"convexity"};
  const auto rows = SegmentBins(spec, EasyCube(), options, [](int done, int) { return done < 2; });
  EXPECT_EQ(rows.front().images.size(), 2u);
}

TEST(SegmentClouds, NeedsCloudsAndKnownMethods) {
  const TemporaryFolder folder;
  const auto go_on = [](int, int) { return true; };
  EXPECT_THAT(ErrorOf([&] { SegmentClouds(folder.path(), {}, go_on); }), HasSubstr("no *.pcd"));
  SegmentationOptions options;
  options.methods = {"convexity", "convexity"};
  EXPECT_THAT(ErrorOf([&] { SegmentBins(CubeScenario(1), EasyCube(), options, go_on); }),
              HasSubstr("'convexity' is given twice"));
  options.methods = {"magic"};
  EXPECT_THAT(ErrorOf([&] { SegmentBins(CubeScenario(1), EasyCube(), options, go_on); }),
              HasSubstr("magic"));
}

// An image without instances has no overlap to average.
TEST(SegmentationTable, LeavesOutImagesWithoutInstances) {
  SegmentedImage empty{"empty", {}, 0.1}, labelled{"labelled", {}, 0.1};
  labelled.scores.instances = {{1, 100, 0.8, 1, 1, 0.9, true}};
  labelled.scores.weighted_overlap = 0.8;
  EXPECT_THAT(SegmentationJson(std::vector{SegmentationRow{"a", {empty, labelled}}}),
              HasSubstr("\"weighted_overlap\": 0.8,"));
  const std::vector<SegmentationRow> none{{"a", {empty}}};
  EXPECT_THAT(SegmentationJson(none), HasSubstr("\"weighted_overlap\": null"));
  EXPECT_THAT(SegmentationTable(none), ContainsRegex("weighted overlap, % +-\n"));
}

// Published values of locally convex patches are near .89 on the whole database.
TEST(SegmentClouds, OverlapsMostOfTheHouseholdObjects) {
  const std::filesystem::path clouds = std::filesystem::path(PICKBED_TEST_DATA) / "mosd";
  if (!std::filesystem::exists(clouds)) GTEST_SKIP() << clouds << " is absent";
  SegmentationOptions options;
  options.methods = {"convexity"};
  const auto rows = SegmentClouds(clouds, options, [](int, int) { return true; });
  double overlap = 0;
  for (const SegmentedImage& image : rows.front().images) overlap += image.scores.weighted_overlap;
  EXPECT_GT(overlap / static_cast<double>(rows.front().images.size()), 0.93);
}

TEST(SegmentOverlay, ColorsSegmentsAndDrawsTheirBorders) {
  Image<uint16_t> labels(4, 1);
  labels(2, 0) = labels(3, 0) = 7;
  const Image<Rgb8> overlay = SegmentOverlay(Image<Rgb8>(4, 1, {10, 10, 10}), labels);
  EXPECT_EQ(overlay(0, 0), (Rgb8{10, 10, 10}));
  EXPECT_EQ(overlay(2, 0), (Rgb8{255, 255, 255}));
  EXPECT_NE(overlay(3, 0), (Rgb8{10, 10, 10}));
}

}  // namespace
}  // namespace pickbed::tests
