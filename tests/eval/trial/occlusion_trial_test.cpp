#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "eval/cell/simulated_cell.h"
#include "eval/summary/failure_budget.h"
#include "eval/summary/occlusion_curve.h"
#include "eval/summary/run_csv.h"
#include "eval/summary/run_summary.h"
#include "eval/trial/trial.h"
#include "tests/eval/cube_scenario.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

ScenarioSpec OccludedCubes(int count) {
  ScenarioSpec spec = CubeScenario(count);
  spec.occlusion.enabled = true;
  spec.occlusion.bands = {{0.3, 0.6}, {0.6, 0.9}, {0.9, 1}};
  return spec;
}

const InstanceRecord& TargetOf(const AttemptRecord& attempt) {
  for (const InstanceRecord& instance : attempt.instances) {
    if (instance.instance == attempt.target) return instance;
  }
  throw std::out_of_range("the target is not among the instances");
}

TEST(OcclusionTrial, HasOneAttemptPerBandAtTheSameTarget) {
  const ScenarioSpec spec = OccludedCubes(4);
  TrialRunner runner(spec, EasyCube());
  for (const int trial : {0, 1}) {
    const TrialResult result = runner.Run(BinIndex(trial));
    ASSERT_EQ(result.attempts.size(), 3u);
    size_t instances = 0;
    for (const AttemptRecord& attempt : result.attempts) {
      EXPECT_EQ(attempt.target, result.attempts[0].target);
      EXPECT_EQ(attempt.band, 2 - attempt.attempt);
      // From the camera image. Another renderer was used to build the scenes.
      EXPECT_TRUE(spec.occlusion.bands[attempt.band].Holds(TargetOf(attempt).visible_fraction));
      EXPECT_GE(attempt.instances.size(), std::max<size_t>(instances, 4))
          << "no attempt removes an instance";
      instances = attempt.instances.size();
    }
  }
}

// The oracle reports every instance that is at least 10 % visible, so it always finds the target.
// No grasp may be on another instance.
TEST(OcclusionTrial, GraspsAreOnlyOnTheTarget) {
  TrialRunner runner(OccludedCubes(4), EasyCube());
  int picked = 0, attempts = 0;
  for (const int trial : {0, 1, 2}) {
    for (const AttemptRecord& attempt : runner.Run(BinIndex(trial)).attempts) {
      EXPECT_TRUE(TargetOf(attempt).recalled);
      if (!attempt.grasp) {
        EXPECT_EQ(attempt.failure, FailureReason::kNoGrasp);
        continue;
      }
      ++attempts;
      EXPECT_EQ(attempt.matched_instance, attempt.target);
      picked += attempt.failure == FailureReason::kNone;
      if (attempt.failure == FailureReason::kNone) {
        EXPECT_EQ(attempt.outcome.picked_instance, attempt.target);
      }
    }
  }
  EXPECT_GE(attempts, 4);
  EXPECT_GE(picked, 3) << "at least one per trial: the unoccluded target";
}

TEST(OcclusionTrial, AttemptAndInstanceBudgetsAgree) {
  TrialRunner runner(OccludedCubes(3), EasyCube());
  const TrialResult result = runner.Run(BinIndex{0});
  const FailureBudget attempts = BudgetOfAttempts({&result, 1});
  const FailureBudget instances = BudgetOfInstances({&result, 1});
  EXPECT_EQ(attempts.total, 3);
  EXPECT_EQ(instances.total, 3);
  EXPECT_EQ(attempts.failures, instances.failures);
}

TEST(OcclusionTrial, DependsOnlyOnSeedAndTrialNumber) {
  ScenarioSpec spec = OccludedCubes(3);
  spec.estimator.noise_mm = 2;
  const ObjectSet objects = EasyCube();
  const auto text = [&](const TrialResult& result) {
    return TrialsCsv({result}) + AttemptsCsv({result}, {"cube"}) +
           CurveCsv(std::vector<NamedCurve>{{"", StatisticsByBand({&result, 1}, spec.occlusion)}});
  };
  TrialRunner runner(spec, objects);
  const std::string zero = text(runner.Run(BinIndex{0})), one = text(runner.Run(BinIndex{1}));
  EXPECT_NE(zero, one);
  EXPECT_EQ(text(runner.Run(BinIndex{0})), zero) << "earlier trials have no effect";
  EXPECT_EQ(text(TrialRunner(spec, objects).Run(BinIndex{1})), one) << "the runner keeps no state";
}

// All estimators see the same scenes, so that comparisons are paired.
TEST(OcclusionTrial, ScenesDoNotDependOnTheEstimator) {
  ScenarioSpec exact = OccludedCubes(3), noisy = exact;
  noisy.estimator.noise_mm = 40;
  const TrialResult a = TrialRunner(exact, EasyCube()).Run(BinIndex{0});
  const TrialResult b = TrialRunner(noisy, EasyCube()).Run(BinIndex{0});
  ASSERT_EQ(a.attempts.size(), b.attempts.size());
  int missed = 0;
  for (size_t i = 0; i < a.attempts.size(); ++i) {
    EXPECT_EQ(TargetOf(a.attempts[i]).visible_fraction, TargetOf(b.attempts[i]).visible_fraction);
    missed += !TargetOf(b.attempts[i]).recalled;
    if (!TargetOf(b.attempts[i]).recalled && !b.attempts[i].grasp) {
      EXPECT_THAT(b.attempts[i].failure,
                  testing::AnyOf(FailureReason::kPoseWrong, FailureReason::kNoProposal));
    }
  }
  EXPECT_GT(missed, 0) << "the case did not occur";
}

// The plate is wider than the gripper stroke. Only its edge could be held, which rests on the
// floor.
TEST(OcclusionTrial, TargetWithoutAFeasibleGraspFailsAsNoGrasp) {
  const TrialResult result =
      TrialRunner(OccludedCubes(1), {BoxObject({0.12, 0.11, 0.006}, 0.2)}).Run(BinIndex{0});
  ASSERT_FALSE(result.attempts.empty());
  for (const AttemptRecord& attempt : result.attempts)
    EXPECT_EQ(attempt.failure, FailureReason::kNoGrasp);
}

// It must not end a sweep, because other bins may have a scene.
TEST(OcclusionTrial, TrialWithoutASceneIsRecorded) {
  ScenarioSpec spec = OccludedCubes(2);
  spec.occlusion.bands = {{0.500, 0.502}};
  spec.occlusion.margin = 0;
  spec.occlusion.blocker_samples = spec.occlusion.targets = spec.occlusion.scenes = 1;
  const TrialResult result = TrialRunner(spec, EasyCube()).Run(BinIndex{3});
  EXPECT_TRUE(result.attempts.empty());
  EXPECT_EQ(result.instances_dropped, 0);
  ASSERT_EQ(result.bands.size(), 1u);
  EXPECT_FALSE(result.bands[0].filled);
  const std::vector<BandStatistics> bands = StatisticsByBand({&result, 1}, spec.occlusion);
  EXPECT_EQ(bands[0].trials_without, 1);
  EXPECT_THAT(CurveTable(bands), HasSubstr("trials without a scene: 1; rejected targets: 1"));
}

TEST(OcclusionCurve, SuggestsARemedyWhenNoTargetWasFound) {
  TrialResult trial;
  trial.bands.resize(5);
  EXPECT_THAT(CurveTable(StatisticsByBand({&trial, 1}, OcclusionSpec{})),
              HasSubstr("raise the camera, drop fewer objects or lower the bands"));
}

// An attempt at target 7 in band 0 with the given recall, pick result and pose error.
AttemptRecord AttemptAt(bool recalled, bool picked, double error_diameters) {
  AttemptRecord attempt;
  attempt.target = InstanceId{7};
  attempt.band = 0;
  attempt.instances = {{InstanceId{3}, ObjectId{0}, 1.0, true},
                       {InstanceId{7}, ObjectId{0}, 0.2, recalled}};
  HypothesisRecord other, near;
  other.instance = InstanceId{3};
  near.instance = InstanceId{7};
  near.score = 0.4;
  near.metrics.Set(kMssdDiameters, error_diameters);
  near.metrics.Set(kTranslation_m, 0.01 * error_diameters);
  attempt.hypotheses = {other, near};
  attempt.failure = picked ? FailureReason::kNone : FailureReason::kSlipped;
  return attempt;
}

TEST(OcclusionCurve, CountsOnlyTheTarget) {
  OcclusionSpec spec;
  spec.bands = {{0.1, 0.3}, {0.9, 1}};
  std::vector<TrialResult> trials(3);
  for (int i = 0; i < 3; ++i) trials[i].trial = trials[i].bin_index = BinIndex(i);
  trials[0].attempts = {AttemptAt(true, true, 0.02)};
  trials[1].attempts = {AttemptAt(true, false, 0.06)};
  trials[2].attempts = {AttemptAt(false, false, 0.7)};  // on no instance
  trials[2].bands = {{true, 1, {9, 2, 3, 3, 1}}, {false, 2, {4, 0, 4, 0, 0}}};
  const std::vector<BandStatistics> bands = StatisticsByBand(trials, spec);
  ASSERT_EQ(bands.size(), 2u);
  EXPECT_EQ(bands[0].attempts, 3);
  EXPECT_EQ(bands[0].recalled.hits, 2);
  EXPECT_EQ(bands[0].picked.hits, 1);
  EXPECT_FALSE(bands[0].recalled.ci95.is_known()) << "three bins";
  EXPECT_DOUBLE_EQ(bands[0].mean_visible, 0.2);
  EXPECT_EQ(bands[0].errors.attempts, 2);
  EXPECT_DOUBLE_EQ(bands[0].errors.mssd_diameters.value, 0.02) << "the lower median of two";
  EXPECT_EQ(bands[0].failures.at("slipped"), 2);
  EXPECT_EQ(bands[1].attempts, 0);
  EXPECT_EQ(bands[1].trials_without, 1);
  const std::string table = CurveTable(bands);
  EXPECT_THAT(table, HasSubstr("66.7 % (too few bins)"));
  EXPECT_THAT(table,
              HasSubstr("90-100 %: trials without a scene: 1; rejected targets: 2; of 4 blockers 0 "
                        "hid too much, 0 too little, 4 moved the other instances"));
}

// The headline counts targets: one of three was picked, and one attempt had no grasp. Recall of the
// targets and of all instances in view are different numbers.
TEST(OcclusionCurve, HeadlineCountsTargets) {
  std::vector<TrialResult> trials(3);
  for (int i = 0; i < 3; ++i) {
    trials[i].trial = trials[i].bin_index = BinIndex(i);
    trials[i].attempts = {AttemptAt(i < 2, i == 0, 0.02)};
    trials[i].attempts[0].grasp = Grasp{};
    trials[i].instances_dropped = 1;
    trials[i].instances_cleared = i == 0;
  }
  trials[2].attempts[0].grasp.reset();
  trials[2].attempts[0].failure = FailureReason::kNoGrasp;
  const RunSummary s = Summarize(trials);
  EXPECT_EQ(s.target_recall.hits, 2);
  EXPECT_EQ(s.target_recall.samples, 3);
  EXPECT_EQ(s.recall.hits, 5);
  EXPECT_EQ(s.recall.samples, 6);
  const std::string table = SummaryTable(s);
  const size_t targets = table.find("targets picked"), success = table.find("success rate");
  EXPECT_LT(targets, success) << "the headline is first";
  EXPECT_THAT(table, HasSubstr("1 of 3 attempts (1 without a grasp)"));
  EXPECT_THAT(table, HasSubstr("1 of 2 executed grasps"));
  EXPECT_THAT(table, HasSubstr("2 of 3 targets"));
  EXPECT_THAT(table, HasSubstr("5 of 6 instances"));
}

// Returns the cell of the second CSV line in the named column.
std::string CellOf(const std::string& csv, const std::string& column) {
  std::istringstream lines(csv);
  std::string head, row;
  std::getline(lines, head);
  std::getline(lines, row);
  std::istringstream names(head), cells(row);
  std::string name, cell;
  while (std::getline(names, name, ',')) {
    if (!std::getline(cells, cell, ',')) break;
    if (name == column) return cell;
  }
  return "no " + column;
}

TEST(OcclusionCurve, MedianErrorIntervalsAreOverBins) {
  OcclusionSpec spec;
  spec.bands = {{0.1, 0.3}};
  std::vector<TrialResult> trials(40);
  for (int i = 0; i < 40; ++i) {
    trials[i].trial = trials[i].bin_index = BinIndex(i);
    trials[i].attempts = {AttemptAt(true, true, 0.001 * (i + 1))};
  }
  RunSummary summary = Summarize(trials);
  summary.bands = StatisticsByBand(trials, spec);
  const ErrorMedian median = summary.bands[0].errors.mssd_diameters;
  EXPECT_DOUBLE_EQ(median.ci95.low, 0.014);
  EXPECT_DOUBLE_EQ(median.value, 0.02);
  EXPECT_DOUBLE_EQ(median.ci95.high, 0.027);

  const std::string csv = CurveCsv(std::vector<NamedCurve>{{"", summary.bands}});
  EXPECT_EQ(CellOf(csv, "mssd_low"), fmt::format("{}", median.ci95.low));
  EXPECT_NEAR(std::stod(CellOf(csv, "translation_high")), 10 * median.ci95.high, 1e-9);
  EXPECT_EQ(CellOf(csv, "blockers_useless"), "0");
  const std::string quoted = CurveCsv(std::vector<NamedCurve>{{"a \"b\", c", summary.bands}});
  EXPECT_THAT(quoted, HasSubstr("\n\"a \"\"b\"\", c\",0.1,"));
  EXPECT_THAT(CurveTable(summary.bands), HasSubstr("0.2 [0.1, 0.3] mm"));
  const auto json = nlohmann::json::parse(SummaryJson(summary))["target_by_visibility"][0];
  EXPECT_EQ(json["median_mssd_diameters_ci95"][1], median.ci95.high);
}

}  // namespace
}  // namespace pickbed::tests
