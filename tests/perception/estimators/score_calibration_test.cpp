#include "perception/estimators/score_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "perception/estimators/calibrated.h"
#include "perception/estimators/finite_poses.h"
#include "perception/estimators/pose_estimator.h"
#include "scenes/base/files.h"
#include "scenes/base/finite_counts.h"
#include "tests/support/error_of.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

ScoreCalibration Planted() {
  ScoreCalibration calibration;
  calibration.run = "results/mine";
  calibration.estimator = "process";
  calibration.mode = "fast";
  calibration.scores = "raw";
  calibration.command = {"python3", "there/mine.py"};
  calibration.bins = 12;
  calibration.pose_right.knots = {{-120.5, 0.02}, {-3, 0.02}, {1.0 / 3, 0.75}, {3.5, 0.98}};
  return calibration;
}

EstimatorSpec SpecOf(const std::filesystem::path& file) {
  EstimatorSpec spec;
  spec.name = "process";
  spec.command = {"python3", "here/mine.py"};
  spec.calibration = file.string();
  return spec;
}

TEST(ScoreCurve, IsLinearBetweenItsKnotsAndConstantOutside) {
  const ScoreCurve curve{{{-2, 0.1}, {0, 0.5}, {1, 0.5}, {3, 0.9}}};
  EXPECT_EQ(curve.At(-1e300), 0.1);
  EXPECT_EQ(curve.At(-2), 0.1);
  EXPECT_DOUBLE_EQ(curve.At(-1), 0.3);
  EXPECT_EQ(curve.At(0.5), 0.5);
  EXPECT_DOUBLE_EQ(curve.At(2), 0.7);
  EXPECT_EQ(curve.At(3), 0.9);
  EXPECT_EQ(curve.At(1e300), 0.9);
}

TEST(ScoreCalibration, AFileKeepsEveryNumber) {
  const TemporaryFolder folder;
  const auto file = folder.Write("calibration.yaml", WriteCalibration(Planted()));
  const ScoreCalibration read = CalibrationFor(SpecOf(file));
  EXPECT_EQ(WriteCalibration(read), WriteCalibration(Planted()));
  EXPECT_EQ(read.pose_right.At(1.0 / 3), 0.75);
}

// Each damage is one line that says what to do.
TEST(ScoreCalibration, DamagedFilesAreNamed) {
  const TemporaryFolder folder;
  const std::string whole = WriteCalibration(Planted());
  const auto error_of = [&](const std::string& text) {
    const auto file = folder.Write("damaged.yaml", text);
    const std::string error = ErrorOf([&] { ReadCalibration(file); });
    EXPECT_THAT(error, HasSubstr("damaged.yaml"));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    return error;
  };
  for (const double share : {0.5, 0.7, 0.9, 0.97}) {
    EXPECT_THAT(error_of(whole.substr(0, static_cast<size_t>(share * whole.size()))),
                HasSubstr("is truncated"))
        << share;
  }
  const auto with = [&](const std::string& was, const std::string& is) {
    std::string text = whole;
    const size_t at = text.find(was);
    EXPECT_NE(at, std::string::npos) << was;
    return text.replace(at, was.size(), is);
  };
  EXPECT_THAT(error_of(with("0.75", "0.015")),
              HasSubstr("the probability falls from 0.02 to 0.015"));
  EXPECT_THAT(error_of(with("score: -3", "score: -120.5")), HasSubstr("scores must rise"));
  EXPECT_THAT(error_of(with("version: 1", "version: 9")), HasSubstr("has version 9"));
  EXPECT_THAT(error_of(with("0.98", "1.98")), HasSubstr("probability = 1.98"));
  EXPECT_THAT(error_of(with("right: 0", "right: 3")), HasSubstr("has 3 right poses of 0"));
  EXPECT_THAT(error_of(with("picked: 0", "picked: 1")), HasSubstr("1 successful picks of 0"));
  EXPECT_THAT(error_of("seed: 3\n"), HasSubstr("is no calibration file"));
  EXPECT_THAT(error_of(""), HasSubstr("damaged.yaml"));
  EXPECT_THAT(ErrorOf([&] { ReadCalibration(folder.path() / "none.yaml"); }),
              HasSubstr("none.yaml"));
}

TEST(ScoreCalibration, IsOnlyForItsEstimator) {
  const TemporaryFolder folder;
  const auto file = folder.Write("c.yaml", WriteCalibration(Planted()));
  EstimatorSpec spec = SpecOf(file);
  EXPECT_NO_THROW(CalibrationFor(spec)) << "the program may be in another folder";
  spec.command = {"python3", "other.py"};
  EXPECT_THAT(ErrorOf([&] { CalibrationFor(spec); }),
              AllOf(HasSubstr("'python3 mine.py'"), HasSubstr("'python3 other.py'")));
  spec = SpecOf(file);
  spec.name = "ppf";
  EXPECT_THAT(ErrorOf([&] { CalibrationFor(spec); }), HasSubstr("is for estimator 'process'"));
  spec = SpecOf(file);
  spec.model = "other.net";
  EXPECT_THAT(ErrorOf([&] { CalibrationFor(spec); }), HasSubstr("model"));
  spec = SpecOf(file);
  spec.calibrated_to = "pick_succeeds";
  EXPECT_THAT(ErrorOf([&] { CalibrationFor(spec); }), HasSubstr("has no pick_succeeds"));
}

// An estimator with these scores, best first.
class Scored : public PoseEstimator {
 public:
  explicit Scored(std::vector<double> scores) : scores_(std::move(scores)) {}
  EstimateResult Estimate(const EstimatorInput&, Rng&) override {
    EstimateResult result;
    for (const double score : scores_) result.hypotheses.emplace_back().score = score;
    return result;
  }

 private:
  std::vector<double> scores_;
};

std::vector<double> ScoresFrom(PoseEstimator& estimator, std::vector<double>* raw = nullptr) {
  RgbdFrame frame;
  Rng rng(1);
  std::vector<double> scores;
  for (const PoseHypothesis& pose : estimator.Estimate({frame, std::nullopt}, rng).hypotheses) {
    scores.push_back(pose.score);
    if (raw != nullptr) raw->push_back(pose.raw_score.value());
  }
  return scores;
}

TEST(CalibratedEstimator, ScoresBecomeProbabilitiesAndTheMinimumAppliesToThem) {
  const auto estimator = MakeCalibrated(std::make_unique<Scored>(std::vector{3.5, 1.0 / 3, -50.0}),
                                        Planted().pose_right, 0.5);
  std::vector<double> raw;
  EXPECT_THAT(ScoresFrom(*estimator, &raw), ElementsAre(0.98, 0.75));
  EXPECT_THAT(raw, ElementsAre(3.5, 1.0 / 3));
}

TEST(CalibratedEstimator, UncalibratedRawScoresAreRanked) {
  std::vector<double> raw;
  const auto estimator = MakeRanked(std::make_unique<Scored>(std::vector{3.5, -1.0, -2.0, -120.0}));
  EXPECT_THAT(ScoresFrom(*estimator, &raw), ElementsAre(1, 0.75, 0.5, 0.25));
  EXPECT_THAT(raw, ElementsAre(3.5, -1, -2, -120));
  EXPECT_THAT(ScoresFrom(*MakeRanked(std::make_unique<Scored>(std::vector<double>()))),
              testing::IsEmpty());
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// A curve would give NaN the probability of the highest score, and a rank would hide it.
TEST(CalibratedEstimator, ScoresThatAreNotFiniteAreDroppedAndCounted) {
  TakeNotFiniteCounts();
  std::vector<double> raw;
  const std::vector<double> scores{3.5, kNaN, 1.0 / 3, -kInfinite};
  EXPECT_THAT(
      ScoresFrom(*MakeCalibrated(std::make_unique<Scored>(scores), Planted().pose_right, 0.5),
                 &raw),
      ElementsAre(0.98, 0.75));
  EXPECT_THAT(ScoresFrom(*MakeRanked(std::make_unique<Scored>(scores)), &raw), ElementsAre(1, 0.5));
  EXPECT_THAT(raw, ElementsAre(3.5, 1.0 / 3, 3.5, 1.0 / 3));
  EXPECT_EQ(TakeNotFiniteCounts().at("not_finite/poses"), 4);
}

TEST(FinitePoses, PosesScoresAndRawScoresMustBeFinite) {
  TakeNotFiniteCounts();
  std::vector<PoseHypothesis> poses(6);
  for (size_t i = 0; i < poses.size(); ++i) poses[i].score = static_cast<double>(i);
  poses[1].X_CO.translation().x() = kNaN;
  poses[2].score = kInfinite;
  poses[3].raw_score = kNaN;
  poses[4].raw_score = -120;
  DropNotFinite(poses);
  std::vector<double> left;
  for (const PoseHypothesis& pose : poses) left.push_back(pose.score);
  EXPECT_THAT(left, ElementsAre(0, 4, 5));
  EXPECT_EQ(TakeNotFiniteCounts().at("not_finite/poses"), 3);
}

TEST(CalibratedEstimator, OnlyProgramsHaveRawScores) {
  EstimatorSetup setup;
  setup.objects = {ObjectOf(BracketMesh())};
  setup.spec.name = "ppf";
  setup.spec.scores = "raw";
  EXPECT_THAT(ErrorOf([&] { MakeEstimator(setup); }), HasSubstr("only for estimator process"));
}

}  // namespace
}  // namespace pickbed::tests
