#include "perception/icp/bidirectional_icp.h"

#include <gtest/gtest.h>

#include <limits>

#include "perception/icp/projective_icp.h"
#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A bracket in front of a distant wall.
class BracketBidirectionalIcp : public ::testing::Test {
 protected:
  BracketBidirectionalIcp() : object_(ObjectOf(BracketMesh())), model_(MakeModelPoints(*object_)) {
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

TEST_F(BracketBidirectionalIcp, RecoversTenDegreesAndTenMillimetres) {
  Rng rng(2);
  int bulk_found = 0;
  for (int i = 0; i < 20; ++i) {
    const Pose start = Perturbed(truth_, rng.UnitVector(), 10, 0.010 * rng.UnitVector());
    const IcpResult result = BidirectionalIcp(cloud_, model_, start);
    const PoseGap gap = GapBetween(result.X_CO, truth_);
    EXPECT_LT(gap.angle_deg, 3) << i;
    EXPECT_LT(gap.shift_m, 0.002) << i;
    EXPECT_EQ(result.status, IcpStatus::kRefined) << i;
    EXPECT_GT(result.agreement, result.start_agreement) << i;
    EXPECT_GT(result.iterations, 0) << i;
    EXPECT_GT(result.inlier_fraction, 0.7) << i;
    EXPECT_LT(result.rmse_m, 0.002) << i;  // noise of 1 mm
    EXPECT_GT(result.reciprocal_condition_number, 0.005) << i;
    const PoseGap bulk = GapBetween(ProjectiveIcp(cloud_, model_, start).X_CO, truth_);
    bulk_found += bulk.angle_deg < 3 && bulk.shift_m < 0.002;
  }
  EXPECT_LT(bulk_found, 20) << "the starts are too easy to distinguish the two methods";
}

TEST_F(BracketBidirectionalIcp, RepeatedRunsAreIdentical) {
  const Pose start = Perturbed(truth_, Eigen::Vector3d::UnitX(), 8, {0.004, -0.005, 0.003});
  EXPECT_EQ(BidirectionalIcp(cloud_, model_, start).X_CO.matrix(),
            BidirectionalIcp(cloud_, model_, start).X_CO.matrix());
}

TEST_F(BracketBidirectionalIcp, PosesOutOfViewAndNansAreUnchanged) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(5, 0, 0.5), Eigen::Vector3d(0, 0, -0.5), Eigen::Vector3d(nan, 0, 0.5)}) {
    const IcpResult result = BidirectionalIcp(cloud_, model_, Translation(p));
    EXPECT_EQ(result.status, IcpStatus::kTooFewCorrespondences);
    EXPECT_EQ(result.iterations, 0);
    EXPECT_EQ(result.inlier_fraction, 0);
    EXPECT_EQ(result.X_CO.translation().z(), p.z());
  }
}

// With a large weight, the cover residuals of a neighbour pull the true pose away from the surface.
TEST_F(BracketBidirectionalIcp, WorsePoseIsDiscarded) {
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(object_->mesh_O, truth_);
  scene.AddMesh(object_->mesh_O, Translation({0.012, 0.008, 0}) * truth_);
  scene.AddPlane({0, 0, -1}, {0, 0, 1.0});
  const OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  BidirectionalIcpOptions options;
  options.restart_rad = 0;
  options.cover_weight = 50;
  const IcpResult result = BidirectionalIcp(cloud, model_, truth_, options);
  EXPECT_EQ(result.status, IcpStatus::kWorse);
  EXPECT_EQ(result.agreement, result.start_agreement);
  EXPECT_EQ(result.iterations, 0);
  EXPECT_EQ(result.X_CO.matrix(), truth_.matrix());
}

// A plate seen frontally shows one plane. Surface residuals allow it to slide; outline residuals do
// not.
TEST(BidirectionalIcp, OutlinePreventsSliding) {
  const auto plate = ObjectOf(BoxMesh({0.06, 0.06, 0.01}, Eigen::Vector3d::Zero()));
  const ModelPoints model = MakeModelPoints(*plate);
  const Pose truth = Translation({0, 0, 0.4});
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(plate->mesh_O, truth);
  scene.AddPlane({0, 0, -1}, {0, 0, 0.6});
  const OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  const Pose start = Translation({0.006, -0.005, 0.4});
  const auto across_m = [](const Pose& X) { return X.translation().head<2>().norm(); };
  EXPECT_LT(across_m(BidirectionalIcp(cloud, model, start).X_CO), 0.0015);
  BidirectionalIcpOptions surface_only;
  surface_only.outline_weight = 0;
  surface_only.cover_weight = 0;
  EXPECT_GT(across_m(BidirectionalIcp(cloud, model, start, surface_only).X_CO), 0.004);
}

}  // namespace
}  // namespace pickbed::tests
