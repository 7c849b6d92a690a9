#include "perception/icp/projective_icp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

class BracketIcp : public ::testing::Test {
 protected:
  BracketIcp()
      : object_(ObjectOf(BracketMesh())), model_(MakeModelPoints(*object_)), truth_(BracketPose()) {
    SyntheticDepth scene(SmallCamera());
    scene.AddMesh(object_->mesh_O, truth_);
    frame_ = scene.frame();
  }
  std::shared_ptr<const ObjectModel> object_;
  ModelPoints model_;
  Pose truth_;
  RgbdFrame frame_;
};

TEST_F(BracketIcp, RecoversFiveDegreesAndThreeMillimetres) {
  const OrganizedCloud cloud = BuildCloud(frame_, std::nullopt, kKeepAll);
  Rng rng(1);
  for (int i = 0; i < 30; ++i) {
    const Pose start = Perturbed(truth_, rng.UnitVector(), 5, 0.003 * rng.UnitVector());
    const IcpResult result = ProjectiveIcp(cloud, model_, start);
    const PoseGap gap = GapBetween(result.X_CO, truth_);
    EXPECT_LT(gap.angle_deg, 0.7) << i;
    EXPECT_LT(gap.shift_m, 0.0006) << i;
    EXPECT_EQ(result.status, IcpStatus::kRefined) << i;
    EXPECT_EQ(result.iterations, 16) << i;  // all coarse and fine iterations
    EXPECT_GT(result.inlier_fraction, 0.6) << i;
    EXPECT_LT(result.rmse_m, 0.0004) << i;
  }
}

TEST_F(BracketIcp, RecoversUnderNoise) {
  Rng rng(2);
  const OrganizedCloud cloud = BuildCloud(WithNoise(frame_, 0.002, rng), std::nullopt, kKeepAll);
  for (int i = 0; i < 10; ++i) {
    const Pose start = Perturbed(truth_, rng.UnitVector(), 5, 0.003 * rng.UnitVector());
    const PoseGap gap = GapBetween(ProjectiveIcp(cloud, model_, start).X_CO, truth_);
    EXPECT_LT(gap.angle_deg, 1.0) << i;
    EXPECT_LT(gap.shift_m, 0.001) << i;
  }
}

TEST_F(BracketIcp, GroundTruthIsAFixedPoint) {
  const OrganizedCloud cloud = BuildCloud(frame_, std::nullopt, kKeepAll);
  const PoseGap gap = GapBetween(ProjectiveIcp(cloud, model_, truth_).X_CO, truth_);
  EXPECT_LT(gap.angle_deg, 0.4);
  EXPECT_LT(gap.shift_m, 0.0003);
}

TEST_F(BracketIcp, ResultIsARotationMatrix) {
  const OrganizedCloud cloud = BuildCloud(frame_, std::nullopt, kKeepAll);
  const Pose X = ProjectiveIcp(cloud, model_, truth_).X_CO;
  EXPECT_TRUE((X.linear() * X.linear().transpose()).isIdentity(1e-12));
  EXPECT_NEAR(X.linear().determinant(), 1, 1e-12);
}

TEST_F(BracketIcp, EmptyImageLeavesThePoseUnchanged) {
  const CameraIntrinsics k = SmallCamera();
  const RgbdFrame empty{k, {}, Image<float>(k.width(), k.height())};
  const IcpResult result = ProjectiveIcp(BuildCloud(empty, std::nullopt), model_, truth_);
  EXPECT_EQ(result.status, IcpStatus::kTooFewCorrespondences);
  EXPECT_EQ(result.iterations, 0);
  EXPECT_EQ(result.inlier_fraction, 0);
  EXPECT_TRUE(result.X_CO.isApprox(truth_, 1e-12));
}

TEST_F(BracketIcp, PosesOutOfViewAndNansAreRejected) {
  const OrganizedCloud cloud = BuildCloud(frame_, std::nullopt, kKeepAll);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(5, 0, 0.5), Eigen::Vector3d(0, 0, -0.5), Eigen::Vector3d(nan, 0, 0.5)}) {
    const IcpResult result = ProjectiveIcp(cloud, model_, Translation(p));
    EXPECT_EQ(result.status, IcpStatus::kTooFewCorrespondences);
    EXPECT_EQ(result.inlier_fraction, 0);
  }
}

// A box seen frontally shows one plane and can slide, so the reciprocal condition number is near 0.
TEST(ProjectiveIcp, ReciprocalConditionNumberSeparatesAPlaneFromASolid) {
  const auto bracket = ObjectOf(BracketMesh());
  SyntheticDepth solid(SmallCamera());
  solid.AddMesh(bracket->mesh_O, BracketPose());
  const double held = ProjectiveIcp(BuildCloud(solid.frame(), std::nullopt, kKeepAll),
                                    MakeModelPoints(*bracket), BracketPose())
                          .reciprocal_condition_number;

  const auto plate = ObjectOf(BoxMesh({0.06, 0.06, 0.01}, Eigen::Vector3d::Zero()));
  const Pose straight_on = Translation({0, 0, 0.4});
  SyntheticDepth plane(SmallCamera());
  plane.AddMesh(plate->mesh_O, straight_on);
  const IcpResult result = ProjectiveIcp(BuildCloud(plane.frame(), std::nullopt, kKeepAll),
                                         MakeModelPoints(*plate), straight_on);
  EXPECT_GT(held, 0.01);
  EXPECT_LT(result.reciprocal_condition_number, 1e-4);
  // Damping prevents drift in the unconstrained directions.
  EXPECT_LT(GapBetween(result.X_CO, straight_on).shift_m, 0.0005);
}

}  // namespace
}  // namespace pickbed::tests
