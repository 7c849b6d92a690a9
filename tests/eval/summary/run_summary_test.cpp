#include "eval/summary/run_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "eval/summary/run_csv.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

AttemptRecord Pick(FailureReason failure, bool top_correct) {
  AttemptRecord pick;
  pick.instances = {{InstanceId{0}, ObjectId{0}, 0.95, true},
                    {InstanceId{1}, ObjectId{0}, 0.4, false},
                    {InstanceId{2}, ObjectId{0}, 0.05, false}};
  HypothesisRecord top;
  top.correct = top_correct;
  pick.hypotheses = {top};
  pick.chosen = 0;
  pick.grasp = Grasp{};
  pick.failure = failure;
  return pick;
}

// Two bins. The first has three attempts, one of which fails. The second ends without a proposal.
// (A trial that ends by a failed attempt has its failure twice, also as ended_by. It counts once.)
std::vector<TrialResult> TwoTrials() {
  TrialResult a;
  a.trial = 0;
  a.instances_dropped = 5;
  a.instances_cleared = 2;
  a.attempts = {Pick(FailureReason::kNone, true), Pick(FailureReason::kSlipped, true),
                Pick(FailureReason::kNone, false)};
  a.seconds = {{"drop", 2.0}, {"icp", 1.0}};
  TrialResult b;
  b.trial = b.bin_index = BinIndex{1};
  b.instances_dropped = 5;
  b.ended_by = FailureReason::kNoProposal;
  AttemptRecord empty;
  empty.instances = {{InstanceId{3}, ObjectId{0}, 1.0, false}};
  empty.failure = FailureReason::kNoProposal;
  b.attempts = {empty};
  b.seconds = {{"drop", 4.0}};
  return {a, b};
}

// Each bin counts once, with its first image.
TEST(Summarize, ClutterCountsEachBinBeforeTheFirstPick) {
  std::vector<TrialResult> trials = TwoTrials();
  EXPECT_EQ(Summarize(trials).clutter.bins, 0) << "trials of earlier versions";
  EXPECT_THAT(SummaryTable(Summarize(trials)), Not(HasSubstr("Before the first pick")));
  trials[0].layers = {2, 1};
  trials[0].instances_tested = 2;
  trials[0].instances_graspable = 1;
  trials[0].attempts[0].fill_level = 0.6;
  trials[1].layers = {1};
  trials[1].attempts[0].fill_level = 0.2;
  const RunSummary s = Summarize(trials);
  const auto clutter = nlohmann::json::parse(SummaryJson(s)).at("clutter");
  EXPECT_EQ(clutter.at("bins"), 2);
  EXPECT_DOUBLE_EQ(clutter.at("fill_level"), 0.4);
  EXPECT_EQ(clutter.at("layers"), (std::vector<int>{3, 1}));
  EXPECT_EQ(clutter.at("in_view").at("90-100"), 2);
  EXPECT_EQ(clutter.at("in_view").at("30-50"), 1);
  EXPECT_EQ(clutter.at("in_view").at("0-10"), 7) << "the other dropped instances";
  EXPECT_EQ(clutter.at("counted"), 3);
  EXPECT_EQ(clutter.at("tested"), 2);
  EXPECT_EQ(clutter.at("graspable"), 1);
  EXPECT_THAT(SummaryTable(s),
              HasSubstr("\n  1 of 2 tested instances that are at least 10 % visible"));
}

TEST(Summarize, AgreesWithCountsByHand) {
  const RunSummary s = Summarize(TwoTrials());
  EXPECT_EQ(s.trials, 2);
  EXPECT_EQ(s.executed_grasps, 3);
  EXPECT_EQ(s.successes, 2);
  EXPECT_DOUBLE_EQ(s.success_rate, 2.0 / 3);
  EXPECT_DOUBLE_EQ(s.cleared_rate, 0.2);
  EXPECT_EQ(s.frames, 3);
  EXPECT_DOUBLE_EQ(s.top1_precision, 2.0 / 3);
  EXPECT_EQ(s.failures, (std::map<std::string, int>{{"slipped", 1}, {"no_proposal", 1}}));
  EXPECT_DOUBLE_EQ(s.seconds.at("drop"), 3.0);
  EXPECT_DOUBLE_EQ(s.seconds.at("icp"), 0.5);
}

// Three attempts. The second holds a wrong instance, and the third only touches its instance.
TEST(Summarize, ReportsTheRateOfEverySuccessRule) {
  auto trials = TwoTrials();
  const auto pass = [&](int pick, std::initializer_list<SuccessRule> rules) {
    for (const SuccessRule rule : rules) {
      trials[0].attempts[pick].outcome.verdicts[static_cast<int>(rule)] = true;
    }
  };
  pass(0, {SuccessRule::kContact, SuccessRule::kHeld, SuccessRule::kRightInstance});
  pass(1, {SuccessRule::kContact, SuccessRule::kHeld});
  pass(2, {SuccessRule::kContact});
  // The verdict of an attempt without a grasp does not count.
  trials[1].attempts[0].outcome.verdicts[static_cast<int>(SuccessRule::kHeld)] = true;
  const RunSummary summary = Summarize(trials);
  const auto json = nlohmann::json::parse(SummaryJson(summary))["success_by_rule"];
  ASSERT_EQ(json.size(), static_cast<size_t>(kSuccessRules));
  EXPECT_EQ(json["contact"]["successes"], 3);
  EXPECT_EQ(json["held"]["successes"], 2);
  EXPECT_EQ(json["right_instance"]["successes"], 1);
  EXPECT_EQ(json["placed"]["successes"], 0);
  EXPECT_DOUBLE_EQ(json["held"]["rate"], 2.0 / 3);
  EXPECT_TRUE(json["held"]["ci95"].is_null()) << "all three attempts are in one bin";
  EXPECT_EQ(json["held"]["ci95_missing"], "too few bins");
  const std::string table = SummaryTable(summary);
  EXPECT_NE(table.find("Success of 3 executed grasps by rule"), std::string::npos);
  EXPECT_NE(table.find("vgn_loose"), std::string::npos);
}

// A stir is a failed pick without a grasp.
TEST(Summarize, StirsAreNamedBesideTheGrasps) {
  auto trials = TwoTrials();
  trials[1].attempts.push_back(trials[1].attempts[0]);  // no proposal
  trials[1].attempts[0].failure = FailureReason::kStirred;
  const std::string table = SummaryTable(Summarize(trials));
  EXPECT_THAT(table, HasSubstr("2 of 4 executed grasps and stirs (1 stir)"));
  EXPECT_THAT(table, HasSubstr("2 of 5 attempts (2 without a grasp, of them 1 stir)"));
}

// Forty bins in which either every pick succeeds or none. More picks per bin add no information.
TEST(Summarize, RateIntervalsAreOverBins) {
  std::vector<TrialResult> trials;
  for (int i = 0; i < 40; ++i) {
    TrialResult& trial = trials.emplace_back();
    trial.trial = trial.bin_index = BinIndex(i);
    trial.instances_dropped = 10;
    trial.instances_cleared = i % 2 ? 10 : 0;
    trial.attempts.assign(10, Pick(i % 2 ? FailureReason::kNone : FailureReason::kSlipped, i % 2));
  }
  const RunSummary summary = Summarize(trials);
  const Interval of_bins = WilsonInterval(20, 40);
  for (const Interval& interval : {summary.success_ci95, summary.cleared_ci95, summary.top1_ci95}) {
    EXPECT_NEAR(interval.low, of_bins.low, 0.01);
    EXPECT_NEAR(interval.high, of_bins.high, 0.01);
  }
  // All are recalled in every image. The 40 bins count, not the 400 images.
  EXPECT_GE(summary.recall_ci95[4].low, WilsonInterval(40, 40).low);
  EXPECT_LT(summary.recall_ci95[4].low, WilsonInterval(400, 400).low);
  EXPECT_FALSE(summary.recall_ci95[0].is_known()) << "there is no instance to recall";
}

TEST(Summarize, RefusedScenesAreListedWithTheirReasons) {
  TrialResult trial;
  trial.trial = 7;
  trial.refused = {{0, {"not at rest"}}, {1, {"overlap", "2 parts fell outside the bin"}}};
  const RunSummary summary = Summarize({trial, TrialResult()});
  ASSERT_EQ(summary.refused.size(), 2u);
  EXPECT_EQ(summary.refused[1].trial, 7);
  const std::string table = SummaryTable(summary);
  EXPECT_NE(table.find("Scenes rejected and dropped again: 2 of 4"), std::string::npos);
  EXPECT_NE(table.find("trial 7, attempt 1: overlap, 2 parts fell outside"), std::string::npos);
  EXPECT_EQ(SummaryTable(Summarize({TrialResult()})).find("refused"), std::string::npos);
}

TEST(Summarize, InstancesBelowTenPercentVisibleCountInNoBand) {
  const RunSummary s = Summarize(TwoTrials());
  int instances = 0;
  for (const RecallBand& band : s.recall_by_visibility) instances += band.instances;
  EXPECT_EQ(instances, 7);
  EXPECT_EQ(s.recall_by_visibility[1].instances, 3);
  EXPECT_EQ(s.recall_by_visibility[1].recalled, 0);
  EXPECT_EQ(s.recall_by_visibility[4].instances, 4);  // 100 % visible belongs to the last band
  EXPECT_EQ(s.recall_by_visibility[4].recalled, 3);
}

TEST(Summarize, SuccessByFillLevelIsInBandsOfTenPercent) {
  auto trials = TwoTrials();
  std::vector<AttemptRecord>& attempts = trials[0].attempts;
  attempts[0].fill_level = 0.55;
  attempts[1].fill_level = 0.5;
  attempts[2].fill_level = 1.2;
  attempts.push_back(Pick(FailureReason::kNone, true));  // unknown, as in earlier results
  attempts.push_back(AttemptRecord());                   // without a grasp
  attempts.back().fill_level = 0.55;
  const auto json = nlohmann::json::parse(SummaryJson(Summarize(trials)))["success_by_fill"];
  ASSERT_EQ(json.size(), 2u);
  EXPECT_EQ(json["50-60"]["executed_grasps"], 2);
  EXPECT_EQ(json["50-60"]["successes"], 1);
  EXPECT_EQ(json["100-"]["executed_grasps"], 1);
  EXPECT_DOUBLE_EQ(json["100-"]["rate"], 1);
}

TEST(Summarize, AttemptsStateFillLevelAndLayer) {
  auto trials = TwoTrials();
  trials[0].attempts[0].fill_level = 0.256;
  trials[0].attempts[0].layer = 2;
  trials[0].attempts[0].instances_above = 3;
  trials[0].attempts[0].instances_below = 4;
  const std::string csv = AttemptsCsv(trials, {"cube"});
  EXPECT_THAT(csv, HasSubstr("0,0,0,0,-1,-1,3,25.60,1,cube,-1,2,3,4,0,"));
  EXPECT_THAT(csv, HasSubstr("0,0,0,0,-1,-1,3,,1,cube,-1,,,,0,")) << "unknown is empty";
}

// 4 images, 3 grasps, 2 picked instances: (4 * 1 + 4 * 2 + 3 * 6) / 2 = 15 s per instance.
TEST(Summarize, PicksPerHourFollowFromGivenTimes) {
  const RunSummary stated = Summarize(TwoTrials(), {1, 2, 6});
  EXPECT_DOUBLE_EQ(stated.cycle.sense_s, 2);
  EXPECT_DOUBLE_EQ(stated.cycle.compute_s, 4);
  EXPECT_DOUBLE_EQ(stated.cycle.move_s, 9);
  EXPECT_DOUBLE_EQ(stated.cycle.picks_per_hour(), 240);
  const auto json = nlohmann::json::parse(SummaryJson(stated));
  EXPECT_EQ(json["picks_per_hour"], 240);
  EXPECT_EQ(json["cycle"]["move_s"], 9);
  EXPECT_EQ(json["cycle"]["compute_s"], 4);
  EXPECT_EQ(json["cycle"]["hidden_s"], 0);
  EXPECT_NE(SummaryTable(stated).find("240"), std::string::npos);
}

// The second and third image of the first bin are captured behind a motion; the first image of each
// bin is not. (4 * 3 + 3 * 6 - 2 * min(3, 6 - 2)) / 2 = 12 s.
TEST(Summarize, OverlapHidesTheShorterTime) {
  CycleSpec cycle{1, 2, 6};
  cycle.overlap = true;
  cycle.in_bin_s = 2;
  const CycleTime hidden = Summarize(TwoTrials(), cycle).cycle;
  EXPECT_DOUBLE_EQ(hidden.hidden_s, 3);
  EXPECT_DOUBLE_EQ(hidden.pick_s(), 12);
  EXPECT_DOUBLE_EQ(hidden.stated_pick_s(), 12);
  // With 5 s to compute, only the 4 s outside the bin hide something.
  cycle.compute_s = 5;
  EXPECT_DOUBLE_EQ(Summarize(TwoTrials(), cycle).cycle.hidden_s, 4);
  cycle.in_bin_s = 6;
  EXPECT_DOUBLE_EQ(Summarize(TwoTrials(), cycle).cycle.hidden_s, 0);
}

// A pick with its own image after a successful one takes in_bin_s + max(sense_s + compute_s,
// move_s - in_bin_s). Many picks in one bin approach this time.
TEST(Summarize, OverlapTakesTheMaximumInsteadOfTheSum) {
  TrialResult trial;
  trial.attempts.assign(1000, Pick(FailureReason::kNone, true));
  trial.instances_cleared = 1000;
  for (const double compute_s : {1.0, 8.0}) {
    CycleSpec cycle{0.5, compute_s, 6};
    EXPECT_DOUBLE_EQ(Summarize({trial}, cycle).cycle.pick_s(), 0.5 + compute_s + 6);
    cycle.overlap = true;
    EXPECT_NEAR(Summarize({trial}, cycle).cycle.pick_s(), 2 + std::max(0.5 + compute_s, 4.0), 0.01);
  }
}

TEST(Summarize, OverlapWithAMeasuredTimeKeepsTheStatedNumber) {
  auto trials = TwoTrials();
  trials[0].seconds["estimate"] = 3;  // 1 s per image
  CycleSpec cycle{1, 0, 6};
  cycle.overlap = true;
  const CycleTime time = Summarize(trials, cycle).cycle;
  EXPECT_DOUBLE_EQ(time.hidden_s, 2);
  EXPECT_DOUBLE_EQ(time.stated_hidden_s, 1);
  EXPECT_DOUBLE_EQ(time.stated_pick_s(), 10);
}

TEST(Summarize, MeasuredComputeTimeIsOnlyInTheTimings) {
  auto trials = TwoTrials();
  trials[0].seconds["estimate"] = 5;
  trials[0].seconds["estimate/icp"] = 3;  // included in estimate
  trials[1].seconds["plan"] = 1;
  const RunSummary measured = Summarize(trials, {1, 0, 6});
  EXPECT_DOUBLE_EQ(measured.cycle.compute_s, 3);
  EXPECT_TRUE(measured.cycle.measured);
  // 2 s and 9 s per instance; 14 s with the measured time. File and console have the same number.
  EXPECT_DOUBLE_EQ(nlohmann::json::parse(SummaryJson(measured))["picks_per_hour"], 3600.0 / 11);
  EXPECT_THAT(SummaryTable(measured), HasSubstr("picks per hour            327  per instance"));
  EXPECT_THAT(SummaryTable(measured), HasSubstr("257 with the 3.0 s to compute measured here"));
  EXPECT_NE(TimingsCsv(trials, measured.cycle).find("all,cycle/part,14.000000"), std::string::npos);
}

// Three attempts with two counted instances and one hidden one, and one with a visible instance.
TEST(Summarize, RecallPrecisionAndHiddenInstancesAreOverAllInView) {
  const RunSummary s = Summarize(TwoTrials());
  EXPECT_EQ(s.recall.samples, 7);
  EXPECT_EQ(s.recall.hits, 3);
  EXPECT_EQ(s.precision.samples, 3);
  EXPECT_EQ(s.precision.hits, 3);
  EXPECT_EQ(s.in_view, (std::vector<int>{3, 0, 3, 0, 0, 4}));
  const std::string table = SummaryTable(s);
  EXPECT_THAT(table, HasSubstr("recall                    42.9 %  3 of 7 instances"));
  EXPECT_THAT(table, HasSubstr("3 of 3 poses, 0 false"));
  EXPECT_THAT(table, HasSubstr("3 of 10 instances in view were under 10 % visible and are not "
                               "counted; an instance counts once per image.\n  4 of the 7"));
  EXPECT_THAT(table, HasSubstr("4 of the 7 counted were over 90 % visible, and 3 under 50 %.\n"));
  const auto json = nlohmann::json::parse(SummaryJson(s));
  EXPECT_EQ(json["recall"]["recalled"], 3);
  EXPECT_EQ(json["false_positives"], 0);
  EXPECT_EQ(json["in_view"]["0-10"], 3);
  EXPECT_FALSE(json.contains("target_recall"));
}

TEST(Summarize, AnEasyBinIsCalledEasy) {
  TrialResult trial;
  AttemptRecord attempt;
  for (int i = 0; i < 10; ++i) {
    attempt.instances.push_back({InstanceId{i}, ObjectId{0}, i == 0 ? 0.5 : 0.95, true});
  }
  trial.attempts = {attempt};
  EXPECT_THAT(InViewText(Summarize({trial})),
              HasSubstr("9 of the 10 counted were over 90 % visible: an easy bin."));
}

// The headline of a run that asks for a few instances counts those, not all that were dropped.
TEST(Summarize, ClearedAreCountedAmongTheRequested) {
  auto trials = TwoTrials();
  trials[0].outcomes = {{InstanceId{0}, ObjectId{0}, true, true, FailureReason::kNone, 0},
                        {InstanceId{1}, ObjectId{0}, true, true, FailureReason::kNone, 2},
                        {InstanceId{2}, ObjectId{0}, false, true, FailureReason::kSlipped, 1},
                        {InstanceId{3}, ObjectId{0}, false, false, FailureReason::kNone, -1},
                        {InstanceId{4}, ObjectId{0}, false, false, FailureReason::kNone, -1}};
  const RunSummary s = Summarize({trials[0]});
  EXPECT_EQ(s.requested_picked.hits, 2);
  EXPECT_EQ(s.requested_picked.samples, 3);
  EXPECT_THAT(SummaryTable(s), HasSubstr("2 of 3 requested, of 5 dropped in 1 bin"));
  EXPECT_EQ(nlohmann::json::parse(SummaryJson(s))["requested"]["instances"], 3);
}

// An attempt without a grasp is a failure of the run, although it is none of an executed grasp.
TEST(Summarize, AttemptsWithoutAGraspAreCounted) {
  const RunSummary s = Summarize(TwoTrials());
  EXPECT_EQ(s.attempts_picked.samples, 4);
  EXPECT_EQ(s.attempts_picked.hits, 2);
  EXPECT_THAT(SummaryTable(s), HasSubstr("2 of 4 attempts (1 without a grasp)"));
}

TEST(Summarize, FewBinsAreSaid) {
  const std::string table = SummaryTable(Summarize(TwoTrials()));
  EXPECT_THAT(table, testing::EndsWith(
                         "\n2 bins are too few for an interval, which needs 5; use 20 or more.\n"));
  EXPECT_THAT(table, testing::Not(HasSubstr("too few bins")));
  EXPECT_THAT(SummaryTable(Summarize(std::vector<TrialResult>(20))),
              testing::Not(HasSubstr("use 20 or more")));
}

TEST(Summarize, NoFailureIsSaidInWords) {
  TrialResult trial;
  trial.instances_dropped = trial.instances_cleared = 1;
  trial.attempts = {Pick(FailureReason::kNone, true)};
  EXPECT_THAT(SummaryTable(Summarize({trial})), HasSubstr("  no pick failed\n"));
}

TEST(Summarize, EmptyRunHasOnlyFiniteNumbers) {
  const auto json = nlohmann::json::parse(SummaryJson(Summarize({})));
  EXPECT_EQ(json["executed_grasps"], 0);
  EXPECT_EQ(json["success_rate"], 0.0);
  EXPECT_TRUE(json["success_ci95"].is_null());
  EXPECT_TRUE(json["recall"]["rate"].is_null());
}

// Each optional member changes when the list of members moves to more memory.
TEST(SummaryJson, ThePickTimeDoesNotDependOnTheOtherMembers) {
  RunSummary summary = Summarize(TwoTrials());
  summary.cycle = {};
  summary.cycle.sense_s = 5;
  summary.cycle.move_s = 10;
  for (int members = 0; members < 16; ++members) {
    summary.retention.picks = members & 1;
    summary.drop_times.drops = (members & 2) / 2;
    summary.bands.resize((members & 4) / 4);
    summary.clutter.bins = (members & 8) / 8;
    const auto json = nlohmann::json::parse(SummaryJson(summary));
    EXPECT_EQ(json["picks_per_hour"], 240) << members;
    EXPECT_EQ(json["cycle"]["move_s"], 10) << members;
  }
}

TEST(SummaryJson, HasTheKeysThatScriptsRead) {
  const auto json = nlohmann::json::parse(SummaryJson(Summarize(TwoTrials())));
  for (const char* key : {"trials", "executed_grasps", "successes", "success_rate", "success_ci95",
                          "cleared_rate", "top1_precision", "recall_by_visibility", "failures"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_FALSE(json.contains("seconds")) << "times are in a separate file";
  EXPECT_EQ(json["failures"]["slipped"], 1);
}

TEST(Csv, HasOneLinePerTrialAndPerAttempt) {
  const auto count = [](const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(count(TrialsCsv(TwoTrials())), 1 + 2);
  const std::string picks = AttemptsCsv(TwoTrials(), {"rod"});
  EXPECT_EQ(count(picks), 1 + 4);
  // Every line has as many cells as the header.
  std::istringstream lines(picks);
  std::string header, line;
  std::getline(lines, header);
  while (std::getline(lines, line)) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
  }
}

TEST(Csv, CrashedTrialsAreSortedInWithEmptyCells) {
  auto trials = TwoTrials();
  trials[0].trial = 1;
  trials[1].trial = 4;
  const std::string csv = TrialsCsv(
      trials,
      {{0, 0, BinIndex{0}, 7, "a"}, {3, 1, BinIndex{2}, 7, "b"}, {9, 1, BinIndex{8}, 7, "c"}});
  std::istringstream lines(csv);
  std::vector<std::string> firsts;
  std::string header, line;
  std::getline(lines, header);
  while (std::getline(lines, line)) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
    firsts.push_back(line.substr(0, line.find(',')));
  }
  EXPECT_EQ(firsts, (std::vector<std::string>{"0", "1", "3", "4", "9"}));
  EXPECT_NE(csv.find("3,1,2,crashed,"), std::string::npos);
}

// The recall of the summary can be counted from the table.
TEST(InstancesCsv, AgreesWithTheRecallOfTheSummary) {
  std::istringstream lines(InstancesCsv(TwoTrials(), {"rod"}));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line,
            "trial,configuration,attempt,instance,object,visible_fraction,found,missed,target");
  int instances = 0, found = 0;
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    ASSERT_EQ(cells.size(), 9u);
    if (std::stod(cells[5]) < 0.1) continue;
    ++instances;
    found += cells[6] == "1";
  }
  const RunSummary s = Summarize(TwoTrials());
  EXPECT_EQ(instances, s.recall.samples);
  EXPECT_EQ(found, s.recall.hits);
}

TEST(AttemptsCsv, HasThePoseOfTheChosenHypothesis) {
  auto trials = TwoTrials();
  trials[0].attempts[0].hypotheses[0].X_WO.translation() = Eigen::Vector3d(0.5, 0, -0.25);
  const std::string csv = AttemptsCsv(trials, {"rod"});
  EXPECT_THAT(csv, HasSubstr(",qw,qx,qy,qz,tx_m,ty_m,tz_m"));
  EXPECT_THAT(csv, HasSubstr(",1,0,0,0,0.5,0,-0.25"));
}

TEST(InstanceOutcomesCsv, ListsTheOutcomeOfEachInstance) {
  auto trials = TwoTrials();
  trials[0].outcomes = {{InstanceId{0}, ObjectId{0}, true, true, FailureReason::kNone, 0},
                        {InstanceId{1}, ObjectId{0}, false, true, FailureReason::kSlipped, 1},
                        {InstanceId{2}, ObjectId{0}, false, false, FailureReason::kNone, -1}};
  trials[0].outcomes[1].deviation = {0.25, -0.5};
  trials[0].outcomes[2].size_deviation = 0.125;
  EXPECT_EQ(InstanceOutcomesCsv(trials, {"rod"}),
            "trial,configuration,instance,object,outcome,failure,stage,attempt,friction_percent,"
            "mass_percent,size_percent\n0,0,0,rod,picked,none,done,0,0,0,0\n"
            "0,0,1,rod,failed,slipped,grasp,1,25,-50,0\n"
            "0,0,2,rod,not_asked,none,done,-1,0,0,12.5\n");
}

TEST(Csv, OutcomeCellsAreEmptyWithoutAGrasp) {
  auto trials = TwoTrials();
  GraspOutcome& outcome = trials[0].attempts[0].outcome;
  outcome.verdicts[static_cast<int>(SuccessRule::kLifted)] = true;
  outcome.contact_force_n = {0.25, 0.5, 1.75};
  outcome.lift_height_m = 0.125;
  const std::string csv = AttemptsCsv(trials, {"rod"});
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line + ",");
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  const auto cell = [&](size_t row, const std::string& column) {
    const auto at = std::find(rows[0].begin(), rows[0].end(), column);
    return at == rows[0].end() ? "no such column" : rows.at(row).at(at - rows[0].begin());
  };
  EXPECT_EQ(cell(1, "contact"), "0");
  EXPECT_EQ(cell(1, "lifted"), "1");
  EXPECT_EQ(cell(1, "force_z_n"), "1.75");
  EXPECT_EQ(cell(1, "lift_height_mm"), "125");
  EXPECT_EQ(cell(1, "place_error_mm"), "") << "it was not set down";
  EXPECT_EQ(cell(4, "lifted"), "") << "an attempt without a grasp";
  EXPECT_EQ(cell(4, "picked_instance"), "");
}

TEST(TrialsCsv, ContainsNoTimes) {
  auto trials = TwoTrials();
  const std::string before = TrialsCsv(trials) + AttemptsCsv(trials, {"rod"});
  for (auto& trial : trials) trial.seconds["drop"] = 99;
  EXPECT_EQ(TrialsCsv(trials) + AttemptsCsv(trials, {"rod"}), before);
}

}  // namespace
}  // namespace pickbed::tests
