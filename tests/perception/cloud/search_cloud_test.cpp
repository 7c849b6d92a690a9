#include "perception/cloud/search_cloud.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/camera/depth_points.h"
#include "tests/support/layer.h"
#include "tests/support/synthetic_depth.h"

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
  ASSERT_EQ(binned.depth_m.width(), 5);
  ASSERT_EQ(binned.depth_m.height(), 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 5; ++x) {
      const float z = binned.depth_m(x, y);
      const bool near = std::abs(z - 0.9f) < 1e-6f, far = std::abs(z - 1.0f) < 1e-6f;
      EXPECT_TRUE(x < 2 ? near : x > 2 ? far : near || far) << x << " " << z;
    }
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

TEST(BinnedFrame, AveragesNoiseAndColor) {
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

// A plane with a sphere, noise, holes of one pixel and larger, a depth that is not finite, and
// random colors.
RgbdFrame NoisyFrame() {
  const CameraIntrinsics k(90, 61, 300, 310, 43.2, 31.7);
  SyntheticDepth scene(k);
  scene.AddPlane({0, 0.3, -1}, {0, 0, 0.8});
  scene.AddSphere({0, 0, 0.6}, 0.05);
  Rng rng(7);
  RgbdFrame frame = WithNoise(scene.frame(), 0.001, rng);
  for (int i = 0; i < 200; ++i) frame.depth_m(rng.Index(90), rng.Index(61)) = 0;
  for (int x = 20; x < 30; ++x) frame.depth_m(x, 40) = frame.depth_m(x, 41) = 0;
  frame.depth_m(50, 30) = std::numeric_limits<float>::infinity();
  frame.depth_m(60, 20) = 1e38f;
  frame.color = Image<Rgb8>(90, 61);
  for (Rgb8& pixel : frame.color.pixels()) {
    const auto channel = [&] { return static_cast<uint8_t>(rng.Index(256)); };
    pixel = {channel(), channel(), channel()};
  }
  return frame;
}

// A bin of 0.4 x 0.4 m whose floor is 0.9 m below the camera.
KnownBackground BinBelow() {
  KnownBackground background;
  background.bin.inner_size_m = {0.4, 0.4, 0.1};
  background.X_CB.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  background.X_CB.translation().z() = 0.9;
  return background;
}

void ExpectSameForThreads(const RgbdFrame& frame, const std::optional<KnownBackground>& background,
                          const Image<uint8_t>* region) {
  for (const int factor : {1, 2}) {
    const OrganizedCloud one = SearchCloud(frame, background, factor, region);
    for (const int threads : {2, 3, 8}) {
      const OrganizedCloud several = SearchCloud(frame, background, factor, region, true, threads);
      EXPECT_EQ(several.depth_m, one.depth_m);
      EXPECT_EQ(several.color, one.color);
      EXPECT_EQ(several.points_C, one.points_C);
      EXPECT_EQ(several.normals_C, one.normals_C);
      EXPECT_EQ(several.foreground, one.foreground);
      EXPECT_EQ(several.foreground_pixels, one.foreground_pixels);
      EXPECT_EQ(several.edges.du, one.edges.du);
      EXPECT_EQ(several.edges.dv, one.edges.dv);
    }
  }
}

TEST(SearchCloud, SameBytesForAnyNumberOfThreads) {
  const RgbdFrame frame = NoisyFrame();
  Image<uint8_t> left(90, 61), none(90, 61);
  for (int y = 0; y < 61; ++y) std::fill_n(left.row(y), 40, 1);
  ASSERT_GT(SearchCloud(frame, std::nullopt, 2).foreground_pixels.size(), 20u);
  ASSERT_GT(SearchCloud(frame, BinBelow(), 2).foreground_pixels.size(), 20u);
  for (const std::optional<KnownBackground>& background :
       {std::optional<KnownBackground>(), std::optional(BinBelow())}) {
    ExpectSameForThreads(frame, background, nullptr);
    ExpectSameForThreads(frame, background, &left);
    ExpectSameForThreads(frame, background, &none);
  }
}

// Binning reduces depth and color. Edges are found in the whole color image.
TEST(SearchCloud, EdgesAreFoundInTheWholeImage) {
  const RgbdFrame frame = NoisyFrame();
  const OrganizedCloud cloud = SearchCloud(frame, std::nullopt, 2);
  EXPECT_EQ(cloud.color, BinnedFrame(frame, 2).color);
  EXPECT_EQ(cloud.edges.du, FindColorEdges(frame.intrinsics, frame.color).du);
  EXPECT_EQ(cloud.edges.intrinsics.width(), 90);
}

}  // namespace
}  // namespace pickbed::tests
