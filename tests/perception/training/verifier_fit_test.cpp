#include "perception/training/verifier_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/base/error.h"
#include "scenes/base/random.h"

namespace pickbed::tests {
namespace {

TEST(TrainVerifier, LearnsASeparableRuleAndRefusesOneSidedExamples) {
  Rng rng(1);
  VerifierExamples examples;
  for (int i = 0; i < 1500; ++i) {
    VerifyFeatures features;
    for (float& feature : features) feature = static_cast<float>(rng.Normal());
    examples.right.push_back(features[0] * features[1] > 0.1f);  // not linear
    examples.features.push_back(features);
  }
  examples.held_out_from = 1200;
  VerifierOptions options;
  options.iterations = 800;
  const TrainedNetwork trained = TrainVerifier(examples, options, 0);
  EXPECT_GT(trained.auc, 0.95);
  VerifyFeatures right{};
  right[0] = right[1] = 1.5f;
  EXPECT_GT(trained.network.Logit(right), 1.4);
  right[1] = -1.5f;
  EXPECT_LT(trained.network.Logit(right), -1.4);
  examples.right.assign(examples.right.size(), 1);
  EXPECT_THROW(TrainVerifier(examples, options, 0), InputError);
}

// Few examples of a rule with noise.
VerifierExamples NoisyExamples() {
  Rng rng(2);
  VerifierExamples examples;
  for (int i = 0; i < 400; ++i) {
    VerifyFeatures features;
    for (float& feature : features) feature = static_cast<float>(rng.Normal());
    examples.right.push_back(features[0] + rng.Normal() > 0);
    examples.features.push_back(features);
  }
  return examples;
}

// Standard deviation of the logit between trainings that differ in their seed, mean over features.
double SpreadOverSeeds(const VerifierExamples& examples, const VerifierOptions& options) {
  constexpr int kSeeds = 6, kPoints = 20;
  std::vector<VerifierNetwork> networks;
  for (int seed = 0; seed < kSeeds; ++seed) {
    networks.push_back(TrainVerifier(examples, options, seed).network);
  }
  double sum = 0;
  for (int i = 0; i < kPoints; ++i) {
    Eigen::VectorXd logits(kSeeds);
    for (int n = 0; n < kSeeds; ++n) logits[n] = networks[n].Logit(examples.features[i]);
    sum += std::sqrt((logits.array() - logits.mean()).square().sum() / (kSeeds - 1));
  }
  return sum / kPoints;
}

TEST(TrainVerifier, TheMeanOfNetworksVariesLessBetweenSeeds) {
  const VerifierExamples examples = NoisyExamples();
  VerifierOptions options;
  options.iterations = 300;
  options.hidden = 12;
  options.networks = 1;
  const double one = SpreadOverSeeds(examples, options);
  options.networks = 3;
  EXPECT_LT(SpreadOverSeeds(examples, options), 0.75 * one);
}

TEST(TrainVerifier, HiddenUnitsThatCannotBeSharedEquallyAreAllUsed) {
  VerifierOptions options;
  options.iterations = 50;
  options.hidden = 7;
  const VerifierNetwork network = TrainVerifier(NoisyExamples(), options, 0).network;
  ASSERT_EQ(network.w1.rows(), 7);
  for (int unit = 0; unit < 7; ++unit) EXPECT_NE(network.w2[unit], 0);
  options.networks = 8;  // more than there are units
  EXPECT_EQ(TrainVerifier(NoisyExamples(), options, 0).network.w1.rows(), 7);
}

TEST(MeanNetwork, HasTheMeanOfBothLogits) {
  const VerifierExamples examples = NoisyExamples();
  VerifierOptions options;
  options.iterations = 50;
  options.hidden = 7;
  const VerifierNetwork a = TrainVerifier(examples, options, 0).network;
  VerifierExamples shifted = examples;  // so that the standardisations differ
  for (VerifyFeatures& features : shifted.features) {
    for (float& feature : features) feature = 3 * feature + 1;
  }
  options.hidden = 5;
  const VerifierNetwork b = TrainVerifier(shifted, options, 1).network;
  const VerifierNetwork mean = MeanNetwork(a, b);
  ASSERT_EQ(mean.w1.rows(), 12);
  for (const VerifyFeatures& features : examples.features) {
    const float logit_a = a.Logit(features), logit_b = b.Logit(features);
    EXPECT_NEAR(mean.Logit(features), 0.5f * (logit_a + logit_b), 1e-4);
  }
}

}  // namespace
}  // namespace pickbed::tests
