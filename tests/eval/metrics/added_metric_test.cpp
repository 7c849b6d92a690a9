#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "eval/compare/paired_comparison.h"
#include "eval/estimate/report.h"
#include "eval/metrics/metric_table.h"
#include "eval/report/run_page.h"
#include "eval/store/results_store.h"
#include "eval/summary/run_csv.h"
#include "eval/trial/pose_matching.h"
#include "tests/support/layer.h"
#include "tests/support/temporary_folder.h"

// A metric that only one row of the table describes reaches every output.

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr MetricRow kVerticalError{
    "vertical_error", "m", "vertical error", "distance of the origins along the optical axis",
    [](const MetricInput& in) {
      return std::abs(in.X_est.translation().z() - in.X_true.translation().z());
    }};
constexpr char kKey[] = "vertical_error_m";

constexpr int kBins = 12;

// One trial per bin with one box, one hypothesis and a grasp on it. The hypothesis is off by
// `per_bin_m` times the bin's number (from 1) along the optical axis, and by 1 mm across it.
std::vector<TrialResult> Trials(double per_bin_m) {
  MetricModel box;
  box.vertices_O = {{-0.02, 0, 0}, {0.02, 0, 0}, {0, 0.02, 0}, {InstanceId{0}, ObjectId{0}, 0.02}};
  box.symmetries_O = {Pose::Identity()};
  box.diameter_m = 0.04;
  const std::vector<MetricModel> boxes{box};
  const Camera camera = [] {
    Camera above;
    above.SetPose(LookAt({0.1, -0.2, 0.8}, {0, 0, 0}, Eigen::Vector3d::UnitZ()));
    return above;
  }();
  std::vector<TrialResult> trials;
  for (int bin = 0; bin < kBins; ++bin) {
    Scene scene;
    scene.objects.push_back({InstanceId{5}, ObjectId{0}, Pose::Identity()});
    const Pose X_CO = Translation({0.001, 0, per_bin_m * (bin + 1)}) * camera.X_CW();
    TrialResult& trial = trials.emplace_back();
    trial.trial = trial.bin_index = BinIndex(bin);
    trial.instances_dropped = trial.instances_cleared = 1;
    trial.outcomes = {{InstanceId{5}, ObjectId{0}, true, true, FailureReason::kNone, 0}};
    AttemptRecord& attempt = trial.attempts.emplace_back();
    const AttemptScore score = ScoreAgainstTruth({boxes, InstancesOf(scene, {1.0}, camera.X_CW())},
                                                 camera, {{ObjectId{0}, X_CO, 0.5, {}}});
    attempt.hypotheses = score.Records();
    attempt.instances = score.instances;
    attempt.chosen = 0;
    attempt.matched_instance = InstanceId{5};
    attempt.grasp = Grasp();
  }
  return trials;
}

ConfigurationReport ReportOf(const std::vector<TrialResult>& trials) {
  const ConfigurationTrials configuration{"", {"box"}, trials, {}};
  return ReportOn({&configuration, 1}).front();
}

std::vector<std::string> Lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string LastCell(const std::string& line) { return line.substr(line.rfind(',') + 1); }

TEST(AddedMetric, IsStoredPerHypothesis) {
  const ScopedMetric added(kVerticalError);
  const TemporaryFolder folder;
  const std::vector<TrialResult> trials = Trials(0.001);
  {
    ResultsStore store(folder.path(), "settings");
    for (const TrialResult& trial : trials) store.Write(trial);
  }
  const std::vector<TrialResult> read = ResultsStore::OpenToRead(folder.path()).ReadAll();
  ASSERT_EQ(read.size(), trials.size());
  for (int bin = 0; bin < kBins; ++bin) {
    const double value = read[bin].attempts.at(0).hypotheses.at(0).metrics.Get(kKey);
    EXPECT_NEAR(value, 0.001 * (bin + 1), 1e-12);
    EXPECT_EQ(value, trials[bin].attempts[0].hypotheses[0].metrics.Get(kKey));
  }
}

TEST(AddedMetric, IsTheLastColumnOfTheCsvFiles) {
  const std::vector<TrialResult> trials = Trials(0.001);
  const std::vector<std::string> before = Lines(AttemptsCsv(trials, {"box"}, {}));
  const ScopedMetric added(kVerticalError);
  std::vector<TrialResult> with = Trials(0.001);
  with.back().attempts[0].chosen = -1;
  const std::vector<std::string> lines = Lines(AttemptsCsv(with, {"box"}, {}));
  EXPECT_EQ(lines.at(0), before.at(0) + ",vertical_error_mm");
  EXPECT_TRUE(lines.at(2).starts_with(before.at(2) + ",")) << "other columns keep their values";
  EXPECT_NEAR(std::stod(LastCell(lines.at(2))), 2, 1e-9);
  EXPECT_EQ(LastCell(lines.back()), "") << "no hypothesis was chosen";
  EXPECT_EQ(LastCell(Lines(AttemptsCsv(trials, {"box"}, {})).at(1)), "") << "not recorded";

  ComparedRow row;
  row.label = "one";
  const HypothesisRecord& hypothesis = with[2].attempts[0].hypotheses[0];
  row.images.emplace_back().score.hypotheses.emplace_back().record = hypothesis;
  auto object = std::make_shared<ObjectModel>();
  object->name = "box";
  const std::vector<std::string> hypotheses = Lines(HypothesesCsv({row}, {object}));
  EXPECT_EQ(hypotheses.at(0),
            "estimator,trial,hypothesis,object,instance,score,mssd_m,mssd_diameters,mspd_px,add_m,"
            "adi_m,rotation_rad,translation_m,correct,p_pick,qw,qx,qy,qz,tx_m,ty_m,tz_m,"
            "vertical_error_m");
  EXPECT_EQ(std::stod(LastCell(hypotheses.at(1))), hypothesis.metrics.Get(kKey));
}

TEST(AddedMetric, HasAHistogramInTheReport) {
  const size_t usual = ReportOf(Trials(0.001)).errors.size();
  const ScopedMetric added(kVerticalError);
  const ConfigurationReport report = ReportOf(Trials(0.001));
  ASSERT_EQ(report.errors.size(), usual + 1);
  const ErrorHistogram& histogram = report.errors.back();
  EXPECT_EQ(histogram.metric, kKey);
  EXPECT_EQ(histogram.unit, "mm");
  EXPECT_EQ(histogram.total, kBins);
  EXPECT_NEAR(histogram.median.value, kBins / 2, 1e-9) << "the lower median, in mm";
  ReportContents contents;
  contents.title = "run";
  contents.configurations = {report};
  const std::string page = ReportPage(contents);
  EXPECT_THAT(page, HasSubstr("Pose error: vertical<"));
  EXPECT_THAT(page, HasSubstr("edian 6.00 ["));
}

TEST(AddedMetric, IsNotReportedForTrialsWithoutIt) {
  const std::vector<TrialResult> without = Trials(0.001);
  const ScopedMetric added(kVerticalError);
  EXPECT_EQ(ReportOf(without).errors.back().metric, kRotation_rad);
  for (const PairedStatistic& statistic : ComparePaired(without, Trials(0.001)).statistics) {
    EXPECT_THAT(statistic.key, Not(HasSubstr("vertical")));
  }
}

TEST(AddedMetric, HasAPairedMedian) {
  const ScopedMetric added(kVerticalError);
  const PairedComparison comparison = ComparePaired(Trials(0.001), Trials(0.0005));
  std::vector<std::string> keys;
  for (const PairedStatistic& statistic : comparison.statistics) keys.push_back(statistic.key);
  ASSERT_THAT(keys, testing::Contains("median_vertical_error_mm"));
  const PairedStatistic& statistic = comparison.statistics.back();
  EXPECT_EQ(statistic.name, "median vertical error, mm");
  EXPECT_NEAR(statistic.before, 6, 1e-9);
  EXPECT_NEAR(statistic.after, 3, 1e-9);
  EXPECT_NEAR(statistic.difference(), -3, 1e-9);
  EXPECT_LT(statistic.p_value, 0.05);
}

TEST(MetricTable, KeysAreUnique) {
  std::vector<std::string> keys;
  for (const MetricRow& row : MetricTable()) keys.push_back(MetricKey(row));
  std::sort(keys.begin(), keys.end());
  EXPECT_EQ(std::adjacent_find(keys.begin(), keys.end()), keys.end());
}

TEST(MetricTable, RecordsOfAllTrialsHaveTheSameMetrics) {
  std::vector<std::string> infinite, recorded;
  for (const MetricValue& value : InfiniteMetrics()) infinite.push_back(value.metric);
  const HypothesisRecord hypothesis = Trials(0.001)[0].attempts[0].hypotheses[0];
  for (const MetricValue& value : hypothesis.metrics) recorded.push_back(value.metric);
  EXPECT_EQ(recorded, infinite);
  EXPECT_THAT(recorded, ElementsAre("mssd_diameters", "mssd_m", "mspd_px", "add_m", "adi_m",
                                    "rotation_rad", "translation_m"));
}

TEST(MetricTable, UnitsAreShownForReaders) {
  std::vector<std::string> shown;
  for (const MetricRow& row : MetricsIn(kRecorded)) shown.push_back(ShownKey(row));
  EXPECT_THAT(shown, ElementsAre("mssd_diameters", "mssd_mm", "mspd_px", "add_mm", "adi_mm",
                                 "rotation_deg", "translation_mm"));
}

}  // namespace
}  // namespace pickbed::tests
