#include "eval/summary/pile_rates.h"

#include <gtest/gtest.h>

#include "eval/summary/held_instances.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

AttemptRecord PickInLayer(int layer, FailureReason failure) {
  AttemptRecord attempt;
  attempt.grasp = Grasp();
  attempt.layer = layer;
  attempt.failure = failure;
  return attempt;
}

TEST(SuccessByLayers, CountsTheDeepOnesTogether) {
  TrialResult trial;
  trial.attempts = {PickInLayer(1, FailureReason::kNone), PickInLayer(1, FailureReason::kSlipped),
                    PickInLayer(5, FailureReason::kNone), PickInLayer(9, FailureReason::kSlipped),
                    PickInLayer(0, FailureReason::kNone)};
  const std::vector<LayerRate> rates = SuccessByLayers({trial});
  ASSERT_EQ(rates.size(), 2u) << "an unknown layer does not count";
  EXPECT_EQ(rates[0].name(), "1");
  EXPECT_EQ(rates[0].success.samples, 2);
  EXPECT_EQ(rates[0].success.hits, 1);
  EXPECT_EQ(rates[1].name(), "5-");
  EXPECT_EQ(rates[1].success.samples, 2);
  EXPECT_EQ(rates[1].success.hits, 1);
}

TEST(DropTimesOf, AreOfInstancesThatLeftTheHand) {
  TrialResult trial;
  trial.attempts.resize(4);
  EXPECT_EQ(DropTimesOf({trial}).drops, 0);
  for (size_t i = 0; i < 3; ++i) trial.attempts[i].outcome.drop_time_s = 0.5 * (i + 1);
  EXPECT_EQ(DropTimesOf({trial}).drops, 3);
  EXPECT_DOUBLE_EQ(DropTimesOf({trial}).median_s, 1);
}

}  // namespace
}  // namespace pickbed::tests
