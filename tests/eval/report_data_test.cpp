#include "eval/report_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "eval/report_views.h"
#include "tests/support/stub_trials.h"

namespace pickbed {
namespace {

using testing::ElementsAre;

PointTrials Point(std::vector<TrialResult> trials) {
  return {"point", {"rod", "flange"}, std::move(trials), {}};
}

PointReport ReportOf(const PointTrials& point) { return ReportOn({&point, 1}).front(); }

PickRecord Look(double visible, bool recalled, Loss loss) {
  PickRecord look;
  look.instances = {{3, 0, visible, recalled}};
  look.loss = loss;
  look.aimed = 3;
  look.grasp = Grasp();
  return look;
}

TEST(ReportData, CountsPartsAndPicksInTheBandOfTheirVisibleFraction) {
  TrialResult trial;
  trial.picks = {Look(0.10, true, Loss::kSlipped), Look(0.05, true, Loss::kSlipped),
                 Look(0.50, false, Loss::kPoseWrong), Look(0.69, true, Loss::kDropped),
                 Look(1.0, true, Loss::kSlipped)};
  trial.picks[2].grasp.reset();  // a look without a grasp is no pick
  const PointReport report = ReportOf(Point({trial}));
  std::vector<std::string> names;
  std::vector<int> recalled, tries, picks;
  for (const BandRates& band : report.bands) {
    names.push_back(band.band.name());
    recalled.push_back(band.recall.hits);
    tries.push_back(band.recall.tries);
    picks.push_back(band.picks.tries);
  }
  EXPECT_THAT(names, ElementsAre("10-30", "30-50", "50-70", "70-90", "90-100"));
  EXPECT_THAT(recalled, ElementsAre(1, 0, 1, 0, 1));
  EXPECT_THAT(tries, ElementsAre(1, 0, 2, 0, 1));
  EXPECT_THAT(picks, ElementsAre(1, 0, 1, 0, 1));
}

// `on_targets`: every look is about its last part, as in trials on occlusion.
class ReportTables : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(PlainAndOnTargets, ReportTables, testing::Bool());

TEST_P(ReportTables, AgreeWithTheSummary) {
  std::vector<TrialResult> trials = StubTrials(60);
  for (TrialResult& trial : trials) {
    for (PickRecord& pick : trial.picks) {
      if (GetParam()) pick.target = pick.instances.back().instance;
    }
  }
  const PointReport report = ReportOf(Point(std::move(trials)));
  int recalled = 0, in_view = 0;
  for (const ObjectReport& object : report.objects) {
    recalled += object.recall.hits;
    in_view += object.recall.tries;
  }
  EXPECT_EQ(recalled, report.recall.hits);
  EXPECT_EQ(in_view, report.recall.tries);
  int attempts = 0, successes = 0, dropped = 0, picked = 0;
  for (const ObjectReport& object : report.objects) {
    attempts += object.picks.tries;
    successes += object.picks.hits;
    dropped += object.dropped;
    picked += object.picked;
  }
  EXPECT_EQ(attempts, report.summary.attempts);
  EXPECT_EQ(successes, report.summary.successes);
  EXPECT_EQ(dropped, report.summary.parts_dropped);
  EXPECT_EQ(picked, report.summary.parts_cleared);
  for (size_t i = 0; i < report.bands.size(); ++i) {
    EXPECT_EQ(report.bands[i].recall.tries, report.summary.recall_by_visibility[i].instances);
    EXPECT_EQ(report.bands[i].recall.hits, report.summary.recall_by_visibility[i].recalled);
  }
}

TEST(ReportData, EveryPoseIsInOneBinOrBeyondAndPointsShareTheBins) {
  const std::vector<PointTrials> points{Point(StubTrials(20)),
                                        Point(StubTrials(20, {.ease = 0.4}))};
  const std::vector<PointReport> reports = ReportOn(points);
  for (size_t error = 0; error < kPoseErrors; ++error) {
    for (const PointReport& report : reports) {
      const ErrorHistogram& histogram = report.errors[error];
      int sum = histogram.beyond;
      for (const ErrorBin& bin : histogram.bins) sum += bin.right + bin.wrong;
      EXPECT_EQ(sum, histogram.total);
      EXPECT_EQ(histogram.total, report.calibration.poses);
      EXPECT_LT(histogram.beyond, 0.06 * histogram.total);
      EXPECT_EQ(histogram.bins.back().high, reports[0].errors[error].bins.back().high);
    }
  }
  // Right is what lies below a tenth of the diameter.
  for (const ErrorBin& bin : reports[0].errors[0].bins) {
    EXPECT_EQ(bin.high <= 0.1 ? bin.wrong : 0, 0) << bin.low;
    EXPECT_EQ(bin.low >= 0.1 ? bin.right : 0, 0) << bin.low;
  }
}

// Poses of one scene are not independent: told twice they tell no more.
TEST(ReportData, MediansHaveIntervalsOfScenes) {
  const std::vector<TrialResult> trials = StubTrials(40);
  std::vector<TrialResult> twice = trials;
  for (TrialResult& trial : twice) {
    for (PickRecord& look : trial.picks) {
      const std::vector<HypothesisScore> once = look.hypotheses;
      look.hypotheses.insert(look.hypotheses.end(), once.begin(), once.end());
    }
  }
  const PointReport report = ReportOf(Point(trials)), of_twice = ReportOf(Point(twice));
  const ErrorMedian a = report.errors[0].median, b = of_twice.errors[0].median;
  EXPECT_LT(a.ci95.low, a.value);
  EXPECT_GT(a.ci95.high, a.value);
  EXPECT_NEAR(b.ci95.high - b.ci95.low, a.ci95.high - a.ci95.low, 2e-3);
  for (const ObjectReport& object : report.objects) {
    const ErrorMedian& median = object.median_mssd_diameters;
    EXPECT_LT(median.ci95.low, median.value) << object.name;
    EXPECT_GT(median.ci95.high - median.ci95.low, a.ci95.high - a.ci95.low)
        << "half of the poses tell less";
  }
}

TEST(ReportData, RatesAreToldByTheBandsOfTheRun) {
  OcclusionSpec spec;
  spec.bands = {{0.2, 0.4}, {0.4, 0.625}};
  EXPECT_EQ(ReportedBands(spec).size(), 5u) << "a plain run is about no bands";
  spec.enabled = true;
  TrialResult trial;
  trial.picks = {Look(0.35, true, Loss::kSlipped), Look(0.45, true, Loss::kSlipped)};
  PointTrials point = Point({trial});
  point.bands = ReportedBands(spec);
  const PointReport report = ReportOf(point);
  ASSERT_EQ(report.bands.size(), 2u);
  EXPECT_EQ(report.bands[1].band.name(), "40-62.5");
  EXPECT_EQ(report.bands[0].recall.tries, 1);
  EXPECT_EQ(report.bands[1].recall.tries, 1);
  EXPECT_EQ(report.summary.recall_by_visibility[1].instances, 1);
}

TEST(ReportData, CalibrationTellsSureFromTooSure) {
  // The stub's confidence is the probability by which it is right.
  EXPECT_LT(ReportOf(Point(StubTrials(300))).calibration.expected_error, 0.03);
  std::vector<TrialResult> too_sure = StubTrials(100);
  int i = 0;
  for (TrialResult& trial : too_sure) {
    for (PickRecord& look : trial.picks) {
      for (HypothesisScore& score : look.hypotheses) {
        score.score = 0.9;
        score.correct = ++i % 2 == 0;
      }
    }
  }
  const Calibration calibration = ReportOf(Point(too_sure)).calibration;
  ASSERT_EQ(calibration.bins.size(), 1u);
  EXPECT_NEAR(calibration.bins[0].mean_confidence, 0.9, 1e-9);
  EXPECT_NEAR(calibration.expected_error, 0.4, 0.001);
}

TEST(ReportData, StagesStandLongestFirstEachBeforeItsParts) {
  TrialResult trial;
  trial.seconds = {
      {"drop", 3}, {"estimate", 4}, {"estimate/a", 1}, {"estimate/b", 2}, {"see", 0.5}};
  TrialResult without = trial;
  without.seconds.erase("see");
  std::vector<std::string> stages;
  const PointReport report = ReportOf(Point({trial, without}));
  for (const StageTime& time : report.seconds) stages.push_back(time.stage);
  EXPECT_THAT(stages, ElementsAre("estimate", "estimate/b", "estimate/a", "drop", "see"));
  EXPECT_DOUBLE_EQ(report.seconds.back().mean_s, 0.25);
}

std::vector<LostPick> Lost(std::vector<Loss> losses) {
  std::vector<LostPick> picks;
  for (const Loss loss : losses) {
    picks.emplace_back().loss = loss;
    picks.back().trial = static_cast<int>(picks.size()) - 1;
  }
  return picks;
}

TEST(ReportData, AFewLostPicksStillShowEveryReason) {
  const Loss slip = Loss::kSlipped, pose = Loss::kPoseWrong, two = Loss::kTookTwo;
  const auto trials = [](const std::vector<LostPick>& picks) {
    std::vector<int> numbers;
    for (const LostPick& pick : picks) numbers.push_back(pick.trial);
    return numbers;
  };
  const std::vector<LostPick> lost = Lost({slip, slip, slip, slip, pose, slip, two, pose});
  EXPECT_THAT(trials(SpreadOverReasons(lost, 3)), ElementsAre(0, 4, 6));
  EXPECT_THAT(trials(SpreadOverReasons(lost, 5)), ElementsAre(0, 1, 4, 6, 7));
  EXPECT_EQ(SpreadOverReasons(lost, 100).size(), lost.size());
}

TEST(ReportData, LostPicksAreThoseOfTheBudget) {
  const PointTrials point = Point(StubTrials(40));
  const LossBudget budget = BudgetOfAttempts(point.trials);
  const std::vector<LostPick> lost = LostPicksOf({&point, 1});
  EXPECT_EQ(static_cast<int>(lost.size()), budget.total - budget.picked);
  for (const LostPick& pick : lost) {
    const PickRecord& look = point.trials[pick.trial].picks[pick.pick];
    EXPECT_EQ(look.loss, pick.loss);
    EXPECT_EQ(look.grasp.has_value(), !pick.object.empty());
  }
}

// How much of its target was in view is known of a look that found no grasp, too.
TEST(ReportData, LostPicksTellHowMuchOfTheTargetWasInView) {
  TrialResult trial;
  trial.picks = {Look(0.3, true, Loss::kNoGrasp), Look(0.4, true, Loss::kSlipped)};
  for (PickRecord& look : trial.picks) {
    look.target = look.instances[0].instance;
    look.aimed = -1;
  }
  trial.picks[0].grasp.reset();
  PointTrials point = Point({trial});
  std::vector<LostPick> lost = LostPicksOf({&point, 1});
  EXPECT_EQ(lost.at(0).visible_fraction, 0.3);
  EXPECT_EQ(lost.at(1).visible_fraction, 0.4);
  for (PickRecord& look : point.trials[0].picks) look.target = -1;
  lost = LostPicksOf({&point, 1});
  EXPECT_LT(lost.at(0).visible_fraction, 0) << "it aimed at nothing";
}

TEST(ReportData, ViewsShowOneOfEachReasonAndOneSuccess) {
  std::vector<TrialResult> trials(6);
  const Loss losses[] = {Loss::kSlipped,   Loss::kSlipped, Loss::kNone,
                         Loss::kPoseWrong, Loss::kNone,    Loss::kNoGrasp};
  for (int i = 0; i < 6; ++i) trials[i].picks = {Look(0.9, true, losses[i])};
  trials[5].picks[0].grasp.reset();  // no hand to be shown
  trials[5].picks.push_back(Look(0.9, true, Loss::kDropped));
  const PointTrials point = Point(trials);
  const auto places = [&](int most) {
    std::vector<size_t> numbers;
    for (const ViewChoice& choice : ChooseViews({&point, 1}, most)) {
      numbers.push_back(10 * choice.trial + choice.look);
    }
    return numbers;
  };
  EXPECT_THAT(places(4), ElementsAre(0, 30, 51, 20));
  EXPECT_THAT(places(9), ElementsAre(0, 30, 51, 10, 20));
  EXPECT_THAT(places(1), ElementsAre(20));
  EXPECT_TRUE(places(0).empty());
}

TEST(ReportData, OptionsOutOfRangeAreRefused) {
  ReportOptions options;
  options.error_bins = 0;
  EXPECT_THROW(ReportOn({}, options), std::logic_error);
}

}  // namespace
}  // namespace pickbed
