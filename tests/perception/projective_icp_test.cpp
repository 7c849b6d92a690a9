#include "perception/projective_icp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/synthetic_depth.h"

namespace pickbed {
namespace {

constexpr CloudOptions kKeepAll{.min_plane_share = 1};

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
    const IcpReport report = ProjectiveIcp(cloud, model_, start);
    const PoseGap gap = GapBetween(report.X_CO, truth_);
    EXPECT_LT(gap.angle_deg, 0.7) << i;
    EXPECT_LT(gap.shift_m, 0.0006) << i;
    EXPECT_GT(report.overlap, 0.6) << i;
    EXPECT_LT(report.residual_m, 0.0004) << i;
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

TEST_F(BracketIcp, StaysAtTheTruth) {
  const OrganizedCloud cloud = BuildCloud(frame_, std::nullopt, kKeepAll);
  const PoseGap gap = GapBetween(ProjectiveIcp(cloud, model_, truth_).X_CO, truth_);
  EXPECT_LT(gap.angle_deg, 0.4);
  EXPECT_LT(gap.shift_m, 0.0003);
}

TEST_F(BracketIcp, ResultIsARotation) {
  const OrganizedCloud cloud = BuildCloud(frame_, std::nullopt, kKeepAll);
  const Pose X = ProjectiveIcp(cloud, model_, truth_).X_CO;
  EXPECT_TRUE((X.linear() * X.linear().transpose()).isIdentity(1e-12));
  EXPECT_NEAR(X.linear().determinant(), 1, 1e-12);
}

TEST_F(BracketIcp, NothingThereLeavesThePoseAlone) {
  const CameraIntrinsics k = SmallCamera();
  const RgbdFrame empty{k, {}, Image<float>(k.width, k.height)};
  const IcpReport report = ProjectiveIcp(BuildCloud(empty, std::nullopt), model_, truth_);
  EXPECT_EQ(report.overlap, 0);
  EXPECT_TRUE(report.X_CO.isApprox(truth_, 1e-12));
}

TEST_F(BracketIcp, PosesOutOfSightAndNansDoNoHarm) {
  const OrganizedCloud cloud = BuildCloud(frame_, std::nullopt, kKeepAll);
  EXPECT_EQ(ProjectiveIcp(cloud, model_, Translation({5, 0, 0.5})).overlap, 0);
  EXPECT_EQ(ProjectiveIcp(cloud, model_, Translation({0, 0, -0.5})).overlap, 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ProjectiveIcp(cloud, model_, Translation({nan, 0, 0.5})).overlap, 0);
}

// A box seen straight on shows one plane: it can slide, and the report says so.
TEST(ProjectiveIcp, ConditioningTellsAPlaneFromASolid) {
  const auto bracket = ObjectOf(BracketMesh());
  SyntheticDepth solid(SmallCamera());
  solid.AddMesh(bracket->mesh_O, BracketPose());
  const double held = ProjectiveIcp(BuildCloud(solid.frame(), std::nullopt, kKeepAll),
                                    MakeModelPoints(*bracket), BracketPose())
                          .conditioning;

  const auto plate = ObjectOf(BoxMesh({0.06, 0.06, 0.01}, Eigen::Vector3d::Zero()));
  const Pose straight_on = Translation({0, 0, 0.4});
  SyntheticDepth plane(SmallCamera());
  plane.AddMesh(plate->mesh_O, straight_on);
  const IcpReport report = ProjectiveIcp(BuildCloud(plane.frame(), std::nullopt, kKeepAll),
                                         MakeModelPoints(*plate), straight_on);
  EXPECT_GT(held, 0.01);
  EXPECT_LT(report.conditioning, 1e-4);
  // Damping keeps it from wandering where nothing holds it.
  EXPECT_LT(GapBetween(report.X_CO, straight_on).shift_m, 0.0005);
}

}  // namespace
}  // namespace pickbed
