#include "eval/report/run_statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "eval/report/views_3d.h"
#include "tests/support/stub_trials.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

ConfigurationTrials Point(std::vector<TrialResult> trials) {
  return {"point", {"rod", "flange"}, std::move(trials), {}};
}

ConfigurationReport ReportOf(const ConfigurationTrials& point) {
  return ReportOn({&point, 1}).front();
}

AttemptRecord Attempt(double visible, bool recalled, FailureReason failure) {
  AttemptRecord attempt;
  attempt.instances = {{InstanceId{3}, ObjectId{0}, visible, recalled}};
  attempt.failure = failure;
  attempt.matched_instance = InstanceId{3};
  attempt.grasp = Grasp();
  return attempt;
}

TEST(RunStatistics, CountsInstancesAndPicksByVisibilityBand) {
  TrialResult trial;
  trial.attempts = {
      Attempt(0.10, true, FailureReason::kSlipped), Attempt(0.05, true, FailureReason::kSlipped),
      Attempt(0.50, false, FailureReason::kPoseWrong), Attempt(0.69, true, FailureReason::kDropped),
      Attempt(1.0, true, FailureReason::kSlipped)};
  trial.attempts[2].grasp.reset();  // an attempt without a grasp is no pick
  const ConfigurationReport report = ReportOf(Point({trial}));
  std::vector<std::string> names;
  std::vector<int> recalled, samples, picks;
  for (const BandRates& band : report.bands) {
    names.push_back(band.band.name());
    recalled.push_back(band.recall.hits);
    samples.push_back(band.recall.samples);
    picks.push_back(band.picks.samples);
  }
  EXPECT_THAT(names, ElementsAre("10-30", "30-50", "50-70", "70-90", "90-100"));
  EXPECT_THAT(recalled, ElementsAre(1, 0, 1, 0, 1));
  EXPECT_THAT(samples, ElementsAre(1, 0, 2, 0, 1));
  EXPECT_THAT(picks, ElementsAre(1, 0, 1, 0, 1));
}

// Parameter: whether the last instance of every attempt is its target, as in occlusion trials.
class RunStatisticsTables : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(PlainAndOnTargets, RunStatisticsTables, testing::Bool());

TEST_P(RunStatisticsTables, AgreeWithTheSummary) {
  std::vector<TrialResult> trials = StubTrials(60);
  for (TrialResult& trial : trials) {
    for (AttemptRecord& pick : trial.attempts) {
      if (GetParam()) pick.target = pick.instances.back().instance;
    }
  }
  const ConfigurationReport report = ReportOf(Point(std::move(trials)));
  int recalled = 0, in_view = 0;
  for (const ObjectReport& object : report.objects) {
    recalled += object.recall.hits;
    in_view += object.recall.samples;
  }
  const RunSummary& summary = report.summary;
  const ReportRate& recall = GetParam() ? summary.target_recall : summary.recall;
  EXPECT_EQ(recalled, recall.hits);
  EXPECT_EQ(in_view, recall.samples);
  int attempts = 0, successes = 0, dropped = 0, picked = 0;
  for (const ObjectReport& object : report.objects) {
    attempts += object.picks.samples;
    successes += object.picks.hits;
    dropped += object.dropped;
    picked += object.picked;
  }
  EXPECT_EQ(attempts, report.summary.executed_grasps);
  EXPECT_EQ(successes, report.summary.successes);
  EXPECT_EQ(dropped, report.summary.instances_dropped);
  EXPECT_EQ(picked, report.summary.instances_cleared);
  for (size_t i = 0; i < report.bands.size(); ++i) {
    EXPECT_EQ(report.bands[i].recall.samples, report.summary.recall_by_visibility[i].instances);
    EXPECT_EQ(report.bands[i].recall.hits, report.summary.recall_by_visibility[i].recalled);
  }
}

TEST(RunStatistics, EveryPoseIsInOneSharedHistogramBinOrBeyond) {
  const std::vector<ConfigurationTrials> points{Point(StubTrials(20)),
                                                Point(StubTrials(20, {.ease = 0.4}))};
  const std::vector<ConfigurationReport> reports = ReportOn(points);
  for (size_t error = 0; error < reports[0].errors.size(); ++error) {
    for (const ConfigurationReport& report : reports) {
      const ErrorHistogram& histogram = report.errors[error];
      int sum = histogram.beyond;
      for (const ErrorBin& bin : histogram.bins) sum += bin.right + bin.wrong;
      EXPECT_EQ(sum, histogram.total);
      EXPECT_EQ(histogram.total, report.calibration.poses);
      EXPECT_LT(histogram.beyond, 0.06 * histogram.total);
      EXPECT_EQ(histogram.bins.back().high, reports[0].errors[error].bins.back().high);
    }
  }
  // A correct pose has an error below a tenth of the diameter.
  for (const ErrorBin& bin : reports[0].errors[0].bins) {
    EXPECT_EQ(bin.high <= 0.1 ? bin.wrong : 0, 0) << bin.low;
    EXPECT_EQ(bin.low >= 0.1 ? bin.right : 0, 0) << bin.low;
  }
}

// Poses of one bin are not independent. Counting them twice adds no information.
TEST(RunStatistics, MedianIntervalsAreOverBins) {
  const std::vector<TrialResult> trials = StubTrials(40);
  std::vector<TrialResult> twice = trials;
  for (TrialResult& trial : twice) {
    for (AttemptRecord& attempt : trial.attempts) {
      const std::vector<HypothesisRecord> once = attempt.hypotheses;
      attempt.hypotheses.insert(attempt.hypotheses.end(), once.begin(), once.end());
    }
  }
  const ConfigurationReport report = ReportOf(Point(trials)), of_twice = ReportOf(Point(twice));
  const ErrorMedian a = report.errors[0].median, b = of_twice.errors[0].median;
  EXPECT_LT(a.ci95.low, a.value);
  EXPECT_GT(a.ci95.high, a.value);
  EXPECT_NEAR(b.ci95.high - b.ci95.low, a.ci95.high - a.ci95.low, 2e-3);
  for (const ObjectReport& object : report.objects) {
    const ErrorMedian& median = object.median_mssd_diameters;
    EXPECT_LT(median.ci95.low, median.value) << object.name;
    EXPECT_GT(median.ci95.high - median.ci95.low, a.ci95.high - a.ci95.low)
        << "half of the poses give a wider interval";
  }
}

TEST(RunStatistics, RatesUseTheBandsOfTheRun) {
  OcclusionSpec spec;
  spec.bands = {{0.2, 0.4}, {0.4, 0.625}};
  EXPECT_EQ(ReportedBands(spec).size(), 5u) << "a run without occlusion uses the default bands";
  spec.enabled = true;
  TrialResult trial;
  trial.attempts = {Attempt(0.35, true, FailureReason::kSlipped),
                    Attempt(0.45, true, FailureReason::kSlipped)};
  ConfigurationTrials point = Point({trial});
  point.bands = ReportedBands(spec);
  const ConfigurationReport report = ReportOf(point);
  ASSERT_EQ(report.bands.size(), 2u);
  EXPECT_EQ(report.bands[1].band.name(), "40-62.5");
  EXPECT_EQ(report.bands[0].recall.samples, 1);
  EXPECT_EQ(report.bands[1].recall.samples, 1);
  EXPECT_EQ(report.summary.recall_by_visibility[1].instances, 1);
}

TEST(RunStatistics, ErrorsByBandAreThoseOfTheInstancesInTheBand) {
  TrialResult trial;
  AttemptRecord attempt;
  attempt.failure = FailureReason::kNoGrasp;
  for (int i = 0; i < 2; ++i) {
    attempt.instances.push_back({InstanceId{i}, ObjectId{0}, i == 0 ? 0.2 : 0.95, true});
    HypothesisRecord pose;
    pose.instance = InstanceId{i};
    pose.metrics.Set(kMssdDiameters, i == 0 ? 0.08 : 0.02);
    attempt.hypotheses.push_back(pose);
  }
  trial.attempts = {attempt};
  const ConfigurationReport report = ReportOf(Point({trial}));
  const std::vector<BandError>& by_band = report.errors[0].by_band;
  ASSERT_EQ(by_band.size(), report.bands.size());
  EXPECT_EQ(by_band.front().poses, 1);
  EXPECT_EQ(by_band.back().poses, 1);
  EXPECT_EQ(by_band[1].poses, 0);
  EXPECT_NEAR(by_band.front().median.value, 0.08, 1e-12);
  EXPECT_NEAR(by_band.back().median.value, 0.02, 1e-12);
}

// Bins with fewer attempts do not count in the later ranges.
TEST(RunStatistics, AttemptsAreCountedInEqualRanges) {
  TrialResult full, brief;
  for (int i = 0; i < 50; ++i) {
    AttemptRecord attempt;
    attempt.grasp = Grasp();
    attempt.failure = i < 30 ? FailureReason::kNone : FailureReason::kSlipped;
    full.attempts.push_back(attempt);
    if (i < 3) brief.attempts.push_back(attempt);
  }
  full.instances_cleared = 30;
  brief.instances_cleared = 3;
  const std::vector<AttemptRange> ranges = ReportOf(Point({full, brief})).attempt_ranges;
  ASSERT_EQ(ranges.size(), 17u) << "three attempts each, at most 20 ranges";
  EXPECT_EQ(ranges[0].picked.samples, 6);
  EXPECT_EQ(ranges[1].picked.samples, 3);
  EXPECT_EQ(ranges[0].picked.hits, 6);
  EXPECT_EQ(ranges[10].picked.hits, 0);
  EXPECT_EQ(ranges.back().last, 49);
}

TEST(RunStatistics, CalibrationDetectsOverconfidence) {
  // The confidence of a stub pose is its probability of being correct.
  EXPECT_LT(ReportOf(Point(StubTrials(300))).calibration.expected_error, 0.03);
  std::vector<TrialResult> overconfident = StubTrials(100);
  int i = 0;
  for (TrialResult& trial : overconfident) {
    for (AttemptRecord& attempt : trial.attempts) {
      for (HypothesisRecord& score : attempt.hypotheses) {
        score.score = 0.9;
        score.correct = ++i % 2 == 0;
      }
    }
  }
  const auto calibration = ReportOf(Point(overconfident)).calibration;
  ASSERT_EQ(calibration.bins.size(), 1u);
  EXPECT_NEAR(calibration.bins[0].mean_confidence, 0.9, 1e-9);
  EXPECT_NEAR(calibration.expected_error, 0.4, 0.001);
}

TEST(RunStatistics, StagesAreSortedByTimeEachBeforeItsSubstages) {
  TrialResult trial;
  trial.seconds = {
      {"drop", 3}, {"estimate", 4}, {"estimate/a", 1}, {"estimate/b", 2}, {"capture", 0.5}};
  TrialResult without = trial;
  without.seconds.erase("capture");
  std::vector<std::string> stages;
  const ConfigurationReport report = ReportOf(Point({trial, without}));
  for (const StageTime& time : report.seconds) stages.push_back(time.stage);
  EXPECT_THAT(stages, ElementsAre("estimate", "estimate/b", "estimate/a", "drop", "capture"));
  EXPECT_DOUBLE_EQ(report.seconds.back().mean_s, 0.25);
}

std::vector<FailedPick> FailedPicksFor(std::vector<FailureReason> failures) {
  std::vector<FailedPick> picks;
  for (const FailureReason failure : failures) {
    picks.emplace_back().failure = failure;
    picks.back().trial = static_cast<int>(picks.size()) - 1;
  }
  return picks;
}

TEST(RunStatistics, FewFailedPicksStillShowEveryReason) {
  const FailureReason slip = FailureReason::kSlipped, pose = FailureReason::kPoseWrong,
                      two = FailureReason::kDoublePick;
  const auto trials = [](const std::vector<FailedPick>& picks) {
    std::vector<int> numbers;
    for (const FailedPick& pick : picks) numbers.push_back(pick.trial);
    return numbers;
  };
  const std::vector<FailedPick> failed =
      FailedPicksFor({slip, slip, slip, slip, pose, slip, two, pose});
  EXPECT_THAT(trials(SpreadOverReasons(failed, 3)), ElementsAre(0, 4, 6));
  EXPECT_THAT(trials(SpreadOverReasons(failed, 5)), ElementsAre(0, 1, 4, 6, 7));
  EXPECT_EQ(SpreadOverReasons(failed, 100).size(), failed.size());
}

TEST(RunStatistics, FailedPicksAgreeWithTheBudget) {
  const ConfigurationTrials point = Point(StubTrials(40));
  const FailureBudget budget = BudgetOfAttempts(point.trials);
  const std::vector<FailedPick> failed = FailedPicksOf({&point, 1});
  EXPECT_EQ(static_cast<int>(failed.size()), budget.total - budget.picked);
  for (const FailedPick& pick : failed) {
    const AttemptRecord& attempt = point.trials[pick.trial].attempts[pick.attempt];
    EXPECT_EQ(attempt.failure, pick.failure);
    EXPECT_EQ(attempt.grasp.has_value(), !pick.object.empty());
  }
}

// The visible fraction of the target is also known for an attempt without a grasp.
TEST(RunStatistics, FailedPicksHaveTheVisibleFractionOfTheTarget) {
  TrialResult trial;
  trial.attempts = {Attempt(0.3, true, FailureReason::kNoGrasp),
                    Attempt(0.4, true, FailureReason::kSlipped)};
  for (AttemptRecord& attempt : trial.attempts) {
    attempt.target = attempt.instances[0].instance;
    attempt.matched_instance = InstanceId{-1};
  }
  trial.attempts[0].grasp.reset();
  ConfigurationTrials point = Point({trial});
  std::vector<FailedPick> failed = FailedPicksOf({&point, 1});
  EXPECT_EQ(failed.at(0).visible_fraction, 0.3);
  EXPECT_EQ(failed.at(1).visible_fraction, 0.4);
  for (AttemptRecord& attempt : point.trials[0].attempts) attempt.target = InstanceId{-1};
  failed = FailedPicksOf({&point, 1});
  EXPECT_LT(failed.at(0).visible_fraction, 0) << "the attempt has no target";
}

TEST(RunStatistics, ViewsShowOneOfEachReasonAndOneSuccess) {
  std::vector<TrialResult> trials(6);
  const FailureReason failures[] = {FailureReason::kSlipped, FailureReason::kSlipped,
                                    FailureReason::kNone,    FailureReason::kPoseWrong,
                                    FailureReason::kNone,    FailureReason::kNoGrasp};
  for (int i = 0; i < 6; ++i) trials[i].attempts = {Attempt(0.9, true, failures[i])};
  trials[5].attempts[0].grasp.reset();  // no gripper to show
  trials[5].attempts.push_back(Attempt(0.9, true, FailureReason::kDropped));
  const ConfigurationTrials point = Point(trials);
  const auto places = [&](int maximum) {
    std::vector<size_t> numbers;
    for (const ViewChoice& choice : ChooseViews({&point, 1}, maximum)) {
      numbers.push_back(10 * choice.trial + choice.attempt);
    }
    return numbers;
  };
  EXPECT_THAT(places(4), ElementsAre(0, 30, 51, 20));
  EXPECT_THAT(places(9), ElementsAre(0, 30, 51, 10, 20));
  EXPECT_THAT(places(1), ElementsAre(20));
  EXPECT_TRUE(places(0).empty());
  const auto is_early = [](const ViewChoice& choice) { return choice.trial < 2; };
  EXPECT_THAT(ChooseViews({&point, 1}, 9, is_early), SizeIs(2));
}

TEST(RunStatistics, OptionsOutOfRangeAreRefused) {
  ReportOptions options;
  options.error_bins = 0;
  EXPECT_THROW(ReportOn({}, options), std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
