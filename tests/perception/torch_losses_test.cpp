#include "perception/torch_losses.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <cmath>

namespace pickbed {
namespace {

at::Tensor Matrix2(double a, double b, double c, double d) {
  return torch::tensor({{a, b}, {c, d}}, torch::kFloat64);
}

// Anchor 0 is sqrt(2) away from both codes, anchor 1 on both: at a thousandth by the floor.
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

TEST_F(TripletByHand, HardestNegativeAndPairs) {
  EXPECT_NEAR(Loss(1, 1), (hinge_0_ + hinge_1_) / 2 + pairs_, 1e-9);
}

TEST_F(TripletByHand, ANearPoseIsNoNegative) {
  EXPECT_NEAR(Loss(0.19, 1), hinge_0_ / 2 + pairs_, 1e-9);
  EXPECT_NEAR(Loss(0.21, 1), (hinge_0_ + hinge_1_) / 2 + pairs_, 1e-9);
}

TEST_F(TripletByHand, MeanIsOverAllThatAreKept) {
  EXPECT_NEAR(Loss(1, 2), (hinge_0_ + hinge_1_) / 4 + pairs_, 1e-9);
}

// Each anchor is its own code. The other one's pose is as far as halves its weight, and the own one
// counts in full though the code's pose is a diameter away.
TEST(SoftInfoNceLoss, ByHand) {
  LossOptions options;
  options.sigma = 0.1;
  options.temperature = 0.5;
  const double half = options.sigma * std::sqrt(2 * std::log(2.0));
  const double loss =
      SoftInfoNceLoss(Matrix2(1, 0, 0, 1), Matrix2(1, 0, 0, 1), Matrix2(1, half, half, 1), options)
          .item<double>();
  const double sum = std::log(std::exp(2.0) + 1);  // of the exponentials of logits 2 and 0
  EXPECT_NEAR(loss, (sum - 2) * 2 / 3 + sum / 3, 1e-9);
}

TEST(DescriptorLoss, KindChooses) {
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
}  // namespace pickbed
