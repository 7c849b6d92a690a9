#include "perception/two_way_icp.h"

#include <gtest/gtest.h>

#include <limits>

#include "perception/projective_icp.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed {
namespace {

constexpr CloudOptions kKeepAll{.min_plane_share = 1};

// The bracket before a wall far behind it.
class BracketTwoWay : public ::testing::Test {
 protected:
  BracketTwoWay() : object_(ObjectOf(BracketMesh())), model_(MakeModelPoints(*object_)) {
    SyntheticDepth scene(SmallCamera());
    scene.AddMesh(object_->mesh_O, truth_);
    scene.AddPlane({0, 0, -1}, {0, 0, 1.0});
    Rng noise(1);
    cloud_ = BuildCloud(WithNoise(scene.frame(), 0.001, noise), std::nullopt, kKeepAll);
  }
  const Pose truth_ = BracketPose();
  std::shared_ptr<const ObjectModel> object_;
  ModelPoints model_;
  OrganizedCloud cloud_;
};

TEST_F(BracketTwoWay, RecoversTenDegreesAndTenMillimetres) {
  Rng rng(2);
  int bulk_found = 0;
  for (int i = 0; i < 20; ++i) {
    const Pose start = Perturbed(truth_, rng.UnitVector(), 10, 0.010 * rng.UnitVector());
    const TwoWayReport report = TwoWayIcp(cloud_, model_, start);
    const PoseGap gap = GapBetween(report.X_CO, truth_);
    EXPECT_LT(gap.angle_deg, 3) << i;
    EXPECT_LT(gap.shift_m, 0.002) << i;
    EXPECT_FALSE(report.made_worse) << i;
    EXPECT_GT(report.agreement, report.agreement_before) << i;
    EXPECT_GT(report.overlap, 0.7) << i;
    EXPECT_GT(report.conditioning, 0.005) << i;
    const PoseGap bulk = GapBetween(ProjectiveIcp(cloud_, model_, start).X_CO, truth_);
    bulk_found += bulk.angle_deg < 3 && bulk.shift_m < 0.002;
  }
  EXPECT_LT(bulk_found, 20) << "the starts are too easy to tell the two apart";
}

TEST_F(BracketTwoWay, RepeatsBitByBit) {
  const Pose start = Perturbed(truth_, Eigen::Vector3d::UnitX(), 8, {0.004, -0.005, 0.003});
  EXPECT_EQ(TwoWayIcp(cloud_, model_, start).X_CO.matrix(),
            TwoWayIcp(cloud_, model_, start).X_CO.matrix());
}

TEST_F(BracketTwoWay, PosesOutOfSightAndNansAreLeftAlone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(5, 0, 0.5), Eigen::Vector3d(0, 0, -0.5), Eigen::Vector3d(nan, 0, 0.5)}) {
    const TwoWayReport report = TwoWayIcp(cloud_, model_, Translation(p));
    EXPECT_TRUE(report.made_worse);
    EXPECT_EQ(report.overlap, 0);
    EXPECT_EQ(report.X_CO.translation().z(), p.z());
  }
}

TEST_F(BracketTwoWay, AsFinalRefinerItReportsTheFit) {
  PoseHypothesis h;
  h.X_CO = Perturbed(truth_, Eigen::Vector3d::UnitY(), 6, {0.004, 0.002, -0.003});
  const Pose start = h.X_CO;
  RefineTwoWay(cloud_, model_, h);
  EXPECT_TRUE(h.fit.refinement_kept);
  EXPECT_GT(h.fit.inlier_share, 0.6);
  EXPECT_GT(h.fit.conditioning, 0);
  ASSERT_TRUE(h.unrefined_X_CO.has_value());
  EXPECT_EQ(h.unrefined_X_CO->matrix(), start.matrix());

  // Nothing is there: the pose stays, and it says so.
  PoseHypothesis lost;
  lost.X_CO = Translation({0.3, 0, 0.4});
  RefineTwoWay(cloud_, model_, lost);
  EXPECT_FALSE(lost.fit.refinement_kept);
  EXPECT_FALSE(lost.unrefined_X_CO.has_value());
  EXPECT_EQ(lost.X_CO.matrix(), Translation({0.3, 0, 0.4}).matrix());
}

// A plate seen straight on shows one plane, on which surfaces alone can slide; its outline can not.
TEST(TwoWayIcp, OutlineHoldsWhatASurfaceDoesNot) {
  const auto plate = ObjectOf(BoxMesh({0.06, 0.06, 0.01}, Eigen::Vector3d::Zero()));
  const ModelPoints model = MakeModelPoints(*plate);
  const Pose truth = Translation({0, 0, 0.4});
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(plate->mesh_O, truth);
  scene.AddPlane({0, 0, -1}, {0, 0, 0.6});
  const OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  const Pose start = Translation({0.006, -0.005, 0.4});
  const auto across_m = [](const Pose& X) { return X.translation().head<2>().norm(); };
  EXPECT_LT(across_m(TwoWayIcp(cloud, model, start).X_CO), 0.0015);
  TwoWayIcpOptions surface_only;
  surface_only.outline_weight = 0;
  surface_only.cover_weight = 0;
  EXPECT_GT(across_m(TwoWayIcp(cloud, model, start, surface_only).X_CO), 0.004);
}

}  // namespace
}  // namespace pickbed
