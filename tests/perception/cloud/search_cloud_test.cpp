#include "perception/cloud/search_cloud.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/camera/depth_points.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

TEST(BinningFor, KeepsTheSmallestObjectAboveTheSearchDiameter) {
  const CameraIntrinsics k(1224, 1024, 1800, 1800, 611.5, 511.5);
  EXPECT_EQ(BinningFor(k, 1.1, 0.103), 2);  // 168 px
  EXPECT_EQ(BinningFor(k, 1.1, 0.090), 1);  // 147 px, half of it is too few
  EXPECT_EQ(BinningFor(k, 1.1, 0.010), 1);
}

RgbdFrame SlantedPlane() {
  RgbdFrame frame;
  frame.intrinsics = {90, 60, 300, 310, 43.2, 31.7};
  frame.depth_m = Image<float>(90, 60);
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, -1).normalized();
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 90; ++x) {
      const Eigen::Vector3d ray((x - 43.2) / 300, (y - 31.7) / 310, 1);
      frame.depth_m(x, y) = static_cast<float>(-0.8 / normal.dot(ray) * 0.9);
    }
  }
  return frame;
}

TEST(BinnedFrame, PointsOfAPlaneStayOnThePlane) {
  const RgbdFrame frame = SlantedPlane();
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, -1).normalized();
  for (const int factor : {2, 3}) {
    const RgbdFrame binned = BinnedFrame(frame, factor);
    ASSERT_EQ(binned.depth_m.width(), 90 / factor);
    ASSERT_EQ(binned.intrinsics.height(), 60 / factor);
    ForEachDepthPoint(binned.intrinsics, binned.depth_m, [&](int, int, const Eigen::Vector3d& p_C) {
      EXPECT_NEAR(normal.dot(p_C), -0.72, 1e-4);
    });
  }
}

TEST(BinnedFrame, AStepStaysAStep) {
  RgbdFrame frame;
  frame.intrinsics = {10, 10, 300, 300, 4.5, 4.5};
  frame.depth_m = Image<float>(10, 10, 0.9f);
  for (int y = 0; y < 10; ++y) {
    for (int x = 5; x < 10; ++x) frame.depth_m(x, y) = 1.0f;
  }
  const RgbdFrame binned = BinnedFrame(frame, 2);  // the step is inside the third block
  for (const float z : binned.depth_m.pixels()) {
    EXPECT_TRUE(std::abs(z - 0.9f) < 1e-6f || std::abs(z - 1.0f) < 1e-6f) << z;
  }
}

TEST(BinnedFrame, ABlockThatIsMostlyHolesIsAHole) {
  RgbdFrame frame;
  frame.intrinsics = {4, 2, 300, 300, 1.5, 0.5};
  frame.depth_m = Image<float>(4, 2, 1.0f);
  frame.depth_m(0, 0) = frame.depth_m(1, 0) = frame.depth_m(0, 1) = 0;  // 1 of 4 left
  frame.depth_m(2, 0) = std::nanf("");                                  // 3 of 4 left
  const RgbdFrame binned = BinnedFrame(frame, 2);
  EXPECT_EQ(binned.depth_m(0, 0), 0);
  EXPECT_NEAR(binned.depth_m(1, 0), 1.0, 1e-6);
}

TEST(BinnedFrame, AveragesNoiseAndColour) {
  RgbdFrame frame;
  frame.intrinsics = {2, 2, 300, 300, 0.5, 0.5};
  frame.depth_m = Image<float>(2, 2);
  frame.color = Image<Rgb8>(2, 2);
  const float noise_m[] = {0.001f, -0.001f, 0.002f, -0.002f};
  for (int i = 0; i < 4; ++i) {
    frame.depth_m.data()[i] = 1 + noise_m[i];
    frame.color.data()[i] = {static_cast<uint8_t>(10 * i), 100, 200};
  }
  const RgbdFrame binned = BinnedFrame(frame, 2);
  EXPECT_NEAR(binned.depth_m(0, 0), 1.0, 1e-6);
  EXPECT_EQ(binned.color(0, 0), (Rgb8{15, 100, 200}));
}

}  // namespace
}  // namespace pickbed::tests
