#include "tests/support/pick_outcomes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/calibrate/fit.h"
#include "tests/support/temporary_folder.h"

// Pose errors as predictors of picks, on outcomes of another group's simulation with other hands.
// `outcome_figures` prints all numbers.

namespace pickbed::tests {
namespace {

const std::filesystem::path kOutcomes =
    std::filesystem::path(PICKBED_TEST_DATA) / "pick_outcomes/outcomes.csv";

class PublishedOutcomes : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kOutcomes)) GTEST_SKIP() << "no file " << kOutcomes;
    pairs_ = ReadPickOutcomes(kOutcomes);
  }
  double MedianAuc(const std::string& hand, const std::string& error) const {
    for (const RankedError& ranked : RankErrors(pairs_, hand)) {
      if (ranked.error == error) return ranked.median_auc;
    }
    return 0;
  }
  std::vector<ObjectMethodPair> pairs_;
};

TEST_F(PublishedOutcomes, MssdPredictsPicksAsWellAsPublished) {
  EXPECT_EQ(pairs_.size(), 90u);
  EXPECT_NEAR(MedianAuc("parallel", "mssd_m"), 0.90, 0.02);
  EXPECT_NEAR(MedianAuc("underactuated", "mssd_m"), 0.95, 0.02);
}

// Errors in space predict picks better than errors in the image and than the rotation.
TEST_F(PublishedOutcomes, ErrorsInSpaceRankBeforeErrorsInTheImage) {
  for (const char* hand : {"parallel", "underactuated"}) {
    for (const char* in_space : {"mssd_m", "add_m", "translation_m"}) {
      for (const char* other : {"vsd_020", "mspd_px", "rotation_deg"}) {
        EXPECT_GT(MedianAuc(hand, in_space), MedianAuc(hand, other)) << hand << in_space << other;
      }
    }
    EXPECT_EQ(RankErrors(pairs_, hand).front().error, "mssd_m");
  }
}

// P(pick succeeds) of an object, fitted on two methods, holds for the third.
TEST_F(PublishedOutcomes, AFitOnOtherMethodsPredictsTheSuccessRate) {
  const auto clusters_of = [](const ObjectMethodPair& pair) {
    std::vector<ScoredOutcome> outcomes;
    for (const PickedPose& pose : pair.poses) outcomes.push_back({-pose.errors[0], pose.picked});
    return outcomes;
  };
  std::vector<double> with_fit, without_fit;
  for (const ObjectMethodPair& tested : pairs_) {
    OutcomeClusters others;
    for (const ObjectMethodPair& pair : pairs_) {
      if (pair.hand == tested.hand && pair.dataset == tested.dataset &&
          pair.object == tested.object && pair.method != tested.method) {
        others.push_back(clusters_of(pair));
      }
    }
    const ScoreCurve curve = FitCurve(others);
    double expected = 0, of_others = 0, count = 0;
    for (const PickedPose& pose : tested.poses) expected += curve.At(-pose.errors[0]);
    for (const auto& cluster : others) {
      for (const ScoredOutcome& outcome : cluster) {
        of_others += outcome.success;
        ++count;
      }
    }
    const double n = static_cast<double>(tested.poses.size()), rate = tested.successes() / n;
    with_fit.push_back(std::abs(expected / n - rate));
    without_fit.push_back(std::abs(of_others / count - rate));
  }
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  };
  EXPECT_LT(mean(with_fit), 0.05);
  EXPECT_LT(mean(with_fit), 0.7 * mean(without_fit)) << "the errors explain the rates";
}

// The reader and the ranking, without the data.
TEST(PickOutcomes, PairsAreReadAndRanked) {
  const TemporaryFolder folder;
  const auto file = folder.Write(
      "outcomes.csv",
      "method,dataset,object,gripper,scene,image,rotation_deg,translation_m,vsd_020,mssd_m,mspd_px,"
      "add_m,diameter_m,picked\n"
      "epos,lmo,1,parallel,2,3,10,0.01,0.1,0.01,5,0.02,0.1,1\n"
      "epos,lmo,1,parallel,2,4,90,0.02,0.5,0.02,9,0.01,0.1,0\n"
      "epos,lmo,5,parallel,2,4,90,0.02,0.5,0.02,9,0.03,0.1,0\n");
  const auto pairs = ReadPickOutcomes(file);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].object, "1");
  EXPECT_TRUE(pairs[0].has_both());
  EXPECT_FALSE(pairs[1].has_both());
  EXPECT_EQ(pairs[0].AucOf(0), 1);
  const auto ranked = RankErrors(pairs, "parallel");
  EXPECT_EQ(ranked.front().error, "mssd_m");
  EXPECT_EQ(ranked.back().error, "add_m");
  EXPECT_EQ(ranked.back().median_auc, 0);
}

}  // namespace
}  // namespace pickbed::tests
