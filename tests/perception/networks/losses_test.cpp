#include "perception/networks/losses.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <cmath>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

at::Tensor Matrix2(double a, double b, double c, double d) {
  return torch::tensor({{a, b}, {c, d}}, torch::kFloat64);
}

// Anchor 0 is sqrt(2) away from both codes. Anchor 1 equals both codes, and the distance floor
// makes it a thousandth.
class TripletByHand : public ::testing::Test {
 protected:
  double Loss(double distance_10, int negatives) const {
    LossOptions options;
    options.margin = 0.01;
    options.dissimilar = 0.2;
    options.negatives = negatives;
    options.pair_weight = 3;
    return TripletAndPairLoss(Matrix2(1, 0, 0, 1), Matrix2(0, 1, 0, 1),
                              Matrix2(0, 1, distance_10, 0), options)
        .item<double>();
  }
  const double hinge_0_ = 1 - std::sqrt(2.0) / (std::sqrt(2.0) + 0.01);
  const double hinge_1_ = 1 - 0.001 / (0.001 + 0.01);
  const double pairs_ = 3 * (2 + 1e-6) / 2;
};

TEST_F(TripletByHand, LossIsHardestNegativePlusPairs) {
  EXPECT_NEAR(Loss(1, 1), (hinge_0_ + hinge_1_) / 2 + pairs_, 1e-9);
}

TEST_F(TripletByHand, NearPosesAreNotNegatives) {
  EXPECT_NEAR(Loss(0.19, 1), hinge_0_ / 2 + pairs_, 1e-9);
  EXPECT_NEAR(Loss(0.21, 1), (hinge_0_ + hinge_1_) / 2 + pairs_, 1e-9);
}

TEST_F(TripletByHand, MeanIsOverAllKeptNegatives) {
  EXPECT_NEAR(Loss(1, 2), (hinge_0_ + hinge_1_) / 4 + pairs_, 1e-9);
}

// Each anchor equals its code. The pose of the other code is at the distance that halves its
// weight. The own code counts in full, although its pose is a diameter away.
TEST(SoftInfoNceLoss, EqualsHandComputedValue) {
  LossOptions options;
  options.sigma = 0.1;
  options.temperature = 0.5;
  const double half = options.sigma * std::sqrt(2 * std::log(2.0));
  const double loss =
      SoftInfoNceLoss(Matrix2(1, 0, 0, 1), Matrix2(1, 0, 0, 1), Matrix2(1, half, half, 1), options)
          .item<double>();
  const double sum = std::log(std::exp(2.0) + 1);  // log-sum-exp of the logits 2 and 0
  EXPECT_NEAR(loss, (sum - 2) * 2 / 3 + sum / 3, 1e-9);
}

TEST(DescriptorLoss, KindSelectsTheLoss) {
  const at::Tensor f = Matrix2(1, 0, 0, 1), distance = Matrix2(0, 1, 1, 0);
  LossOptions options;
  options.kind = "infonce";
  EXPECT_EQ(DescriptorLoss(f, f, distance, options).item<double>(),
            SoftInfoNceLoss(f, f, distance, options).item<double>());
  options.kind = "triplet";
  EXPECT_EQ(DescriptorLoss(f, f, distance, options).item<double>(),
            TripletAndPairLoss(f, f, distance, options).item<double>());
}

}  // namespace
}  // namespace pickbed::tests
