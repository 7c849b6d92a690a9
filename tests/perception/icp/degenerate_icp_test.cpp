// ICP steps of equations without a solution, and refinement in images of one pixel or line, of
// points without a volume and of poses at the camera.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "perception/icp/bidirectional_icp.h"
#include "perception/icp/normal_equations.h"
#include "perception/icp/pcl_icp.h"
#include "perception/icp/projected_points.h"
#include "perception/icp/projective_icp.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kNoLimit = std::numeric_limits<float>::infinity();

IcpEquations EquationsOf(int pairs, const Vector3f& turn, const Vector3f& direction,
                         float residual_m) {
  IcpEquations equations;
  for (int i = 0; i < pairs; ++i) equations.Add(turn, direction, residual_m, 1);
  return equations;
}

CenteredPose StartPose() { return {BracketPose().linear(), BracketPose().translation()}; }

bool IsStart(const CenteredPose& pose) {
  return pose.R_CO == StartPose().R_CO && pose.center_C == StartPose().center_C;
}

TEST(DegenerateIcpStep, FewerThanSixPairsLeaveThePose) {
  for (int pairs = 0; pairs < kMinIcpPairs; ++pairs) {
    CenteredPose pose = StartPose();
    const IcpEquations equations = EquationsOf(pairs, {1, 0, 0}, {0, 0, 1}, 0.001f);
    EXPECT_EQ(TakeStep(equations, 0.01, 0.01, 0.03, pose), IcpStatus::kTooFewCorrespondences);
    EXPECT_TRUE(IsStart(pose));
  }
}

TEST(DegenerateIcpStep, EquationsWithoutInformationMoveNothing) {
  for (const double damping : {0.0, 0.01}) {
    CenteredPose pose = StartPose();
    TakeStep(EquationsOf(10, Vector3f::Zero(), Vector3f::Zero(), 0), damping, 0.01, 0.03, pose);
    EXPECT_TRUE(IsStart(pose)) << damping;
  }
}

// All pairs have one normal, so the step is along it.
TEST(DegenerateIcpStep, PairsOnOnePlaneMoveAlongItsNormal) {
  CenteredPose pose = StartPose();
  const IcpEquations equations = EquationsOf(10, Vector3f::Zero(), {0, 0, 1}, 0.001f);
  EXPECT_EQ(TakeStep(equations, 1e-3, 0.01, 0.03, pose), IcpStatus::kRefined);
  EXPECT_LT((pose.center_C - StartPose().center_C - Vector3d(0, 0, 0.001)).norm(), 1e-5);
  EXPECT_EQ(pose.R_CO, StartPose().R_CO);
  EXPECT_NEAR(ReciprocalConditionNumber(equations), 0, 1e-6);
}

TEST(DegenerateIcpStep, ValuesThatAreNotFiniteLeaveThePose) {
  for (const float bad : {kNotANumber, kNoLimit}) {
    for (const IcpEquations& equations : {EquationsOf(10, {bad, 0, 0}, {0, 0, 1}, 0.001f),
                                          EquationsOf(10, {1, 0, 0}, {0, 0, bad}, 0.001f),
                                          EquationsOf(10, {1, 0, 0}, {0, 0, 1}, bad)}) {
      CenteredPose pose = StartPose();
      EXPECT_EQ(TakeStep(equations, 0.01, 0.01, 0.03, pose), IcpStatus::kStepTooLarge);
      EXPECT_TRUE(IsStart(pose));
      EXPECT_FALSE(std::isnan(ReciprocalConditionNumber(equations)));
    }
  }
  CenteredPose pose = StartPose();
  const IcpEquations turned = EquationsOf(10, {1, 0, 0}, {0, 0, 1}, 0.001f);
  EXPECT_EQ(TakeStep(turned, 0.01, 0.01, 0, pose), IcpStatus::kStepTooLarge);  // without a radius
  EXPECT_TRUE(IsStart(pose));
}

TEST(DegenerateIcpStep, ConditionIsBetweenZeroAndOne) {
  EXPECT_EQ(ReciprocalConditionNumber({}), 0);
  IcpEquations full;
  for (int axis = 0; axis < 3; ++axis) {
    full.Add(Vector3f::Unit(axis), Vector3f::Zero(), 0, 1);
    full.Add(Vector3f::Zero(), Vector3f::Unit(axis), 0, 1);
  }
  EXPECT_NEAR(ReciprocalConditionNumber(full), 1, 1e-6);
  for (const float scale : {1e-18f, 1e18f}) {
    const double condition =
        ReciprocalConditionNumber(EquationsOf(10, {scale, 0, 0}, {0, scale, 0}, 0));
    EXPECT_GE(condition, 0) << scale;
    EXPECT_LT(condition, 1e-5) << scale;
  }
}

TEST(DegenerateCenteredPose, ReturnsThePoseOfAnyModel) {
  for (const Vector3f& center_O : {Vector3f(0, 0, 0), Vector3f(1e4f, -1e4f, 1e4f)}) {
    ModelPoints model;
    model.center_O = center_O;
    for (const Pose& X_CO : {Pose::Identity(), BracketPose(), Translation({0, 0, -1})}) {
      const Pose back = ToPose(ToCentered(X_CO, model), model);
      EXPECT_LT((back.matrix() - X_CO.matrix()).norm(), 1e-9);
    }
  }
}

TEST(DegenerateProjection, OnePixelHoldsOnlyThePointsOnItsRay) {
  const CameraIntrinsics one_pixel(1, 1, 100, 100, 0, 0);
  IcpPoints points;
  const std::vector<Vector3f> given = {{0, 0, 0},        {0.5f, 0, 0},        {0, 0, -1},
                                       {0, 0, -2},       {0, 0, kNotANumber}, {kNotANumber, 0, 0},
                                       {kNoLimit, 0, 0}, {0, 0, kNoLimit},    {0, 1e38f, 0}};
  points.count = static_cast<int>(given.size());
  for (size_t i = 0; i < given.size(); ++i) {
    for (int k = 0; k < 3; ++k) points.points[k][i] = given[i][k];
  }
  CenteredPose pose;
  pose.center_C = {0, 0, 1};
  ProjectedPoints projected;
  ProjectPoints(points, pose, one_pixel, projected);
  EXPECT_EQ(projected.pixels[0], 0);
  // A point at an infinite distance has no place: 0 * infinity is not a number.
  for (int i = 1; i < points.count; ++i) EXPECT_EQ(projected.pixels[i], -1) << i;
  points.count = 0;
  projected.pixels.fill(7);
  ProjectPoints(points, pose, one_pixel, projected);
  EXPECT_EQ(projected.pixels[0], 7);
}

// The result of each kind of ICP.
std::vector<IcpResult> RefineByAll(const OrganizedCloud& cloud, const ModelPoints& model,
                                   const Pose& X_CO) {
  return {ProjectiveIcp(cloud, model, X_CO), BidirectionalIcp(cloud, model, X_CO),
          PclIcp(cloud).Refine(model, X_CO)};
}

void ExpectSound(const IcpResult& result) {
  EXPECT_TRUE(result.X_CO.matrix().allFinite());
  EXPECT_NEAR(result.X_CO.linear().determinant(), 1, 1e-9);
  EXPECT_GE(result.inlier_fraction, 0);
  EXPECT_LE(result.inlier_fraction, 1);
  EXPECT_TRUE(std::isfinite(result.rmse_m) && result.rmse_m >= 0);
  EXPECT_GE(result.reciprocal_condition_number, 0);
  EXPECT_LE(result.reciprocal_condition_number, 1);
  EXPECT_TRUE(std::isfinite(result.agreement) && std::isfinite(result.start_agreement));
}

TEST(DegenerateIcp, ImagesOfOnePixelOrLineLeaveThePose) {
  const ModelPoints model = MakeModelPoints(*ObjectOf(BracketMesh()), 200, 60);
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(300, 1), std::pair(1, 300)}) {
    RgbdFrame frame;
    frame.intrinsics = {width, height, 300, 300, 0.5 * (width - 1), 0.5 * (height - 1)};
    for (const float depth_m : {0.0f, 0.4f, kNotANumber}) {
      frame.depth_m = Image<float>(width, height, depth_m);
      const OrganizedCloud cloud = BuildCloud(frame, std::nullopt, kKeepAll);
      for (const Pose& X_CO : {Translation({0, 0, 0.4}), Pose::Identity()}) {
        for (const IcpResult& result : RefineByAll(cloud, model, X_CO)) {
          ExpectSound(result);
          EXPECT_EQ(result.status, IcpStatus::kTooFewCorrespondences) << width << depth_m;
          EXPECT_LT((result.X_CO.matrix() - X_CO.matrix()).norm(), 1e-9) << width << depth_m;
          EXPECT_EQ(result.inlier_fraction, 0) << width << depth_m;
        }
      }
    }
  }
}

// One point, or many points in one plane, cannot hold the pose.
TEST(DegenerateIcp, ModelsWithoutVolumeGiveSoundPoses) {
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane({0, 0, -1}, {0, 0, 0.4});
  const OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  const Pose facing = Perturbed(Translation({0, 0, 0.401}), Vector3d::UnitX(), 180, {0, 0, 0});
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    if (!test.has_area || Diameter(test.mesh) > 10) continue;
    const auto object = ObjectOf(test.mesh);
    for (const int points : {1, 100}) {
      const ModelPoints model = MakeModelPoints(*object, points, 60);
      for (const Pose& X_CO : {facing, Pose::Identity(), Translation({0, 0, -1})}) {
        for (const IcpResult& result : RefineByAll(cloud, model, X_CO)) {
          SCOPED_TRACE(test.name);
          ExpectSound(result);
          EXPECT_TRUE(points > 1 || result.status == IcpStatus::kTooFewCorrespondences);
        }
      }
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
