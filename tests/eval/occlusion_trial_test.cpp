#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "eval/loss_budget.h"
#include "eval/occlusion_curve.h"
#include "eval/summary.h"
#include "eval/trial.h"
#include "eval/virtual_cell.h"
#include "tests/eval/cube_scenario.h"
#include "tests/sim/physics_parts.h"

namespace pickbed {
namespace {

using ::testing::HasSubstr;

ScenarioSpec OccludedCubes(int count) {
  ScenarioSpec spec = CubeScenario(count);
  spec.occlusion.enabled = true;
  spec.occlusion.bands = {{0.3, 0.6}, {0.6, 0.9}, {0.9, 1}};
  return spec;
}

const InstanceRecord& TargetOf(const PickRecord& pick) {
  for (const InstanceRecord& instance : pick.instances) {
    if (instance.instance == pick.target) return instance;
  }
  throw std::out_of_range("the target is not among the instances");
}

TEST(OcclusionTrial, HasOneLookABandAtTheSameTarget) {
  const ScenarioSpec spec = OccludedCubes(4);
  TrialRunner runner(spec, EasyCube());
  for (const int trial : {0, 1}) {
    const TrialResult result = runner.Run(trial);
    ASSERT_EQ(result.picks.size(), 3u);
    size_t parts = 0;
    for (const PickRecord& pick : result.picks) {
      EXPECT_EQ(pick.target, result.picks[0].target);
      EXPECT_EQ(pick.band, 2 - pick.pick);
      // The camera's own picture, by another renderer than built the scenes.
      EXPECT_TRUE(spec.occlusion.bands[pick.band].Holds(TargetOf(pick).visible_fraction));
      EXPECT_GE(pick.instances.size(), std::max<size_t>(parts, 4)) << "no pick took a part away";
      parts = pick.instances.size();
    }
  }
}

// The oracle knows what is 10 % in view: it finds the target everywhere and aims at nothing else.
TEST(OcclusionTrial, PicksAimAtTheTargetAlone) {
  TrialRunner runner(OccludedCubes(4), EasyCube());
  int picked = 0, attempts = 0;
  for (const int trial : {0, 1, 2}) {
    for (const PickRecord& pick : runner.Run(trial).picks) {
      EXPECT_TRUE(TargetOf(pick).recalled);
      if (!pick.grasp) {
        EXPECT_EQ(pick.loss, Loss::kNoGrasp);
        continue;
      }
      ++attempts;
      EXPECT_EQ(pick.aimed, pick.target);
      picked += pick.loss == Loss::kNone;
      if (pick.loss == Loss::kNone) {
        EXPECT_EQ(pick.outcome.picked_instance, pick.target);
      }
    }
  }
  EXPECT_GE(attempts, 4);
  EXPECT_GE(picked, 3) << "one a trial at least: the free target";
}

TEST(OcclusionTrial, BothBudgetsHold) {
  TrialRunner runner(OccludedCubes(3), EasyCube());
  const TrialResult result = runner.Run(0);
  const LossBudget attempts = BudgetOfAttempts({&result, 1});
  const LossBudget instances = BudgetOfInstances({&result, 1});
  EXPECT_EQ(attempts.total, 3);
  EXPECT_EQ(instances.total, 3);
  EXPECT_EQ(attempts.lost, instances.lost);
}

TEST(OcclusionTrial, IsAFunctionOfSeedAndNumber) {
  ScenarioSpec spec = OccludedCubes(3);
  spec.estimator.noise_mm = 2;
  const ObjectSet objects = EasyCube();
  const auto text = [&](const TrialResult& result) {
    return TrialsCsv({result}) + PicksCsv({result}, {"cube"}) +
           CurveCsv(std::vector<NamedCurve>{{"", FiguresByBand({&result, 1}, spec.occlusion)}});
  };
  TrialRunner runner(spec, objects);
  const std::string zero = text(runner.Run(0)), one = text(runner.Run(1));
  EXPECT_NE(zero, one);
  EXPECT_EQ(text(runner.Run(0)), zero) << "what came before does not matter";
  EXPECT_EQ(text(TrialRunner(spec, objects).Run(1)), one) << "nor does the runner";
}

// Another estimator sees the same scenes: that is what makes a comparison paired.
TEST(OcclusionTrial, ScenesDoNotDependOnTheEstimator) {
  ScenarioSpec exact = OccludedCubes(3), noisy = exact;
  noisy.estimator.noise_mm = 40;
  const TrialResult a = TrialRunner(exact, EasyCube()).Run(0);
  const TrialResult b = TrialRunner(noisy, EasyCube()).Run(0);
  ASSERT_EQ(a.picks.size(), b.picks.size());
  int missed = 0;
  for (size_t i = 0; i < a.picks.size(); ++i) {
    EXPECT_EQ(TargetOf(a.picks[i]).visible_fraction, TargetOf(b.picks[i]).visible_fraction);
    missed += !TargetOf(b.picks[i]).recalled;
    if (!TargetOf(b.picks[i]).recalled && !b.picks[i].grasp) {
      EXPECT_THAT(b.picks[i].loss, testing::AnyOf(Loss::kPoseWrong, Loss::kNoProposal));
    }
  }
  EXPECT_GT(missed, 0) << "the case did not occur";
}

// A plate that is wider than the hand could be held by its edge alone, which lies on the floor.
TEST(OcclusionTrial, ATargetThatNoGraspFitsIsLostToThePlan) {
  const TrialResult result =
      TrialRunner(OccludedCubes(1), {BoxPart({0.12, 0.11, 0.006}, 0.2)}).Run(0);
  ASSERT_FALSE(result.picks.empty());
  for (const PickRecord& pick : result.picks) EXPECT_EQ(pick.loss, Loss::kNoGrasp);
}

// Another scene may have one, so that this ends no sweep.
TEST(OcclusionTrial, ATrialThatFindsNoSceneIsRecordedAsThat) {
  ScenarioSpec spec = OccludedCubes(2);
  spec.occlusion.bands = {{0.500, 0.502}};
  spec.occlusion.margin = 0;
  spec.occlusion.tries = spec.occlusion.targets = spec.occlusion.scenes = 1;
  const TrialResult result = TrialRunner(spec, EasyCube()).Run(3);
  EXPECT_TRUE(result.picks.empty());
  EXPECT_EQ(result.parts_dropped, 0);
  ASSERT_EQ(result.bands.size(), 1u);
  EXPECT_FALSE(result.bands[0].filled);
  const std::vector<BandFigures> bands = FiguresByBand({&result, 1}, spec.occlusion);
  EXPECT_EQ(bands[0].trials_without, 1);
  EXPECT_THAT(CurveTable(bands), HasSubstr("trials without a scene: 1; targets given up: 1"));
}

TEST(OcclusionCurve, SaysWhatToDoWhereNoTargetWasFound) {
  TrialResult trial;
  trial.bands.resize(5);
  EXPECT_THAT(CurveTable(FiguresByBand({&trial, 1}, OcclusionSpec{})),
              HasSubstr("look from higher up, drop fewer parts or end the bands lower"));
}

// A look at target 7 in band 0 that is recalled and picked as told.
PickRecord LookAt(bool recalled, bool picked, double error_diameters) {
  PickRecord look;
  look.target = 7;
  look.band = 0;
  look.instances = {{3, 0, 1.0, true}, {7, 0, 0.2, recalled}};
  HypothesisScore other, near;
  other.instance = 3;
  near.instance = 7;
  near.score = 0.4;
  near.mssd_diameters = error_diameters;
  near.translation_m = 0.01 * error_diameters;
  look.hypotheses = {other, near};
  look.loss = picked ? Loss::kNone : Loss::kSlipped;
  return look;
}

TEST(OcclusionCurve, CountsTheTargetAndNoOther) {
  OcclusionSpec spec;
  spec.bands = {{0.1, 0.3}, {0.9, 1}};
  std::vector<TrialResult> trials(3);
  for (int i = 0; i < 3; ++i) trials[i].trial = trials[i].scene = i;
  trials[0].picks = {LookAt(true, true, 0.02)};
  trials[1].picks = {LookAt(true, false, 0.06)};
  trials[2].picks = {LookAt(false, false, 0.7)};  // stands on nothing
  trials[2].bands = {{true, 1, {9, 2, 3, 3, 1}}, {false, 2, {4, 0, 4, 0, 0}}};
  const std::vector<BandFigures> bands = FiguresByBand(trials, spec);
  ASSERT_EQ(bands.size(), 2u);
  EXPECT_EQ(bands[0].looks, 3);
  EXPECT_EQ(bands[0].recalled.hits, 2);
  EXPECT_EQ(bands[0].picked.hits, 1);
  EXPECT_EQ(bands[0].recalled.ci95.low, WilsonInterval(2, 3).low) << "a scene gives one outcome";
  EXPECT_DOUBLE_EQ(bands[0].mean_visible, 0.2);
  EXPECT_EQ(bands[0].errors.looks, 2);
  EXPECT_DOUBLE_EQ(bands[0].errors.mssd_diameters.value, 0.02) << "the lower median of two";
  EXPECT_EQ(bands[0].losses.at("slipped"), 2);
  EXPECT_EQ(bands[1].looks, 0);
  EXPECT_EQ(bands[1].trials_without, 1);
  const std::string table = CurveTable(bands);
  EXPECT_THAT(table, HasSubstr("66.7 % [20.8, 93.9]"));
  EXPECT_THAT(table, HasSubstr("90-100 %: trials without a scene: 1; targets given up: 2; of 4 "
                               "blockers 0 hid too much, 0 too little, 4 disturbed the scene"));
}

// The cell of a CSV's second line under a name of its first.
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

TEST(OcclusionCurve, MediansOfErrorsHaveTheirIntervalOverScenes) {
  OcclusionSpec spec;
  spec.bands = {{0.1, 0.3}};
  std::vector<TrialResult> trials(40);
  for (int i = 0; i < 40; ++i) {
    trials[i].trial = trials[i].scene = i;
    trials[i].picks = {LookAt(true, true, 0.001 * (i + 1))};
  }
  RunSummary summary = Summarize(trials);
  summary.bands = FiguresByBand(trials, spec);
  const ErrorMedian median = summary.bands[0].errors.mssd_diameters;
  EXPECT_DOUBLE_EQ(median.ci95.low, 0.014);
  EXPECT_DOUBLE_EQ(median.value, 0.02);
  EXPECT_DOUBLE_EQ(median.ci95.high, 0.027);

  const std::string csv = CurveCsv(std::vector<NamedCurve>{{"", summary.bands}});
  EXPECT_EQ(CellOf(csv, "mssd_low"), fmt::format("{}", median.ci95.low));
  EXPECT_NEAR(std::stod(CellOf(csv, "translation_high")), 10 * median.ci95.high, 1e-9);
  EXPECT_EQ(CellOf(csv, "blockers_useless"), "0");
  EXPECT_THAT(CurveTable(summary.bands), HasSubstr("0.2 [0.1, 0.3] mm"));
  const auto json = nlohmann::json::parse(SummaryJson(summary))["target_by_visibility"][0];
  EXPECT_EQ(json["median_mssd_diameters_ci95"][1], median.ci95.high);
}

}  // namespace
}  // namespace pickbed
