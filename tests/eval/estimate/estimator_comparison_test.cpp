#include "eval/estimate/estimator_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <sstream>

#include "eval/estimate/report.h"
#include "eval/estimate/statistics.h"
#include "eval/page/html.h"
#include "eval/runtime/process.h"
#include "scenes/base/error.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

HypothesisRecord Pose(double score, double mssd_diameters, double rotation_rad = 0) {
  HypothesisRecord pose;
  pose.score = score;
  pose.metrics.Set(kMssdDiameters, mssd_diameters);
  pose.metrics.Set(kRotation_rad, rotation_rad);
  pose.correct = mssd_diameters < kCorrectDiameters;
  return pose;
}

ScoredHypothesis Scored(const HypothesisRecord& record, int recalled, int nearest) {
  ScoredHypothesis scored;
  scored.record = record;
  scored.recalled = recalled;
  scored.nearest = nearest;
  return scored;
}

// Three instances, the last one barely visible. The poses by score: a right one, a second pose of
// the same instance, one at the place of another object. The last one is right, for the barely
// visible instance.
ComparedRow HandWorked() {
  ComparedImage image;
  image.score.instances = {{InstanceId{0}, ObjectId{0}, 1.0, true},
                           {InstanceId{1}, ObjectId{0}, 0.6, false},
                           {InstanceId{2}, ObjectId{0}, 0.05, true},
                           {InstanceId{3}, ObjectId{1}, 0.05, false}};
  image.score.hypotheses = {
      Scored(Pose(0.9, 0.01, 0.01), 0, 0), Scored(Pose(0.8, 0.02, 0.02), -1, 0),
      Scored(Pose(0.7, 0.3, 0.5), -1, 3), Scored(Pose(0.6, 0.03, 0.03), 2, 2)};
  image.seconds = {{"estimate", 0.5}, {"estimate/icp", 0.2}};
  ComparedRow row;
  row.label = "by hand";
  row.images = {image};
  return row;
}

TEST(ComparisonStatistics, EqualHandComputedValues) {
  const ComparisonStatistics f = StatisticsOf(HandWorked());
  EXPECT_EQ(f.top_right, 1);
  EXPECT_EQ(f.instances, 2) << "instances below 10 % visible need not be found";
  EXPECT_EQ(f.recalled, 1);
  EXPECT_EQ(f.poses, 4);
  EXPECT_EQ(f.right, 2) << "the second pose of an instance is wrong";
  EXPECT_EQ(f.identity_right, 3);
  EXPECT_EQ(f.recall_at_95, 0.5) << "with only the first pose";
  EXPECT_EQ(f.bands.back().instances, 1);
  EXPECT_EQ(f.bands.back().recalled, 1);
  EXPECT_EQ(f.share_over_15_deg, 0.25);
  EXPECT_EQ(f.median_mssd_diameters.value, 0.02);
  EXPECT_TRUE(std::isinf(f.median_mssd_diameters.ci95.high)) << "four poses are too few";
  // Each score has a bin of its own: (|1 - .9| + |0 - .8| + |0 - .7| + |1 - .6|) / 4.
  EXPECT_NEAR(f.calibration_error, (0.1 + 0.8 + 0.7 + 0.4) / 4, 1e-12);
  EXPECT_EQ(f.seconds, 0.5);
  EXPECT_EQ(StatisticsOf(HandWorked(), ObjectId{1}).instances, 0) << "there is no other object";
}

// Splits a CSV table into rows of named cells.
std::vector<std::map<std::string, std::string>> RowsOfCsv(const std::string& csv) {
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line + ",");
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> names = cells_of(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(lines, line)) {
    const std::vector<std::string> cells = cells_of(line);
    EXPECT_EQ(cells.size(), names.size()) << line;
    for (size_t i = 0; i < std::min(cells.size(), names.size()); ++i) {
      if (i == 0) rows.emplace_back();
      rows.back()[names[i]] = cells[i];
    }
  }
  return rows;
}

TEST(InstancesCsv, RecallCanBeCountedFromIt) {
  ObjectSet objects = EasyCube();
  objects.push_back(objects[0]);
  const ComparisonStatistics f = StatisticsOf(HandWorked());
  int instances = 0, recalled = 0;
  for (const auto& row : RowsOfCsv(InstancesCsv({HandWorked()}, objects))) {
    if (std::stod(row.at("visible_fraction")) < 0.1) continue;
    ++instances;
    recalled += row.at("found") == "1";
  }
  EXPECT_EQ(instances, f.instances);
  EXPECT_EQ(recalled, f.recalled);
}

TEST(HypothesesCsv, HasThePoseInTheWorld) {
  ComparedRow row = HandWorked();
  row.images[0].score.hypotheses.resize(1);
  // A quarter turn about z; the quaternion has qw >= 0 whatever the sign of the input.
  row.images[0].score.hypotheses[0].record.X_WO = scenes::MakePose(
      Eigen::Quaterniond(-std::sqrt(0.5), 0, 0, -std::sqrt(0.5)).toRotationMatrix(),
      {0.25, -0.5, 1});
  ObjectSet objects = EasyCube();
  const auto rows = RowsOfCsv(HypothesesCsv({row}, objects));
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_NEAR(std::stod(rows[0].at("qw")), std::sqrt(0.5), 1e-8);
  EXPECT_NEAR(std::stod(rows[0].at("qz")), std::sqrt(0.5), 1e-8);
  EXPECT_EQ(rows[0].at("tx_m"), "0.25");
  EXPECT_EQ(rows[0].at("ty_m"), "-0.5");
  EXPECT_EQ(rows[0].at("tz_m"), "1");
}

TEST(ComparisonTable, LongLabelsKeepColumnsAligned) {
  ComparedRow first = HandWorked(), second = HandWorked();
  first.label = "kehl:accurate=/home/somebody/models/of/kehl.net";
  second.label = "doumanoglou:accurate=/home/somebody/models/of/doumanoglou.net";
  const std::string table = ComparisonTable({first, second});
  EXPECT_THAT(table, HasSubstr(' ' + first.label + ' ' + second.label + '\n'));
  const size_t width = table.find('\n');
  for (size_t at = 0; at < table.size(); at += width + 1) {
    ASSERT_EQ(table.find('\n', at), at + width) << table;
  }
}

// A threshold cannot separate equal scores, so the right pose is not counted without the wrong
// ones.
TEST(ComparisonStatistics, TopPosesAreRightOnlyIfThereAreFiveRightOnes) {
  ComparedRow row = HandWorked();
  row.images[0].score.instances.resize(kTopPoses);
  std::vector<ScoredHypothesis>& poses = row.images[0].score.hypotheses;
  ScoredHypothesis right = poses.front();
  right.recalled = 0;
  poses.assign(kTopPoses - 1, right);
  EXPECT_EQ(StatisticsOf(row).top5_right, 0) << "too few poses";
  poses.push_back(right);
  EXPECT_EQ(StatisticsOf(row).top5_right, 1);
  ScoredHypothesis wrong = right;
  wrong.recalled = -1;
  poses.push_back(wrong);
  EXPECT_EQ(StatisticsOf(row).top5_right, 1) << "the sixth pose does not count";
  std::swap(poses.back(), poses.front());
  EXPECT_EQ(StatisticsOf(row).top5_right, 0);
}

TEST(ComparisonStatistics, BinsWithFewerThanFiveInstancesHaveNoFiveTopPoses) {
  ComparedRow row = HandWorked();
  ASSERT_LT(row.images[0].score.instances.size(), static_cast<size_t>(kTopPoses));
  EXPECT_EQ(StatisticsOf(row).top5_bins, 0);
  EXPECT_THAT(ComparisonTable({row}), testing::ContainsRegex("5 top-ranked poses right, % +-\n"));
  row.images.push_back(row.images[0]);
  row.images[1].score.instances.resize(kTopPoses);
  EXPECT_EQ(StatisticsOf(row).top5_bins, 1);
  EXPECT_THAT(ComparisonTable({row}),
              testing::ContainsRegex("5 top-ranked poses right, % +0.0 \\(0 of 1\\)\n"));
}

TEST(ComparisonStatistics, ThresholdsDoNotSeparateEqualScores) {
  ComparedRow row = HandWorked();
  for (ScoredHypothesis& pose : row.images[0].score.hypotheses) pose.record.score = 0.5;
  EXPECT_EQ(StatisticsOf(row).recall_at_95, 0);
}

TEST(Comparison, OracleIsPerfectAndNoisyOracleIsNot) {
  ScenarioSpec spec = CubeScenario(3);
  spec.trials = 2;
  ComparedEstimator far{"far", spec.estimator};
  far.spec.noise_mm = 30;
  const ComparisonJob job{spec, EasyCube(), {{"oracle", spec.estimator}, far}, {}, 0, 1, {}, {}};
  const std::vector<ComparedRow> rows = CompareEstimators(job);
  ASSERT_EQ(rows.size(), 2u);
  const ComparisonStatistics right = StatisticsOf(rows[0]), wrong = StatisticsOf(rows[1]);
  EXPECT_EQ(right.recall(), 1);
  EXPECT_EQ(right.precision(), 1);
  EXPECT_EQ(right.top_right, 2);
  EXPECT_NEAR(rows[0].bop.ar(), 1, 1e-9);
  EXPECT_NEAR(rows[0].bop.ap(), 1, 1e-9);
  EXPECT_EQ(wrong.instances, right.instances) << "the same bins";
  EXPECT_LT(wrong.recall(), 0.5);
  EXPECT_LT(rows[1].bop.ar(), 0.5);
  EXPECT_EQ(ComparisonCsv(rows, job.objects), ComparisonCsv(CompareEstimators(job), job.objects));
}

TEST(Comparison, PicturesAreOfTheChosenBins) {
  const TemporaryFolder folder;
  ScenarioSpec spec = CubeScenario(2);
  spec.trials = 3;
  ComparedEstimator far{"far", spec.estimator};
  far.spec.noise_mm = 30;
  ComparisonJob job{spec, EasyCube(), {{"oracle", spec.estimator}, far}, folder.path(), 1, 1,
                    {},   {}};
  job.wants_pictures = [](const std::vector<const ComparedImage*>& images) {
    EXPECT_EQ(images.size(), 2u);
    EXPECT_EQ(images[0]->trial, images[1]->trial);
    return images[0]->trial == 2;
  };
  CompareEstimators(job);
  for (const std::string label : {"oracle", "far"}) {
    EXPECT_TRUE(std::filesystem::exists(ComparedOverlay(folder.path(), 0, label)));
    EXPECT_FALSE(std::filesystem::exists(ComparedOverlay(folder.path(), 1, label)));
    EXPECT_TRUE(std::filesystem::exists(ComparedOverlay(folder.path(), 2, label)));
  }
}

// Identical cubes, half of them distractors. Distractors are neither required nor counted.
TEST(Comparison, DistractorsDoNotCount) {
  ScenarioSpec spec = CubeScenario(3);
  spec.trials = 2;
  spec.objects.insert(spec.objects.begin(), spec.objects.front());
  spec.objects[0].name = "other";
  spec.objects[0].distractor = true;
  const ObjectSet objects{EasyCube()[0], EasyCube()[0]};
  const ComparisonJob job{spec, objects, {{"oracle", spec.estimator}}, {}, 0, 1, {}, {}};
  const std::vector<ComparedRow> rows = CompareEstimators(job);
  for (const ComparedImage& image : rows[0].images) {
    for (const HypothesisRecord& pose : image.score.Records()) EXPECT_EQ(pose.object, 1);
  }
  const ComparisonStatistics f = StatisticsOf(rows[0]);
  EXPECT_EQ(f.recall(), 1);
  EXPECT_EQ(f.precision(), 1);
  EXPECT_LE(f.instances, 6);
  EXPECT_GT(f.instances, 3);
  EXPECT_EQ(StatisticsOf(rows[0], ObjectId{0}).instances, 0);
}

TEST(Comparison, LabelsNameEstimatorAndMode) {
  const auto rows = ParseEstimators({"descriptor:accurate", "ppf"}, EstimatorSpec());
  EXPECT_EQ(rows[0].spec.name, "descriptor");
  EXPECT_EQ(rows[0].spec.mode, "accurate");
  EXPECT_EQ(rows[1].spec.mode, EstimatorSpec().mode);
  EXPECT_THROW(ParseEstimators({"ppf", "ppf"}, EstimatorSpec()), InputError);
  EXPECT_THROW(ParseEstimators({"pfp"}, EstimatorSpec()), InputError);
}

TEST(Comparison, UnknownModesAreRefusedWithTheirPlace) {
  ScenarioSpec scenario;
  const auto rows = [](const char* label) { return ParseEstimators({label}, EstimatorSpec()); };
  EXPECT_NO_THROW(RequireModes(scenario, rows("wohlhart:accurate")));
  EXPECT_NO_THROW(RequireModes(scenario, rows("oracle:any")));
  try {
    RequireModes(scenario, rows("wohlhart:first"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--estimator wohlhart:first: "));
    EXPECT_THAT(error.what(), HasSubstr("fast, accurate"));
  }
  // The mode of the scenario file is named by its own place.
  scenario.estimator.mode = "verified";
  scenario.places["estimator"] = "bin.yaml:7";
  try {
    RequireModes(scenario, ParseEstimators({"descriptor"}, scenario.estimator));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("bin.yaml:7"));
  }
}

TEST(Comparison, LabelsSelectTheModelFile) {
  EstimatorSpec base;
  base.model = "mine.net";
  const auto rows = ParseEstimators(
      {"descriptor", "descriptor=models/b:1.net", "kehl:accurate=kehl.net", "ppf"}, base);
  EXPECT_EQ(rows[0].spec.model, "mine.net");
  EXPECT_EQ(rows[1].spec.name, "descriptor");
  EXPECT_EQ(rows[1].spec.mode, base.mode);
  EXPECT_EQ(rows[1].spec.model, "models/b:1.net");
  EXPECT_EQ(rows[2].spec.name, "kehl");
  EXPECT_EQ(rows[2].spec.mode, "accurate");
  EXPECT_EQ(rows[2].spec.model, "kehl.net");
  EXPECT_EQ(rows[3].spec.model, "");  // the scenario's model is for the descriptor estimator
  EXPECT_THROW(ParseEstimators({"kehl="}, base), InputError);
}

TEST(Comparison, ACalibrationIsOnlyForItsEstimator) {
  EstimatorSpec base;
  base.name = "process";
  base.calibration = "mine.yaml";
  base.scores = "raw";
  const auto rows = ParseEstimators({"process", "ppf"}, base);
  EXPECT_EQ(rows[0].spec.calibration, "mine.yaml");
  EXPECT_EQ(rows[0].spec.scores, "raw");
  EXPECT_EQ(rows[1].spec.calibration, "");
  EXPECT_EQ(rows[1].spec.scores, "probability");
}

// Chart of the page with this id.
std::string ChartOf(const HtmlPage& page, const std::string& id) {
  const size_t begin = page.body().find("data-chart=\"" + id + "\"");
  return page.body().substr(begin, page.body().find("</figure>", begin) - begin);
}

TEST(ComparisonPage, ChartsHaveTheHandComputedStatistics) {
  ComparedRow other = HandWorked();
  other.label = "other";
  const HtmlPage page = ComparisonPage("a < b", {HandWorked(), other}, EasyCube(), {"x.png"});
  const std::string recall = ChartOf(page, "recall");
  EXPECT_THAT(recall, HasSubstr("\"x\":\"90-100 %\",\"series\":\"by hand\",\"rate\":1.0"));
  EXPECT_THAT(recall, HasSubstr("\"x\":\"50-70 %\",\"series\":\"other\",\"rate\":0.0"));
  EXPECT_THAT(recall, HasSubstr("too few bins for an interval"));
  EXPECT_THAT(recall, Not(testing::ContainsRegex("\"low\":[0-9]")));
  EXPECT_THAT(recall, HasSubstr("\"x\":\"10-30 %\",\"series\":\"by hand\",\"rate\":null"));
  // One pose per score: 0.9 and 0.6 are right, 0.8 and 0.7 are not.
  const std::string reliability = ChartOf(page, "reliability");
  EXPECT_THAT(reliability, HasSubstr("\"confidence\":0.9,\"series\":\"by hand\",\"rate\":1.0"));
  EXPECT_THAT(reliability, HasSubstr("\"confidence\":0.7,\"series\":\"by hand\",\"rate\":0.0"));
  EXPECT_THAT(page.body(), HasSubstr("src=\"x.png\""));
}

TEST(Memory, PeakMemoryIncludesTouchedBlocks) {
  constexpr size_t kBlock = 64 << 20;
  ReleaseFreedMemory();  // memory of earlier tests
  const size_t before = ResetPeakMemory();
  {
    std::vector<char> block(kBlock);
    std::memset(block.data(), 1, kBlock);
    EXPECT_EQ(block[kBlock / 2], 1);
  }
  EXPECT_GE(PeakMemory(), before + kBlock * 9 / 10);
}

// Blocks that are too small for a mapping of their own stay with the process after they are freed.
// They stay because a later block is still held.
TEST(Memory, FreedMemoryIsReleasedForTheNextMeasurement) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer holds freed blocks back";
#endif
  constexpr size_t kBlock = 16 << 10, kBlocks = 4096, kAll = kBlock * kBlocks;
  const auto fill = [=](std::vector<std::vector<char>>& blocks) {
    for (size_t i = 0; i < kBlocks; ++i) blocks.emplace_back(kBlock, 'x');
  };
  ReleaseFreedMemory();
  const size_t before = ResetPeakMemory();
  std::vector<std::vector<char>> blocks;
  fill(blocks);
  const std::vector<char> last(kBlock, 'y');
  blocks = {};
  if (ResetPeakMemory() < before + kAll / 2) GTEST_SKIP() << "this allocator keeps no freed memory";
  ReleaseFreedMemory();
  const size_t released = ResetPeakMemory();
  EXPECT_LT(released, before + kAll / 10);
  fill(blocks);
  EXPECT_GE(PeakMemory(), released + kAll * 9 / 10);
  EXPECT_EQ(last.back(), 'y');
}

}  // namespace
}  // namespace pickbed::tests
