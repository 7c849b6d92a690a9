#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <numbers>
#include <set>

#include "eval/tolerance/draw.h"
#include "eval/tolerance/report.h"
#include "eval/tolerance/statistics.h"
#include "grasp/grippers/suction_cup.h"
#include "scenes/base/files.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

// A grasp from above, across 4 cm at the upper end of a box.
GraspCandidate FromTheTop() {
  GraspCandidate candidate;
  candidate.X_OG = FromAbove({0, 0, 0.006});
  candidate.width_m = 0.04;
  candidate.depth_m = 0.012;
  candidate.quality = 0.9;
  return candidate;
}

ToleranceOptions Small() {
  ToleranceOptions options;
  options.grasps = 1;
  options.steps = 3;
  options.step_mm = 1.2;  // no level at which a finger lands exactly on the object's edge
  options.step_deg = 5;
  options.fit_samples = 10;
  options.test_samples = 10;
  return options;
}

ToleranceStudy Study(const ToleranceOptions& options) {
  return PlanStudy(BoxObject({0.04, 0.03, 0.06}, 0.1), std::make_shared<ParallelJaw>(SmallJaw()),
                   {FromTheTop()}, options);
}

LevelShare Level(double offset, int successes, int samples) {
  return {offset, successes, samples, {}};
}

TEST(ToleranceRegion, EndsAreInterpolatedAtTheThreshold) {
  const std::vector<LevelShare> levels{Level(-4, 0, 10), Level(-2, 10, 10), Level(0, 10, 10),
                                       Level(2, 10, 10), Level(4, 8, 10)};
  const ToleranceRegion region = RegionOf(levels, 0.9);
  EXPECT_NEAR(region.low, -2.2, 1e-12);
  EXPECT_NEAR(region.high, 3, 1e-12);
  EXPECT_FALSE(region.low_open);
  const ToleranceRegion wide = RegionOf(levels, 0.8);
  EXPECT_TRUE(wide.high_open);
  EXPECT_EQ(wide.high, 4);
}

TEST(ToleranceRegion, LevelsBeyondAGapDoNotCount) {
  const std::vector<LevelShare> levels{Level(-2, 10, 10), Level(-1, 0, 10), Level(0, 10, 10),
                                       Level(1, 0, 10), Level(2, 10, 10)};
  const ToleranceRegion region = RegionOf(levels, 0.5);
  EXPECT_NEAR(region.low, -0.5, 1e-12);
  EXPECT_NEAR(region.high, 0.5, 1e-12);
  EXPECT_EQ(RegionOf({Level(-1, 1, 1), Level(0, 0, 1), Level(1, 1, 1)}, 0.5).high, 0);
}

TEST(ToleranceRegion, EmptyIfNothingSucceeds) {
  const ToleranceRegion region = RegionOf({Level(-1, 0, 9), Level(0, 0, 9), Level(1, 0, 9)}, 0);
  EXPECT_EQ(region.low, region.high);
  EXPECT_FALSE(region.low_open || region.high_open);
}

TEST(ToleranceStudy, ErrorsFollowTheirAxes) {
  const ToleranceStudy study = Study(Small());
  const Pose X_OG = study.grasps[0].candidate.X_OG;
  int axis_samples = 0;
  for (const PlannedSample& sample : study.samples) {
    if (sample.kind != SampleKind::kAxis) continue;
    ++axis_samples;
    const ErrorAxis& axis = ErrorAxisTable()[sample.axis[0]];
    const PoseOffset error =
        ToPoseOffset(axis.of_grasp ? X_OG.inverse() * sample.X_OE * X_OG : sample.X_OE);
    const double step = axis.coordinate < 3 ? 0.0012 : 5 * std::numbers::pi / 180;
    PoseOffset expected = PoseOffset::Zero();
    expected[axis.coordinate] = sample.level[0] * step;
    // The center of the box's surface is at the origin of O.
    EXPECT_LT((error - expected).norm(), 1e-9) << axis.name << " " << sample.level[0];
  }
  EXPECT_EQ(axis_samples, 12 * 6 + 1);
}

// A cup has no fingers, so its help must not mention them.
TEST(ErrorAxes, HelpMatchesTheGripper) {
  std::set<std::string> of_cup;
  for (const ErrorAxis& axis : ErrorAxisTable()) {
    const std::string help = AxisHelp(axis, SuctionCup());
    EXPECT_THAT(help, testing::Not(testing::ContainsRegex("finger|closing")));
    of_cup.insert(help);
  }
  EXPECT_EQ(of_cup.size(), ErrorAxisTable().size());
  EXPECT_EQ(AxisHelp(ErrorAxisTable()[6], SmallJaw()), "along the closing direction");
  EXPECT_EQ(AxisHelp(ErrorAxisTable()[11], SmallJaw()), "about the approach");
  EXPECT_EQ(AxisHelp(ErrorAxisTable()[4], SmallJaw()), "about y of the object");
}

TEST(ToleranceStudy, FilesAreEqualForAnyJobCountAndAfterResume) {
  ToleranceOptions options = Small();
  options.pairs = {{6, 11}};
  options.pair_stride = 3;
  const ToleranceStudy study = Study(options);
  TemporaryFolder one, two, stopped;
  const StudyOutcomes single = ExecuteStudy(study, one.path(), 1, false, {});
  const StudyOutcomes both = ExecuteStudy(study, two.path(), 2, false, {});
  ASSERT_EQ(single.outcomes.size(), study.samples.size());
  const std::string bytes = ReadFileBytes(one.path() / "samples.csv");
  EXPECT_EQ(bytes, ReadFileBytes(two.path() / "samples.csv"));

  // A killed run leaves lines in any order and a partial line at the end.
  const size_t header = bytes.find('\n', bytes.find('\n') + 1) + 1;
  const size_t half = bytes.find('\n', bytes.size() / 2) + 1;
  std::ofstream(stopped.path() / "samples.csv", std::ios::binary)
      << bytes.substr(0, header) << bytes.substr(half, 300);
  EXPECT_THAT(ErrorOf([&] { ExecuteStudy(study, stopped.path(), 1, false, {}); }),
              testing::HasSubstr("resume it"));
  int first_total = 0, first_before = 0;
  StudyListener listener;
  listener.on_progress = [&](int, int total, int before) {
    first_total = total;
    first_before = before;
  };
  ExecuteStudy(study, stopped.path(), 2, true, listener);
  EXPECT_EQ(bytes, ReadFileBytes(stopped.path() / "samples.csv"));
  EXPECT_EQ(first_total, static_cast<int>(study.samples.size()));
  EXPECT_GT(first_before, 0);

  options.seed = 1;
  EXPECT_THAT(ErrorOf([&] { ExecuteStudy(Study(options), one.path(), 1, true, {}); }),
              testing::HasSubstr("other settings"));

  const ToleranceStatistics statistics = StatisticsOf(study, single.outcomes);
  EXPECT_EQ(statistics.at_truth.samples, 1);
  EXPECT_EQ(statistics.at_truth.successes, 1);
  // The open fingers are 3 mm away from the object.
  const ToleranceRegion& closing = statistics.axes[6].region;
  EXPECT_GT(closing.high, 2.0);
  EXPECT_LT(closing.high, 3.6);
  EXPECT_NEAR(closing.low, -closing.high, 0.7);
  ASSERT_EQ(statistics.pairs.size(), 1u);
  EXPECT_EQ(statistics.pairs[0].cells.size(), 9u);
  EXPECT_EQ(statistics.pairs[0].cells[4].successes, 1);
  EXPECT_EQ(AxesCsv(statistics), AxesCsv(StatisticsOf(study, both.outcomes)));
}

// The same range of errors with an eighth of the executions.
TEST(QuickOptions, CoverTheSameRangeWithFewExecutions) {
  const ToleranceOptions quick = QuickOptions(), usual;
  EXPECT_DOUBLE_EQ(quick.steps * quick.step_mm, usual.steps * usual.step_mm);
  EXPECT_DOUBLE_EQ(quick.steps * quick.step_deg, usual.steps * usual.step_deg);
  EXPECT_DOUBLE_EQ(quick.random_steps * quick.step_mm, usual.random_steps * usual.step_mm);
  const auto executions = [](const ToleranceOptions& o) {
    return 12 * 2 * o.steps * o.grasps + o.fit_samples + o.test_samples;
  };
  EXPECT_LT(8 * executions(quick), executions(usual));
}

// Twenty samples of one grasp give no more information than one.
TEST(ToleranceStatistics, RepeatedGraspsDoNotNarrowTheInterval) {
  ToleranceOptions options = Small();
  options.grasps = 20;
  const ToleranceStudy study = Study(options);
  std::set<int> places;
  for (int i = 0; i < options.grasps; ++i) places.insert(study.grasps[i].place);
  ASSERT_LT(places.size(), 6u);
  const std::vector<SampleOutcome> good(study.samples.size(), {true, FailureReason::kNone});
  const ToleranceStatistics statistics = StatisticsOf(study, good);
  const LevelShare& at_truth = statistics.at_truth;
  EXPECT_EQ(at_truth.samples, 20);
  const int distinct = static_cast<int>(places.size());
  if (distinct < kMinBinsOfInterval) {
    EXPECT_EQ(BandText(at_truth), "(too few grasps)");
  } else {
    // At least as much as one sample per grasp gives, and less than twenty samples give.
    EXPECT_GE(at_truth.band().low, WilsonInterval(distinct, distinct).low);
    EXPECT_LT(at_truth.band().low, WilsonInterval(20, 20).low);
  }
  // The sheet shows the same intervals.
  ToleranceStatistics all_differ = statistics;
  for (LevelShare& level : all_differ.axes[0].levels) {
    level.of_grasp.clear();
    for (int i = 0; i < level.samples; ++i) level.of_grasp[i] = {1, 1};
  }
  EXPECT_NE(DrawToleranceSheet(study, statistics), DrawToleranceSheet(study, all_differ));
}

TEST(TolerancePredictors, MapPredictsAPlantedRuleAndMetricsDoNot) {
  // Picks that tolerate any error across the hand, but only 3 mm along its closing direction.
  const auto object = BoxObject({0.04, 0.03, 0.06}, 0.1);
  ToleranceModel model = EmptyToleranceModel(*object, "test jaw", {Pose::Identity()});
  Rng rng(0);
  const auto draw = [&] {
    PoseOffset error = PoseOffset::Zero();
    for (int i = 0; i < 3; ++i) error[i] = rng.Uniform(-0.01, 0.01);
    return error;
  };
  std::vector<ToleranceSample> samples;
  for (int i = 0; i < 2000; ++i) {
    const PoseOffset error = draw();
    samples.push_back({error, std::abs(error[0]) < 0.003, i % 20});
  }
  FitTolerance(samples, {}, model);
  std::vector<JudgedPick> picks;
  for (int i = 0; i < 600; ++i) {
    const PoseOffset error = draw();
    picks.push_back({ToPose(error), std::abs(error[0]) < 0.003, i});
  }
  const auto predictors = JudgePredictors({{model, *object, picks}});
  ASSERT_GE(predictors.size(), 4u);
  EXPECT_EQ(predictors[0].name, kPickRiskMetric);
  EXPECT_GT(predictors[0].auc.auc, 0.98);
  for (size_t i = 1; i < predictors.size(); ++i) {
    EXPECT_LT(predictors[i].auc.auc, 0.85) << predictors[i].name;
    EXPECT_LT(predictors[i].to_first.interval.high, 0) << predictors[i].name;
    EXPECT_NE(predictors[i].name, "mspd");
  }
  // A pure shift moves all points equally.
  const auto auc_of = [&](const std::string& name) {
    for (const Predictor& p : predictors) {
      if (p.name == name) return p.auc.auc;
    }
    return 0.0;
  };
  EXPECT_NEAR(auc_of("mssd"), auc_of("add"), 1e-12);
  // The bootstrap draws the picks of one bin together.
  for (size_t i = 0; i < picks.size(); ++i) picks[i].cluster = static_cast<int>(i) / 100;
  const auto clustered = JudgePredictors({{model, *object, picks}});
  EXPECT_DOUBLE_EQ(clustered[0].auc.auc, predictors[0].auc.auc);
  EXPECT_NE(clustered[1].auc.interval.low, predictors[1].auc.interval.low);
}

TEST(TolerancePredictors, PicksOfOneOutcomeGiveNoAuc) {
  const auto object = BoxObject({0.04, 0.03, 0.06}, 0.1);
  const ToleranceModel model = EmptyToleranceModel(*object, "test jaw", {Pose::Identity()});
  std::vector<JudgedPick> picks;
  for (int i = 0; i < 6; ++i) picks.push_back({Translation({1e-4 * i, 0, 0}), true, i / 2});
  const auto predictors = JudgePredictors({{model, *object, picks}});
  EXPECT_THAT(PredictorText(predictors, "3 bins"),
              testing::AllOf(testing::HasSubstr("all 6 picks succeeded (3 bins)"),
                             testing::Not(testing::HasSubstr("0.5"))));
  EXPECT_THAT(PredictorsCsv(predictors), testing::HasSubstr("pick_risk,,,,,,,6,0\n"));
}

}  // namespace
}  // namespace pickbed::tests
