#include "grasp/cloud/observed_surface.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/grasp/cloud/cloud_scene.h"

namespace pickbed::tests {
namespace {

ObservedSurface SurfaceOf(const CloudScene& scene, const RgbdFrame& frame) {
  return ObserveSurface(frame, scene.camera().X_WC(), BinPlacement{scene.bin(), Pose::Identity()});
}

TEST(ObservedSurface, ApartObjectsAreSegmentsAndTheBinIsBackground) {
  CloudScene scene;
  scene.AddBox({0.05, 0.03, 0.03}, OnFloor(-0.06, 0, 0.03, 0.4));
  scene.AddBox({0.03, 0.03, 0.04}, OnFloor(0.06, 0.02, 0.04, 0));
  const ObservedSurface surface = SurfaceOf(scene, scene.frame());
  ASSERT_EQ(surface.segments.size(), 2u);
  for (const SurfaceSegment& segment : surface.segments) {
    const bool is_left = segment.center_B.x() < 0;
    EXPECT_NEAR(segment.center_B.x(), is_left ? -0.06 : 0.06, 0.006);
    EXPECT_NEAR(segment.top_m, is_left ? 0.03 : 0.04, 0.001);
  }
  for (const SurfacePoint& point : surface.points) {
    if (point.segment == kBackground) continue;
    EXPECT_GT(point.p_B.z(), 0.0005) << "the floor is no object";
  }
}

// Single readings before a face would look like needles of the object.
TEST(ObservedSurface, OutliersCountAsNoReading) {
  CloudScene scene;
  scene.AddBox({0.08, 0.08, 0.03}, OnFloor(0, 0, 0.03, 0));
  RgbdFrame frame = scene.frame();
  const CameraIntrinsics& k = frame.intrinsics;
  const Eigen::Vector3d top_C = scene.camera().X_CW() * Eigen::Vector3d(0, 0, 0.03);
  const int u = static_cast<int>(k.fx() * top_C.x() / top_C.z() + k.cx());
  const int v = static_cast<int>(k.fy() * top_C.y() / top_C.z() + k.cy());
  frame.depth_m(u, v) -= 0.012f;
  const auto highest_m = [&](const RgbdFrame& seen, int min_neighbors) {
    SurfaceOptions options;
    options.min_neighbors = min_neighbors;
    const ObservedSurface surface = ObserveSurface(
        seen, scene.camera().X_WC(), BinPlacement{scene.bin(), Pose::Identity()}, options);
    double top_m = 0;
    for (const SurfacePoint& point : surface.points) {
      if (point.segment >= 0) top_m = std::max<double>(top_m, point.p_B.z());
    }
    return top_m;
  };
  EXPECT_GT(highest_m(frame, 0), 0.036);
  EXPECT_LT(highest_m(frame, SurfaceOptions().min_neighbors), 0.031);
  // A face keeps its points.
  SurfaceOptions all;
  all.min_neighbors = 0;
  const auto unfiltered = ObserveSurface(scene.frame(), scene.camera().X_WC(),
                                         BinPlacement{scene.bin(), Pose::Identity()}, all);
  EXPECT_GT(SurfaceOf(scene, scene.frame()).points.size(), 0.99 * unfiltered.points.size());
}

// The border of the unknown space runs from the top edge to the floor along the viewing ray.
TEST(ObservedSurface, ShadowRunsAlongTheViewingRays) {
  CloudScene scene({0, -0.4, 0.5});
  scene.AddBox({0.05, 0.02, 0.05}, OnFloor(0, 0, 0.05, 0));
  const ObservedSurface surface = SurfaceOf(scene, scene.frame());
  const Eigen::Vector3d eye = scene.camera().X_WC().translation(), edge(0, 0.01, 0.05);
  const Eigen::Vector3d floor = eye + (edge - eye) * (eye.z() / (eye.z() - edge.z()));
  int in_shadow = 0;
  for (const SurfacePoint& point : surface.points) {
    if (point.segment != kShadow || std::abs(point.p_B.x()) > 0.015 || point.p_B.y() < 0.012) {
      continue;
    }
    if (point.p_B.y() > floor.y() - 0.003 || point.p_B.z() < 0.004) continue;
    ++in_shadow;
    // The ray through the edge has this height here.
    const double share = (point.p_B.y() - edge.y()) / (floor.y() - edge.y());
    EXPECT_NEAR(point.p_B.z(), edge.z() * (1 - share), 0.003);
  }
  EXPECT_GT(in_shadow, 100);
}

// A gap of readings at an object gets the nearest depth at its ends, so that it is never free.
TEST(ObservedSurface, GapsAreNotFree) {
  CloudScene scene;
  scene.AddBox({0.04, 0.04, 0.04}, OnFloor(0, 0, 0.04, 0));
  RgbdFrame gaps = scene.frame();
  const Eigen::Vector2d edge =
      Project(gaps.intrinsics, scene.camera().X_CW() * Eigen::Vector3d(0.02, 0, 0.04));
  const int u0 = static_cast<int>(edge.x());
  for (int v = 0; v < gaps.depth_m.height(); ++v) {
    for (int u = u0 - 2; u < u0 + 10; ++u) gaps.depth_m(u, v) = 0;
  }
  const ObservedSurface surface = SurfaceOf(scene, gaps);
  const auto highest = [&](double x_m) {
    float top = -1;
    for (const SurfacePoint& point : surface.points) {
      if (std::abs(point.p_B.x() - x_m) > 0.001 || std::abs(point.p_B.y()) > 0.005) continue;
      top = std::max(top, point.p_B.z());
      EXPECT_TRUE(point.p_B.z() < 0.01 || point.segment == kShadow);
    }
    return top;
  };
  EXPECT_NEAR(highest(0.024), 0.04, 0.002) << "beside the box, in the gap";
  EXPECT_LT(highest(0.04), 0.002) << "beside the gap";
}

// A face along the viewing rays has large steps between its rows of pixels.
TEST(ObservedSurface, SteepFaceBelongsToItsObject) {
  CloudScene scene;
  scene.AddBox({0.07, 0.03, 0.04}, OnFloor(0.02, -0.03, 0.04, 0));
  EXPECT_EQ(SurfaceOf(scene, scene.frame()).segments.size(), 1u);
  SurfaceOptions without;
  without.fragment_px = 0;
  EXPECT_GT(ObserveSurface(scene.frame(), scene.camera().X_WC(),
                           BinPlacement{scene.bin(), Pose::Identity()}, without)
                .segments.size(),
            1u);
}

}  // namespace
}  // namespace pickbed::tests
