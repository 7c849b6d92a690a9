#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "eval/calibrate/fit.h"
#include "eval/calibrate/report.h"
#include "eval/calibrate/samples.h"
#include "eval/store/results_store.h"
#include "eval/store/sqlite.h"
#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/stub_trials.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// A raw score of another scale with the same order.
double RawScore(double probability) { return 40 * std::log(probability) + 3.5; }
double TrueProbability(double raw) { return std::exp((raw - 3.5) / 40); }

// The stub's scores are the probabilities. `raw`: they get another scale.
std::vector<TrialResult> ScoredTrials(int bins, bool raw) {
  std::vector<TrialResult> trials = StubTrials(bins);
  for (TrialResult& trial : trials) {
    for (AttemptRecord& attempt : trial.attempts) {
      for (HypothesisRecord& pose : attempt.hypotheses) {
        pose.raw_score = raw ? RawScore(pose.score) : pose.score;
      }
    }
  }
  return trials;
}

TEST(Calibrate, TheTrueProbabilityOfARawScoreIsRecovered) {
  const CalibrationFit fit = FitCalibration(SamplesOf(ScoredTrials(300, true)));
  EXPECT_FALSE(fit.pose_right.quality_before) << "raw scores are no probabilities";
  for (const double p : {0.3, 0.5, 0.7, 0.9}) {
    EXPECT_NEAR(fit.pose_right.curve.At(RawScore(p)), p, 0.06) << p;
    EXPECT_NEAR(TrueProbability(RawScore(p)), p, 1e-12);
  }
  EXPECT_LT(fit.pose_right.quality_after.calibration_error.value, 0.03);
  ASSERT_TRUE(fit.pick_succeeds);
  // 92 % of the picks at right poses succeed.
  EXPECT_NEAR(fit.pick_succeeds->curve.At(RawScore(0.9)), 0.92 * 0.9, 0.08);
}

// A monotone change of the scores changes no fitted probability of a sample.
TEST(Calibrate, TheFitDependsOnlyOnTheOrderOfTheScores) {
  const CalibrationFit plain = FitCalibration(SamplesOf(ScoredTrials(40, false)));
  const CalibrationFit raw = FitCalibration(SamplesOf(ScoredTrials(40, true)));
  ASSERT_EQ(plain.pose_right.curve.knots.size(), raw.pose_right.curve.knots.size());
  for (size_t i = 0; i < plain.pose_right.curve.knots.size(); ++i) {
    EXPECT_EQ(plain.pose_right.curve.knots[i].probability,
              raw.pose_right.curve.knots[i].probability);
  }
}

TEST(Calibrate, OverconfidentScoresGetBetterAndGoodOnesDoNotGetWorse) {
  std::vector<TrialResult> overconfident = ScoredTrials(120, false);
  for (TrialResult& trial : overconfident) {
    for (AttemptRecord& attempt : trial.attempts) {
      for (HypothesisRecord& pose : attempt.hypotheses) pose.raw_score = std::sqrt(pose.score);
    }
  }
  const FittedCurve better = FitAndValidate(SamplesOf(overconfident).poses);
  ASSERT_TRUE(better.change);
  EXPECT_GT(better.quality_before->calibration_error.value, 0.08);
  EXPECT_LT(better.quality_after.calibration_error.value, 0.04);
  EXPECT_LT(better.change->calibration_error.ci95.high, 0);
  EXPECT_LT(better.change->brier.ci95.high, 0);
  const FittedCurve good = FitAndValidate(SamplesOf(ScoredTrials(120, false)).poses);
  EXPECT_LT(good.change->brier.value, 0.01);
}

// Scores without information. A fit that saw its own test data would look better than chance.
TEST(Calibrate, CrossValidationDoesNotRewardNoise) {
  Rng rng(3);
  OutcomeClusters samples(40);
  for (auto& bin : samples) {
    for (int i = 0; i < 10; ++i) bin.push_back({rng.Uniform(), rng.Uniform() < 0.5});
  }
  EXPECT_GE(FitAndValidate(samples).quality_after.brier.value, 0.249);
}

TEST(Calibrate, NoSampleMakesAScoreCertain) {
  const ScoreCurve curve = FitCurve({{{1, false}, {2, false}, {3, true}, {4, true}, {5, true}}});
  EXPECT_GT(curve.At(0), 0);
  EXPECT_LT(curve.At(9), 1);
  EXPECT_LT(curve.At(1), curve.At(5));
  for (size_t i = 1; i < curve.knots.size(); ++i) {
    EXPECT_LT(curve.knots[i - 1].score, curve.knots[i].score);
    EXPECT_LE(curve.knots[i - 1].probability, curve.knots[i].probability);
  }
}

TEST(Calibrate, TooFewSamplesAreNamed) {
  const auto error_of = [](std::vector<TrialResult> trials, int correct) {
    for (TrialResult& trial : trials) {
      for (AttemptRecord& attempt : trial.attempts) {
        for (HypothesisRecord& pose : attempt.hypotheses) {
          if (correct >= 0) pose.correct = correct == 1;
        }
      }
    }
    return ErrorOf([&] { FitCalibration(SamplesOf(trials)); });
  };
  EXPECT_THAT(error_of(StubTrials(4), -1), HasSubstr("poses in 4 bins, but 5 are needed"));
  EXPECT_THAT(error_of(StubTrials(20), 1), HasSubstr("all are right; take a harder scenario"));
  EXPECT_THAT(error_of(StubTrials(20), 0), HasSubstr("none is right; take an easier scenario"));
  std::vector<TrialResult> short_ones = StubTrials(12, {.instances = 2, .attempts = 1});
  EXPECT_THAT(error_of(short_ones, -1), HasSubstr("30 are needed; run more trials"));
}

TEST(Calibrate, WithoutFailedPicksOnlyThePosesAreCalibrated) {
  std::vector<TrialResult> trials = ScoredTrials(30, false);
  for (TrialResult& trial : trials) {
    for (AttemptRecord& attempt : trial.attempts) attempt.failure = FailureReason::kNone;
  }
  const CalibrationFit fit = FitCalibration(SamplesOf(trials));
  EXPECT_FALSE(fit.pick_succeeds);
  EXPECT_TRUE(CalibrationOf(fit).pick_succeeds.empty());
  EXPECT_THAT(CalibrationText(fit), HasSubstr("no curve for P(pick succeeds): the run has"));
  EXPECT_THAT(CalibrationReport(fit).body(), HasSubstr("all are successful"));
}

// Picks that share an image share its poses.
TEST(Calibrate, PosesOfASharedImageCountOnce) {
  std::vector<TrialResult> trials = ScoredTrials(1, false);
  AttemptRecord again = trials[0].attempts.back();
  const size_t before = SamplesOf(trials).poses.at(0).size();
  again.pick_of_image = 1;
  trials[0].attempts.push_back(again);
  EXPECT_EQ(SamplesOf(trials).poses.at(0).size(), before);
}

class CalibrateRun : public testing::Test {
 protected:
  std::filesystem::path Store(const std::string& settings, const std::string& identity_end = "",
                              bool pose_free = false) {
    const std::filesystem::path folder = folder_.path() / std::to_string(++count_);
    StoredConfiguration configuration;
    configuration.trials = 30;
    configuration.settings = "seed: 1\nobjects: [{name: rod}, {name: gear}]\n" + settings;
    configuration.identity = configuration.settings + identity_end;
    ResultsStore store(folder, StoreHead{configuration.identity, {configuration}});
    for (TrialResult& trial : ScoredTrials(30, true)) {
      for (AttemptRecord& attempt : trial.attempts) {
        attempt.pose_free = pose_free;
        if (pose_free) attempt.hypotheses.clear();
        if (pose_free) attempt.chosen = -1;
      }
      store.Write(trial);
    }
    return folder;
  }
  std::string ErrorOfRun(const std::filesystem::path& folder) {
    const std::string error = ErrorOf([&] { FitCalibration(ReadSamples(folder)); });
    EXPECT_THAT(error, HasSubstr(folder.string()));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    return error;
  }
  TemporaryFolder folder_;
  int count_ = 0;
};

TEST_F(CalibrateRun, RawScoresAreReadFromTheStore) {
  const auto folder =
      Store("estimator: {name: process, command: [python3, a.py], scores: raw, min_score: 0.25}\n");
  const CalibrationFit fit = FitCalibration(ReadSamples(folder));
  const CalibrationFit direct = FitCalibration(SamplesOf(ScoredTrials(30, true)));
  const ScoreCalibration calibration = CalibrationOf(fit);
  EXPECT_EQ(calibration.estimator, "process");
  EXPECT_EQ(calibration.scores, "raw");
  EXPECT_EQ(calibration.min_score, 0.25);
  EXPECT_EQ(calibration.bins, 30);
  EXPECT_GT(calibration.picked, 0);
  ASSERT_EQ(calibration.pose_right.knots.size(), direct.pose_right.curve.knots.size());
  for (size_t i = 0; i < calibration.pose_right.knots.size(); ++i) {
    EXPECT_EQ(calibration.pose_right.knots[i].score, direct.pose_right.curve.knots[i].score);
  }
}

TEST_F(CalibrateRun, RunsWithoutScoresOfAnEstimatorAreNamed) {
  EXPECT_THAT(ErrorOfRun(Store("estimator: {name: oracle}\n")), HasSubstr("is the oracle"));
  EXPECT_THAT(ErrorOfRun(Store("planner: {name: cloud_antipodal}\n", "", true)),
              HasSubstr("planner cloud_antipodal works without poses"));
  EXPECT_THAT(ErrorOfRun(Store("",
                               "# truth for: sense false, detection false, pose true, "
                               "refinement false, grasp false\n")),
              HasSubstr("were replaced by ground truth"));
  EXPECT_THAT(ErrorOfRun(Store("estimator: {calibration: old.yaml}\n")),
              HasSubstr("calibrated already by old.yaml"));
  EXPECT_THAT(ErrorOfRun(folder_.path() / "none"), HasSubstr("has no results.sqlite"));
}

TEST_F(CalibrateRun, DamagedTrialsAreRefusedWithTheirTable) {
  struct {
    std::string edit, message;
  } const cases[] = {
      {"UPDATE trials SET instances_cleared = instances_cleared + 1 WHERE trial = 3",
       "table 'trials', trial 3: "},
      {"UPDATE attempts SET band = 77 WHERE trial = 3 AND attempt = 1",
       "table 'attempts', trial 3: the settings have no band 77"},
      {"UPDATE hypotheses SET object = 2 WHERE trial = 3",
       "table 'hypotheses', trial 3: the settings have no object 2"},
      {"UPDATE instance_outcomes SET object = 9 WHERE trial = 3",
       "table 'instance_outcomes', trial 3: the settings have no object 9"},
  };
  for (const auto& test : cases) {
    const std::filesystem::path folder = Store("");
    EXPECT_EQ(ErrorOf([&] { ReadSamples(folder); }), "no error");
    Database(folder / kStoreFile, Database::Mode::kExisting).Execute(test.edit);
    const std::string error = ErrorOfRun(folder);
    EXPECT_THAT(error, HasSubstr((folder / kStoreFile).string() + ": " + test.message));
    EXPECT_THAT(error, HasSubstr("restore the file from a copy"));
  }
}

TEST_F(CalibrateRun, ASweepNeedsTheNumberOfAConfiguration) {
  StoreHead head{"a\nb", {}};
  for (const int number : {0, 1}) {
    StoredConfiguration& configuration = head.configurations.emplace_back();
    configuration.number = number;
    configuration.first_trial = 30 * number;
    configuration.trials = 30;
    configuration.settings = "objects: [{name: rod}, {name: gear}]\n";
    configuration.identity = number == 0 ? "a" : "b";
  }
  {
    ResultsStore store(folder_.path(), head);
    for (TrialResult& trial : ScoredTrials(60, false)) {
      trial.configuration = trial.trial / 30;
      store.Write(trial);
    }
  }
  EXPECT_THAT(ErrorOfRun(folder_.path()), HasSubstr("has 2 configurations"));
  EXPECT_THAT(ErrorOf([&] { ReadSamples(folder_.path(), 5); }), HasSubstr("no configuration 5"));
  EXPECT_EQ(ReadSamples(folder_.path(), 1).poses.size(), 30u);
}

}  // namespace
}  // namespace pickbed::tests
