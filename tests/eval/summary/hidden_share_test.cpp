#include "eval/summary/hidden_share.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/stub_trials.h"

namespace pickbed::tests {
namespace {

// Trials of one attempt at a target with this visible fraction, in scenes of their own.
std::vector<TrialResult> TargetsAt(const std::vector<double>& visible, bool picked) {
  std::vector<TrialResult> trials;
  for (const double fraction : visible) {
    TrialResult& trial = trials.emplace_back();
    trial.trial = static_cast<int>(trials.size()) - 1;
    trial.bin_index = BinIndex(trial.trial);
    AttemptRecord& attempt = trial.attempts.emplace_back();
    attempt.target = InstanceId{7};
    attempt.instances = {{InstanceId{3}, ObjectId{0}, 0.55, true},
                         {InstanceId{7}, ObjectId{0}, fraction, picked}};
    attempt.failure = picked ? FailureReason::kNone : FailureReason::kSlipped;
    attempt.grasp = Grasp();
  }
  return trials;
}

TEST(HiddenShare, EachTargetIsInTheBandOfItsHiddenShare) {
  const auto bands = StatisticsByHiddenShare(TargetsAt({1, 0.95, 0.85, 0.62, 0.14, 0.05}, true));
  ASSERT_EQ(bands.size(), static_cast<size_t>(kHiddenBands));
  std::vector<int> attempts;
  for (const HiddenBand& band : bands) {
    attempts.push_back(band.picked.samples);
    EXPECT_EQ(band.recalled.samples, band.picked.samples) << "only the target counts";
    if (band.picked.samples == 0) continue;
    EXPECT_GE(band.mean_hidden, band.hidden_min);
    EXPECT_LT(band.mean_hidden, band.hidden_max);
    EXPECT_EQ(band.picked.rate(), 1);
  }
  EXPECT_THAT(attempts, testing::ElementsAre(2, 1, 0, 1, 0, 0, 0, 0, 1));
  EXPECT_NEAR(bands[0].mean_hidden, 0.025, 1e-12);
  for (const HiddenBand& band : StatisticsByHiddenShare(TargetsAt({0.95, 0.5}, false))) {
    EXPECT_EQ(band.picked.hits + band.recalled.hits, 0);
  }
}

TEST(HiddenShare, AttemptsWithoutATargetDoNotCount) {
  for (const HiddenBand& band : StatisticsByHiddenShare(StubTrials(3))) {
    EXPECT_EQ(band.picked.samples + band.recalled.samples, 0);
  }
}

// Success falls with the hidden share in each published curve.
TEST(HiddenShare, TableHasThePublishedCurves) {
  for (const PublishedCurve& curve : TargoCurves()) {
    EXPECT_GT(curve.success.front(), curve.success.back()) << curve.method;
    for (const double rate : curve.success) {
      EXPECT_GT(rate, 0.2) << curve.method;
      EXPECT_LT(rate, 0.9) << curve.method;
    }
  }
  const std::vector<NamedHiddenCurve> curves{
      {"a,b", StatisticsByHiddenShare(TargetsAt({0.95, 0.25}, true))}};
  std::istringstream lines(HiddenShareCsv(curves));
  std::vector<std::string> rows;
  for (std::string line; std::getline(lines, line);) rows.push_back(line);
  ASSERT_EQ(rows.size(), 1u + kHiddenBands);
  EXPECT_THAT(rows[0],
              testing::EndsWith("targo_net,giga_hr,giga,vgn,vn_edgegraspnet,edgegraspnet"));
  EXPECT_THAT(rows[1], testing::StartsWith("\"a,b\",0,0.1,1,0.05"));
  EXPECT_THAT(rows[1], testing::EndsWith(",0.87,0.813,0.798,0.727,0.639,0.603"));
  EXPECT_THAT(rows[9], testing::EndsWith(",0.798,0.576,0.6,0.502,0.388,0.272"));
  const auto commas = [](const std::string& row) {
    return std::count(row.begin(), row.end(), ',');
  };
  for (size_t i = 2; i < rows.size(); ++i) EXPECT_EQ(commas(rows[i]), commas(rows[0]) + 1);
}

}  // namespace
}  // namespace pickbed::tests
