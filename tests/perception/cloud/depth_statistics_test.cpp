#include "perception/cloud/depth_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/verify/depth_evidence.h"
#include "scenes/base/random.h"
#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A plane that faces the camera, with independent noise that grows with z^2.
Image<float> NoisyPlane(double sigma_m, float z_m) {
  Rng rng(5);
  Image<float> depth_m(160, 120);
  for (float& z : depth_m.pixels()) {
    z = z_m + static_cast<float>(sigma_m * z_m * z_m * rng.Normal());
  }
  return depth_m;
}

TEST(MeasureDepth, FindsTheNoiseOfAPlane) {
  for (const double sigma_m : {0.001, 0.003}) {
    for (const float z_m : {0.7f, 1.4f}) {
      EXPECT_NEAR(MeasureDepth(NoisyPlane(sigma_m, z_m)).noise_at_1m_m, sigma_m, 0.06 * sigma_m);
    }
  }
}

// A slanted plane in steps of 6 mm. Most neighbours are equal, so that the noise seems to be zero.
TEST(MeasureDepth, FindsTheStepOfQuantizedDepth) {
  constexpr double kStep_m = 0.006;
  Image<float> depth_m(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      depth_m(x, y) = static_cast<float>(kStep_m * std::round((1 + 0.0004 * x) / kStep_m));
    }
  }
  const DepthStatistics found = MeasureDepth(depth_m);
  EXPECT_EQ(found.noise_at_1m_m, 0);
  EXPECT_NEAR(found.step_at_1m_m, kStep_m / (1.064 * 1.064), 0.15 * kStep_m);
  EXPECT_NEAR(found.Error_m(), found.step_at_1m_m / std::sqrt(12.0), 1e-9);
}

TEST(MeasureDepth, CountsHolesBetweenReadingsOnly) {
  Image<float> depth_m(200, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 50; x < 150; ++x) depth_m(x, y) = x % 4 == 1 ? 0.0f : 1.0f;
  }
  EXPECT_NEAR(MeasureDepth(depth_m).hole_share, 0.25, 0.01);
}

TEST(MeasureDepth, IsZeroWithoutReadings) {
  for (const Image<float>& empty : {Image<float>(), Image<float>(20, 20)}) {
    const DepthStatistics found = MeasureDepth(empty);
    EXPECT_EQ(found.Error_m(), 0);
    EXPECT_EQ(found.hole_share, 0);
    EXPECT_EQ(ErrorScale(found), 1);
  }
}

// Within the range of the training, nothing changes.
TEST(ErrorScale, GrowsBeyondTheTraining) {
  EXPECT_EQ(ErrorScale(MeasureDepth(NoisyPlane(0.003, 1))), 1);
  EXPECT_NEAR(ErrorScale(MeasureDepth(NoisyPlane(0.008, 1))), 2, 0.15);
  EXPECT_EQ(ErrorScale({.noise_at_1m_m = 1}), 4);
}

// The band of the evidence follows the noise: most readings of a noisy surface agree with its pose.
TEST(ErrorScale, WidensTheBandOfTheEvidence) {
  SyntheticDepth scene(SmallCamera());
  const TriangleMesh box = BoxMesh({0.1, 0.1, 0.02}, Eigen::Vector3d::Zero());
  const Pose X_CO = Translation({0, 0, 0.9});
  scene.AddMesh(box, X_CO);
  RgbdFrame frame = scene.frame();
  Rng rng(7);
  for (float& z : frame.depth_m.pixels()) {
    if (z > 0) z += static_cast<float>(0.012 * z * z * rng.Normal());
  }
  ObjectModel model;
  model.mesh_O = box;
  model.diameter_m = MeshBounds(box).size().norm();
  const DepthEvidenceOf evidence(model);
  EvidenceScratch scratch;
  OrganizedCloud cloud = BuildCloud(frame, std::nullopt, kKeepAll);
  ASSERT_GT(cloud.error_scale, 2);
  const DepthEvidence wide = evidence(cloud, X_CO, scratch);
  cloud.error_scale = 1;
  const DepthEvidence narrow = evidence(cloud, X_CO, scratch);
  EXPECT_LT(wide.violated + wide.hidden, 0.4 * (narrow.violated + narrow.hidden));
}

}  // namespace
}  // namespace pickbed::tests
