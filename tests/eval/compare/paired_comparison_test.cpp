#include "eval/compare/paired_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "eval/compare/paired_tables.h"
#include "eval/trial/counts_by_bin.h"
#include "scenes/base/error.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

// An attempt at instances with the given visible fractions. The first `recalled` of them are
// recalled, and one pick is executed.
AttemptRecord Attempt(const std::vector<double>& visible, int recalled, bool picked) {
  AttemptRecord pick;
  for (size_t i = 0; i < visible.size(); ++i) {
    const InstanceId instance(i);
    pick.instances.push_back({instance, ObjectId{0}, visible[i], instance < recalled});
  }
  HypothesisRecord top;
  top.instance = InstanceId{0};
  top.correct = recalled > 0;
  top.metrics.Set(kMssdDiameters, recalled > 0 ? 0.02 : 0.3);
  pick.hypotheses = {top};
  pick.chosen = 0;
  pick.matched_instance = InstanceId{0};
  pick.grasp = Grasp{};
  pick.failure = picked ? FailureReason::kNone : FailureReason::kSlipped;
  return pick;
}

TrialResult Trial(int number, int scene, std::vector<AttemptRecord> picks) {
  TrialResult trial;
  trial.trial = number;
  trial.bin_index = BinIndex(scene);
  trial.instances_dropped = 3;
  trial.attempts = std::move(picks);
  for (const AttemptRecord& pick : trial.attempts)
    trial.instances_cleared += pick.failure == FailureReason::kNone;
  return trial;
}

// 20 bins with one pick each. `successes` lists the bins whose pick succeeds.
std::vector<TrialResult> OnePickRun(const std::vector<int>& successes, int first_trial = 0) {
  std::vector<TrialResult> trials;
  for (int i = 0; i < 20; ++i) {
    const bool picked = std::find(successes.begin(), successes.end(), i) != successes.end();
    trials.push_back(
        Trial(first_trial + i, i, {Attempt({0.95, 0.6, 0.2}, picked ? 2 : 1, picked)}));
  }
  return trials;
}

PairedStatistic StatisticOf(const PairedComparison& comparison, const std::string& key) {
  for (const PairedStatistic& statistic : comparison.statistics) {
    if (statistic.key == key) return statistic;
  }
  throw std::logic_error("no figure " + key);
}

TEST(CountByScene, TrialsOfOneBinAreOneCluster) {
  const std::vector<TrialResult> trials{Trial(7, 4, {Attempt({1, 0.5}, 1, true)}),
                                        Trial(8, 2, {Attempt({0.05, 0.95}, 2, false)}),
                                        Trial(9, 4, {Attempt({0.4, 0.4}, 0, true)})};
  EXPECT_EQ(ScenesOf(trials), (std::vector<int>{2, 4}));
  const auto picks = CountByScene(trials, SuccessOfAttempts());
  ASSERT_EQ(picks.size(), 2u);
  EXPECT_EQ(picks[0].hits, 0);
  EXPECT_EQ(picks[1].hits, 2);
  EXPECT_EQ(picks[1].samples, 2);
  const auto recall = CountByScene(trials, InstancesRecalled(0.1, 1));
  EXPECT_EQ(recall[0].samples, 1) << "an instance at 5 % visible does not count";
  EXPECT_EQ(recall[1].samples, 4);
  EXPECT_EQ(recall[1].hits, 1);
  const auto of_band = CountByScene(trials, {2, 3, 4}, InstancesRecalled(0.3, 0.5));
  EXPECT_EQ(of_band[1].samples, 0) << "a bin without trials";
  EXPECT_EQ(of_band[2].samples, 2) << "0.5 belongs to the next band";
}

// An attempt with a target counts only the target, at its visible fraction.
TEST(CountByScene, OnlyTheTargetCountsIfAnAttemptHasOne) {
  AttemptRecord attempt = Attempt({0.95, 0.4, 0.4}, 2, true);
  attempt.target = InstanceId{1};
  const std::vector<TrialResult> trials{Trial(0, 0, {attempt})};
  const auto whole = CountByScene(trials, InstancesRecalled(0.1, 1));
  EXPECT_EQ(whole[0].samples, 1);
  EXPECT_EQ(whole[0].hits, 1);
  EXPECT_EQ(CountByScene(trials, SuccessByVisibility(0.3, 0.5))[0].hits, 1);
  EXPECT_EQ(CountByScene(trials, SuccessByVisibility(0.9, 1))[0].samples, 0);
}

// Without a grasp nothing is executed, but the target counts as not picked.
TEST(CountByScene, TargetWithoutAGraspCountsAsNotPicked) {
  AttemptRecord picked = Attempt({0.95, 0.4, 0.4}, 2, true);
  picked.target = InstanceId{1};
  AttemptRecord none = picked;
  none.grasp.reset();
  none.failure = FailureReason::kNoGrasp;
  AttemptRecord untargeted = Attempt({0.4, 0.4}, 1, true);
  const std::vector<TrialResult> trials{Trial(0, 0, {picked, none, untargeted})};
  const auto of_band = CountByScene(trials, TargetsPicked(0.3, 0.5));
  EXPECT_EQ(of_band[0].samples, 2);
  EXPECT_EQ(of_band[0].hits, 1);
  EXPECT_EQ(CountByScene(trials, SuccessByVisibility(0.3, 0.5))[0].samples, 2);
  EXPECT_EQ(CountByScene(trials, TargetsPicked(0.9, 1))[0].samples, 0);
}

// One pick per bin. The discordant counts of McNemar's table are 2 and 9, counted by hand.
TEST(ComparePaired, OneOutcomePerBinUsesMcNemarsTest) {
  const auto before = OnePickRun({0, 1, 2, 3, 4, 5});
  const auto after = OnePickRun({2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14}, 100);
  const PairedComparison comparison = ComparePaired(before, after);
  EXPECT_EQ(comparison.scenes, 20);
  const PairedStatistic success = StatisticOf(comparison, "pick_success");
  EXPECT_EQ(success.test, "mcnemar");
  EXPECT_DOUBLE_EQ(success.before, 0.3);
  EXPECT_DOUBLE_EQ(success.after, 0.65);
  EXPECT_EQ(success.discordant_scenes, 11);
  EXPECT_NEAR(success.p_value, 2 * (1 + 11 + 55) / 2048.0, 1e-12);
  ASSERT_TRUE(success.odds_ratio);
  EXPECT_DOUBLE_EQ(success.odds_ratio->ratio, 4.5);
  EXPECT_GT(success.scenes_needed.value_or(0), 20) << "p > 0.05, so 20 bins are too few";
  EXPECT_LT(success.difference_ci95.low, 0.35);
  EXPECT_GT(success.difference_ci95.high, 0.35);
  // Three instances per bin are not one outcome.
  EXPECT_EQ(StatisticOf(comparison, "recall").test, "sign_flip");
  EXPECT_EQ(StatisticOf(comparison, "recall_90_100").test, "mcnemar");
  EXPECT_EQ(StatisticOf(comparison, "recall_90_100").p_value, 1);
}

TEST(ComparePaired, RatesUseTheBandsOfTheRuns) {
  const auto run = OnePickRun({0, 1});
  const PairedComparison comparison = ComparePaired(run, run, {{0.15, 0.225}, {0.5, 0.7}});
  EXPECT_EQ(StatisticOf(comparison, "recall_15_22.5").name, "recall, 15-22.5 % visible");
  EXPECT_EQ(StatisticOf(comparison, "recall_50_70").scenes, 20);
  EXPECT_EQ(StatisticOf(comparison, "recall").scenes, 20) << "all instances at least 10 % visible";
  EXPECT_THROW(StatisticOf(comparison, "recall_90_100"), std::logic_error);
}

TEST(ComparePaired, BinsArePairedByIndexAndOnlySharedOnesCount) {
  auto before = OnePickRun({0, 1, 2}), after = OnePickRun({0, 1, 2, 3, 4}, 50);
  std::reverse(after.begin(), after.end());
  before.erase(before.begin());  // bin 0
  after.erase(after.begin());    // bin 19
  const PairedComparison comparison = ComparePaired(before, after);
  EXPECT_EQ(comparison.scenes, 18);
  EXPECT_EQ(comparison.before_only, 1);
  EXPECT_EQ(comparison.after_only, 1);
  const PairedStatistic success = StatisticOf(comparison, "pick_success");
  EXPECT_DOUBLE_EQ(success.before, 2 / 18.0);
  EXPECT_DOUBLE_EQ(success.after, 4 / 18.0);
  EXPECT_EQ(success.discordant_scenes, 2);
}

TEST(ComparePaired, ErrorsAreComparedByTheirMedian) {
  auto before = OnePickRun({}), after = OnePickRun({});
  for (int i = 0; i < 20; ++i) {
    before[i].attempts[0].hypotheses[0].metrics.Set(kMssdDiameters, 0.02 + 0.001 * i);
    after[i].attempts[0].hypotheses[0].metrics.Set(kMssdDiameters, 0.01 + 0.001 * i);
  }
  before[3].attempts[0].hypotheses[0].metrics.Set(kMssdDiameters, 2);  // on no instance
  const PairedStatistic median = StatisticOf(ComparePaired(before, after), "median_mssd_diameters");
  EXPECT_FALSE(median.is_rate);
  EXPECT_NEAR(median.difference(), -0.01, 1.1e-3);
  EXPECT_LE(median.difference_ci95.high, -0.007);
  EXPECT_LT(median.p_value, 0.01);
}

// Five bins that all have the same sign still give p > 0.05, so no interval may exclude 0.
TEST(ComparePaired, MedianOverTooFewBinsHasNoInterval) {
  auto before = OnePickRun({}), after = OnePickRun({});
  for (int i = 0; i < 20; ++i) after[i].attempts[0].hypotheses[0].metrics.Set(kMssdDiameters, 0.01);
  const auto median = [&](int scenes) {
    before.resize(scenes);
    after.resize(scenes);
    return StatisticOf(ComparePaired(before, after), "median_mssd_diameters");
  };
  EXPECT_TRUE(std::isfinite(median(6).difference_ci95.high));
  const PairedStatistic few = median(5);
  EXPECT_GT(few.p_value, 0.05);
  EXPECT_TRUE(std::isinf(few.difference_ci95.low));
  EXPECT_TRUE(std::isinf(few.difference_ci95.high));
  EXPECT_THAT(PairedTable({5, 0, 0, {few}}), HasSubstr(" (too few bins)"));
}

TEST(PairedTable, RowsWithoutADifferenceAreFoldedAndNamesKeepTheColumns) {
  PairedStatistic differs{"a", "recall, 90-100 % visible, of the targets of all bins", true, 0.5,
                          0.7};
  differs.scenes = 20;
  differs.discordant_scenes = 4;
  PairedStatistic same{"b", "precision", true, 0.9, 0.9};
  same.scenes = 20;
  const PairedComparison comparison{20, 0, 0, {differs, same, same}};
  const std::string folded = PairedTable(comparison), all = PairedTable(comparison, true);
  EXPECT_THAT(folded, HasSubstr("2 more rows without a difference in any scene\n"));
  EXPECT_THAT(PairedTable(comparison, false, "ask for them"),
              HasSubstr("2 more rows without a difference in any scene; ask for them\n"));
  EXPECT_THAT(folded, testing::Not(HasSubstr("precision")));
  EXPECT_THAT(all, HasSubstr("precision"));
  EXPECT_THAT(all, testing::Not(HasSubstr("more rows")));
  // The header and the rows of the table end in the same column.
  std::istringstream lines(all);
  std::set<size_t> lengths;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("  ")) lengths.insert(line.size());
  }
  EXPECT_EQ(lengths.size(), 1u) << all;
}

// The second run also finds the difficult instance and is as accurate as the first on the easy one.
TEST(ComparePaired, ErrorsUseOnlyInstancesThatBothRunsFound) {
  auto before = OnePickRun({}), after = OnePickRun({});
  for (int i = 0; i < 20; ++i) {
    std::vector<HypothesisRecord>& a = before[i].attempts[0].hypotheses;
    std::vector<HypothesisRecord>& b = after[i].attempts[0].hypotheses;
    a[0].metrics.Set(kMssdDiameters, 0.02);
    b[0].metrics.Set(kMssdDiameters, 0.02);
    a[0].score = b[0].score = 0.9;
    b.push_back(b[0]);  // on the same instance with a lower score
    b.back().score = 0.3;
    b.back().metrics.Set(kMssdDiameters, 0.4);
    b.push_back(b.back());
    b.back().instance = InstanceId{2};
    b.back().score = 0.8;
  }
  const PairedStatistic median = StatisticOf(ComparePaired(before, after), "median_mssd_diameters");
  EXPECT_DOUBLE_EQ(median.before, 0.02);
  EXPECT_DOUBLE_EQ(median.after, 0.02);
  EXPECT_EQ(median.discordant_scenes, 0);

  for (TrialResult& trial : after) trial.attempts[0].target = InstanceId{2};
  for (const PairedStatistic& statistic : ComparePaired(before, after).statistics) {
    EXPECT_TRUE(statistic.is_rate) << "no instance was found by both: " << statistic.key;
  }
}

TEST(ComparePaired, EqualRunsHaveNoDifference) {
  const auto run = OnePickRun({0, 1, 2, 3});
  const PairedComparison comparison = ComparePaired(run, run);
  ASSERT_FALSE(comparison.statistics.empty());
  for (const PairedStatistic& statistic : comparison.statistics) {
    EXPECT_EQ(statistic.difference(), 0) << statistic.key;
    EXPECT_EQ(statistic.p_value, 1) << statistic.key;
    EXPECT_FALSE(statistic.scenes_needed) << statistic.key;
    if (!statistic.is_rate) continue;
    EXPECT_GT(statistic.difference_ci95.high, 0.05) << statistic.key;
  }
}

TEST(ComparePaired, RunsWithoutASharedBinAreRefusedInOneLine) {
  auto other = OnePickRun({});
  for (TrialResult& trial : other) trial.bin_index = BinIndex(trial.bin_index + 1000);
  const std::string error = ErrorOf([&] { ComparePaired(OnePickRun({}), other); });
  EXPECT_THAT(error, HasSubstr("share no scenes"));
  EXPECT_EQ(error.find('\n'), std::string::npos);
}

constexpr char kSettings[] =
    "seed: 3\ntrials: 40\nbin:\n  wall_m: 0.006\nobjects:\n  - name: rod\n    count: 5\n"
    "arrangement: pile\ncamera:\n  width: 640\nsensor: ideal\nestimator:\n  name: ppf\n"
    "# part rod is 0123\n# model 77\n";

std::string With(const std::string& old_text, const std::string& new_text) {
  std::string settings = kSettings;
  return settings.replace(settings.find(old_text), old_text.size(), new_text);
}

TEST(SceneKey, DependsOnlyOnSettingsOfTheDrop) {
  for (const auto& [a, b] : {std::pair{"trials: 40", "trials: 7"},
                             {"name: ppf", "name: oracle"},
                             {"sensor: ideal", "sensor: time_of_flight"},
                             {"# model 77", "# model 8"},
                             {"sensor: ideal", "fill: 0"},
                             {"sensor: ideal", "cell:\n  hand_eye_mm: 2\n  size_percent: 0"},
                             {"width: 640", "width: 320"}}) {
    EXPECT_EQ(SceneKey(With(a, b)), SceneKey(kSettings)) << a;
  }
  for (const auto& [a, b] : {std::pair{"seed: 3", "seed: 4"},
                             {"0.006", "0.004"},
                             {"count: 5", "count: 6"},
                             {"arrangement: pile", "arrangement: heap"},
                             {"sensor: ideal", "fill: 0.5"},
                             {"sensor: ideal", "cell:\n  size_percent: 1"},
                             {"is 0123", "is 9999"}}) {
    EXPECT_NE(SceneKey(With(a, b)), SceneKey(kSettings)) << a;
  }
}

std::string Occluded(const std::string& settings, const std::string& minimum = "0.1") {
  return settings + "occlusion:\n  enabled: true\n  bands:\n    - min: " + minimum + "\n";
}

// Blockers are dropped along the line of sight until the bands are filled.
TEST(SceneKey, IncludesCameraAndBandsOfOcclusionTrials) {
  const std::string key = SceneKey(Occluded(kSettings));
  EXPECT_EQ(SceneKey(Occluded(With("name: ppf", "name: oracle"))), key);
  EXPECT_NE(SceneKey(Occluded(With("width: 640", "width: 320"))), key);
  EXPECT_NE(SceneKey(Occluded(kSettings, "0.2")), key);
  EXPECT_NE(SceneKey(kSettings), key);
  const std::string off = "occlusion:\n  enabled: false\n  margin: 0.1\n";
  EXPECT_EQ(SceneKey(kSettings + off), SceneKey(kSettings))
      << "trials without occlusion have no bands";
}

TEST(RequireSameScenes, NamesTheDifferingOcclusionSetting) {
  const auto error = [](const std::string& a, const std::string& b) {
    return ErrorOf([&] { RequireSameScenes(a, b, "A", "B"); });
  };
  EXPECT_THAT(error(Occluded(kSettings), Occluded(kSettings, "0.2")),
              HasSubstr("differ in occlusion: 'min: 0.1' in one, 'min: 0.2' in the other"));
  EXPECT_THAT(error(Occluded(kSettings), Occluded(With("width: 640", "width: 320"))),
              HasSubstr("differ in camera: 'width: 640' in one"));
  EXPECT_THAT(error(Occluded(kSettings), kSettings),
              HasSubstr("'occlusion.enabled: true' in one, 'occlusion.enabled: false'"));
}

TEST(RequireSameScenes, NamesTheDifferingSetting) {
  RequireSameScenes(kSettings, With("name: ppf", "name: oracle"), "A", "B");
  const std::string error = ErrorOf(
      [] { RequireSameScenes(kSettings, With("count: 5", "count: 6"), "runs/a", "runs/b"); });
  EXPECT_THAT(error, HasSubstr("runs/a and runs/b share no scenes"));
  EXPECT_THAT(error, HasSubstr("differ in objects: 'count: 5' in one, 'count: 6' in the other"));
}

TEST(PairedTable, AgreesWithTheJson) {
  const auto before = OnePickRun({0, 1, 2, 3, 4, 5});
  const auto after = OnePickRun({2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14});
  const PairedComparison comparison = ComparePaired(before, after);
  const std::string table = PairedTable(comparison);
  EXPECT_THAT(table, HasSubstr("pick success, %"));
  EXPECT_THAT(table, HasSubstr("+35.0 ["));
  EXPECT_THAT(table, HasSubstr("11/20"));
  const auto json = nlohmann::json::parse(PairedJson(comparison));
  EXPECT_EQ(json["scenes"], 20);
  EXPECT_EQ(json["statistics"][0]["key"], "pick_success");
  EXPECT_NEAR(json["statistics"][0]["difference"], 0.35, 1e-12);
  EXPECT_EQ(json["statistics"][0]["odds_ratio"], 4.5);
  EXPECT_TRUE(json["statistics"].back()["scenes_needed"].is_null());
}

TEST(CompareConfigurations, ReportsNamesAndUsesTheBandsOfTheRun) {
  ConfigurationTrials a{"runs/a", {"rod"}, OnePickRun({0, 1, 2}), {}};
  ConfigurationTrials b{"runs/b", {"rod"}, OnePickRun({2, 3, 4, 5}), {}};
  a.bands = b.bands = {{0.15, 0.25}};
  const std::vector<ConfigurationComparison> compared =
      CompareWithFirst({{&a, kSettings}, {&b, kSettings}});
  ASSERT_EQ(compared.size(), 1u);
  EXPECT_THAT(ComparisonText(compared), HasSubstr("A is runs/a, B is runs/b; 20 scenes"));
  const auto json = nlohmann::json::parse(ComparisonJson(compared))["comparisons"][0];
  EXPECT_EQ(json["first"], "runs/a");
  EXPECT_EQ(json["second"], "runs/b");
  EXPECT_EQ(json["statistics"][0]["discordant_scenes"], 5);
  const ReportTable table = PairedReport(compared[0]);
  EXPECT_THAT(table.text, HasSubstr("only for rates, not for medians"));
  std::vector<std::string> names;
  for (const auto& row : table.cells) names.push_back(row[0]);
  EXPECT_THAT(names, testing::Contains("recall, 15-25 % visible"));
  EXPECT_THAT(names, testing::Not(testing::Contains("recall, 10-30 % visible")));
}

TEST(CompareConfigurations, EachSeedOfASweepIsComparedWithItsOwnFirstConfiguration) {
  const ConfigurationTrials runs[] = {{"a,seed=3", {"rod"}, OnePickRun({0, 1}), {}},
                                      {"a,seed=4", {"rod"}, OnePickRun({0, 2}), {}},
                                      {"b,seed=3", {"rod"}, OnePickRun({0, 3}), {}},
                                      {"b,seed=4", {"rod"}, OnePickRun({0, 4}), {}}};
  const std::string other_seed = With("seed: 3", "seed: 4");
  const std::vector<ConfigurationComparison> compared = CompareWithFirst({{&runs[0], kSettings},
                                                                          {&runs[1], other_seed},
                                                                          {&runs[2], kSettings},
                                                                          {&runs[3], other_seed}});
  ASSERT_EQ(compared.size(), 2u);
  EXPECT_EQ(compared[0].before, "a,seed=3");
  EXPECT_EQ(compared[0].after, "b,seed=3");
  EXPECT_EQ(compared[1].before, "a,seed=4");
  EXPECT_EQ(compared[1].after, "b,seed=4");
}

}  // namespace
}  // namespace pickbed::tests
