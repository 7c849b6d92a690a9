// Losses of networks/doumanoglou.h, and the targets and outputs of its network.

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "perception/features/pose_targets.h"
#include "perception/model/pose_distance.h"
#include "perception/networks/doumanoglou.h"
#include "scenes/base/random.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

at::Tensor Row(const Eigen::Quaterniond& q) {
  return torch::tensor({{q.w(), q.x(), q.y(), q.z()}}, torch::kFloat64);
}

// The first two columns of the rotation matrix.
at::Tensor SixD(const Eigen::Quaterniond& q) {
  const Eigen::Matrix3d R = q.toRotationMatrix();
  return torch::tensor({{R(0, 0), R(1, 0), R(2, 0), R(0, 1), R(1, 1), R(2, 1)}}, torch::kFloat64);
}

Eigen::Quaterniond RotationBy(double angle_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(1, -2, 0.5).normalized()));
}

class EveryRotationForm : public testing::TestWithParam<bool> {
 protected:
  static at::Tensor Form(const Eigen::Quaterniond& q) { return GetParam() ? SixD(q) : Row(q); }
  static double Distance(const at::Tensor& values, const std::vector<Eigen::Quaterniond>& right) {
    std::vector<at::Tensor> rows;
    for (const Eigen::Quaterniond& q : right) rows.push_back(Row(q));
    return QuaternionDistance(values, torch::cat(rows).unsqueeze(0)).item<double>();
  }
};

TEST_P(EveryRotationForm, DistanceIsZeroForTrueAndSymmetricRotations) {
  const Eigen::Quaterniond q = RotationBy(2.2), symmetric = q * Eigen::Quaterniond(0, 0, 0, 1);
  EXPECT_NEAR(Distance(Form(q), {q}), 0, 2e-6);
  EXPECT_NEAR(Distance(Form(symmetric), {q, symmetric}), 0, 2e-6);
  EXPECT_GT(Distance(Form(symmetric), {q}), 0.9);
  const Eigen::Quaterniond negative(-q.w(), -q.x(), -q.y(), -q.z());
  EXPECT_NEAR(Distance(Form(negative), {q}), 0, 2e-6);
  EXPECT_NEAR(Distance(Form(q), {negative}), 0, 2e-6);
  EXPECT_NEAR(Distance(3.7 * Form(q), {q}), 0, 2e-6) << "the length is ignored";
}

TEST_P(EveryRotationForm, SmallRotationsCountWithHalfTheirAngle) {
  const Eigen::Quaterniond q = RotationBy(-0.8);
  const Eigen::Quaterniond off(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()));
  EXPECT_NEAR(Distance(Form(q * off), {q}), 0.01, 1e-5);
}

TEST_P(EveryRotationForm, MatricesEqualTheRotation) {
  for (const double angle : {0.0, 0.4, 2.9, -1.7}) {
    const Eigen::Matrix3d R = RotationBy(angle).toRotationMatrix();
    const at::Tensor found = RotationMatrices(2 * Form(RotationBy(angle)));
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(found[0][i][j].item<double>(), R(i, j), 1e-9);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Forms, EveryRotationForm, testing::Bool(),
                         [](const auto& info) { return info.param ? "SixD" : "Quaternion"; });

TEST(SiameseLoss, ZeroIfFeatureDistancesEqualPoseDistances) {
  const at::Tensor anchors = torch::tensor({{0.0, 0.0}, {3.0, 0.0}}, torch::kFloat64);
  const at::Tensor codes = torch::tensor({{0.0, 4.0}, {1.0, 0.0}}, torch::kFloat64);
  const at::Tensor distance = torch::tensor({{4.0, 1.0}, {5.0, 2.0}}, torch::kFloat64);
  const at::Tensor all = torch::ones({2, 2}, torch::kBool);
  EXPECT_NEAR(SiameseLoss(anchors, codes, distance, all).item<double>(), 0, 1e-9);
  // One of four pairs is off by 0.6. The mean over only the two pairs of one object is another.
  const at::Tensor off = torch::tensor({{4.6, 1.0}, {5.0, 2.0}}, torch::kFloat64);
  EXPECT_NEAR(SiameseLoss(anchors, codes, off, all).item<double>(), 0.15, 1e-9);
  const at::Tensor same = torch::eye(2, torch::kBool);
  EXPECT_NEAR(SiameseLoss(anchors, codes, off, same).item<double>(), 0.3, 1e-9);
  EXPECT_NEAR(SiameseLoss(anchors, codes, off, ~same).item<double>(), 0, 1e-9);
}

// A pose that is converted to targets and read back is unchanged.
TEST(PoseTargets, RoundTripGivesThePose) {
  const auto model = ObjectOf(BracketMesh());
  const PoseTargets targets(*model, 0.05);
  const Pose X_PO = MakePose(RotationBy(1.9).toRotationMatrix(), {0.01, -0.02, 0.03});
  std::vector<float> q, values{1};
  targets.AppendRotations(X_PO, q);
  ASSERT_EQ(q.size(), 4u);
  const Eigen::Matrix3f R = Eigen::Quaternionf(q[0], q[1], q[2], q[3]).toRotationMatrix();
  for (int i = 0; i < 9; ++i) values.push_back(R(i / 3, i % 3));
  for (const float x : targets.Center(X_PO)) values.push_back(x);
  const Pose read = targets.PoseOf(values);
  EXPECT_LT(GapBetween(read, X_PO).angle_deg, 0.01);
  EXPECT_LT(GapBetween(read, X_PO).shift_m, 1e-6);
}

// All target rotations belong to equivalent poses, at distance zero from each other.
TEST(PoseTargets, AllTargetRotationsAreEquivalent) {
  SymmetrySet symmetries;
  symmetries.continuous_O = {ContinuousSymmetry{}};
  symmetries.discrete_O = {MakePose(
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix(), {0, 0, 0})};
  const auto model = ObjectOf(BoxMesh({0.02, 0.02, 0.06}, {0, 0, 0}), symmetries);
  const PoseTargets targets(*model, 0.05);
  EXPECT_EQ(targets.variants(), 48);
  const Pose X_PO = MakePose(RotationBy(1.9).toRotationMatrix(), {0.01, -0.02, 0.03});
  std::vector<float> q;
  targets.AppendRotations(X_PO, q);
  const PoseEmbedding embedding(*model);
  const Eigen::Vector3f center = targets.Center(X_PO);
  for (int v = 0; v < targets.variants(); ++v) {
    const float* w = q.data() + 4 * v;
    const Eigen::Matrix3f R = Eigen::Quaternionf(w[0], w[1], w[2], w[3]).toRotationMatrix();
    std::vector<float> values{1};
    for (int i = 0; i < 9; ++i) values.push_back(R(i / 3, i % 3));
    values.insert(values.end(), center.begin(), center.end());
    EXPECT_LT(embedding.Distance(targets.PoseOf(values), X_PO), 1e-4) << v;
  }
}

}  // namespace
}  // namespace pickbed::tests
