// Camera geometry of images without pixels, with one pixel or without readings, and pictures of
// degenerate meshes.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenes/camera/depth_points.h"
#include "scenes/camera/filled_depth.h"
#include "scenes/camera/footprint.h"
#include "scenes/camera/mesh_raster.h"
#include "tests/scenes/geometry/degenerate_meshes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kNoLimit = std::numeric_limits<float>::infinity();
const CameraIntrinsics kOnePixel{1, 1, 100, 100, 0, 0};

bool IsOneOf(float value, float a, float b) { return value == a || value == b; }

int ReadingsOf(const CameraIntrinsics& k, const Image<float>& depth_m, int stride, int first) {
  int readings = 0;
  ForEachDepthPoint(
      k, depth_m,
      [&](int u, int v, const Vector3d& p_C) {
        ++readings;
        EXPECT_TRUE(depth_m.Contains(u, v));
        EXPECT_TRUE(p_C.allFinite());
        EXPECT_EQ(static_cast<float>(p_C.z()), depth_m(u, v));
      },
      stride, first);
  return readings;
}

TEST(DegenerateDepthPoints, OnlyReadingsAreVisited) {
  EXPECT_EQ(ReadingsOf(kOnePixel, {}, 1, 0), 0);
  for (const float bad : {0.0f, -1.0f, kNaN, kNoLimit, -kNoLimit}) {
    EXPECT_FALSE(IsReading(bad));
    EXPECT_EQ(ReadingsOf(kOnePixel, Image<float>(1, 1, bad), 1, 0), 0) << bad;
  }
  for (const float good : {1e-42f, 1.0f, std::numeric_limits<float>::max()}) {
    EXPECT_TRUE(IsReading(good));
    EXPECT_EQ(ReadingsOf(kOnePixel, Image<float>(1, 1, good), 1, 0), 1) << good;
    EXPECT_EQ(ReadingsOf(kOnePixel, Image<float>(1, 1, good), 1000, 0), 1) << good;
    EXPECT_EQ(ReadingsOf(kOnePixel, Image<float>(1, 1, good), 1, 1), 0) << good;
  }
}

TEST(DegenerateBackProjection, InvertsProjectionForOnePixel) {
  EXPECT_EQ(BackProject(kOnePixel, 0.25, -0.5, 0), Vector3d::Zero());
  for (const double depth_m : {1e-30, 1.0, 1e30}) {
    const Eigen::Vector2d at_px = Project(kOnePixel, BackProject(kOnePixel, 0.25, -0.5, depth_m));
    EXPECT_NEAR(at_px.x(), 0.25, 1e-12) << depth_m;
    EXPECT_NEAR(at_px.y(), -0.5, 1e-12) << depth_m;
  }
}

TEST(DegenerateFilledDepth, GapsAreInfiniteOrTakeAReading) {
  EXPECT_TRUE(FilledDepth({}).empty());
  for (const float bad : {0.0f, -1.0f, kNaN, kNoLimit}) {
    EXPECT_EQ(FilledDepth(Image<float>(1, 1, bad))(0, 0), kNoLimit) << bad;
    for (const auto& [width, height] : {std::pair(5, 1), std::pair(1, 5)}) {
      Image<float> line(width, height, bad);
      line.data()[2] = 0.5f;
      EXPECT_EQ(FilledDepth(line), Image<float>(width, height, 0.5f)) << bad;
    }
    Image<float> square(3, 3, bad);
    square(0, 0) = 0.5f;
    const Image<float> filled = FilledDepth(square);
    for (const float depth_m : filled.pixels()) EXPECT_TRUE(IsOneOf(depth_m, 0.5f, kNoLimit));
    EXPECT_EQ(filled(2, 2), kNoLimit) << bad;
  }
  EXPECT_EQ(FilledDepth(Image<float>(1, 1, 0.5f))(0, 0), 0.5f);
}

TEST(DegenerateFootprint, APointIsOnePixel) {
  const Bounds point{{0, 0, 1}, {0, 0, 1}};
  const Footprint in_front = FootprintOf(point, Pose::Identity(), kOnePixel);
  EXPECT_EQ(in_front.min_px, Eigen::Vector2d::Zero());
  EXPECT_EQ(in_front.max_px, Eigen::Vector2d::Zero());
  EXPECT_TRUE(in_front.Overlaps(kOnePixel) && in_front.IsInside(kOnePixel));
  const Footprint beside = FootprintOf(point, Translation({1, 0, 0}), kOnePixel);
  EXPECT_FALSE(beside.Overlaps(kOnePixel) || beside.IsInside(kOnePixel));
  // The plane of the camera has no image.
  for (const double z_m : {-1.0, -2.0, 0.99 * kNearestDrawn_m - 1}) {
    const Footprint behind = FootprintOf(point, Translation({0, 0, z_m}), kOnePixel);
    EXPECT_FALSE(behind.in_front || behind.Overlaps(kOnePixel) || behind.IsInside(kOnePixel));
  }
}

TEST(DegenerateFootprint, DrawnBoxesAreInTheImage) {
  const CameraIntrinsics k(4, 3, 100, 100, 1.5, 1);
  const Bounds point{{0, 0, 0}, {0, 0, 0}};
  for (const Vector3d& p_C : {Vector3d(0, 0, 1), Vector3d(1e9, -1e9, 1), Vector3d(1e300, 0, 0.1),
                              Vector3d(0, 0, 0), Vector3d(0, 0, -1)}) {
    DrawnBox drawn(k);
    drawn.Include(FootprintOf(point, Translation(p_C), k));
    const ImageBox box = drawn.box();
    EXPECT_GE(box.x, 0);
    EXPECT_GE(box.y, 0);
    EXPECT_GE(box.width, 1);
    EXPECT_GE(box.height, 1);
    EXPECT_LE(box.x + box.width, 4);
    EXPECT_LE(box.y + box.height, 3);
    EXPECT_TRUE(p_C.z() > 0 || box.width * box.height == 12);
  }
}

// The part of a picture that a mesh covers, and the limits of its depth.
struct Covered {
  int pixels = 0;
  float nearest_m = kNoLimit, farthest_m = 0;
};

Covered Draw(const TriangleMesh& mesh, const Pose& X_CO, const CameraIntrinsics& k) {
  FaceRaster raster;
  raster.Begin(k, {0, 0, k.width(), k.height()});
  raster.Draw(RasterMesh(mesh), X_CO, false);
  Covered covered;
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) {
      const float inverse = raster.InverseDepths(y)[x];
      if (inverse == 0) continue;
      ++covered.pixels;
      covered.nearest_m = std::min(covered.nearest_m, 1 / inverse);
      covered.farthest_m = std::max(covered.farthest_m, 1 / inverse);
      const RasterFace& face = raster.faces()[raster.FacesAt(y)[x]];
      for (const float value : face.at_origin) EXPECT_TRUE(std::isfinite(value));
    }
  }
  raster.Clean();
  raster.Begin(k, {0, 0, k.width(), k.height()});
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) EXPECT_EQ(raster.InverseDepths(y)[x], 0);
  }
  return covered;
}

TEST(DegeneratePictures, FacesWithAreaAreDrawnAtTheirDepth) {
  const CameraIntrinsics k(64, 48, 60, 60, 31.5, 23.5);
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    const Bounds bounds = MeshBounds(test.mesh);
    const double distance_m = std::max(1e-9, 2 * bounds.size().norm());
    const Vector3d shift = Vector3d(0, 0, distance_m) - bounds.center();
    const Covered covered = Draw(test.mesh, Translation(shift), k);
    const bool is_wide = test.has_area && test.name != "a sliver";
    EXPECT_EQ(covered.pixels > 0, is_wide) << test.name;
    if (covered.pixels == 0) continue;
    // Positions are in single precision.
    const double slack_m = 1e-4 * distance_m + 1e-6 * bounds.max.norm();
    EXPECT_GE(covered.nearest_m, bounds.min.z() + shift.z() - slack_m) << test.name;
    EXPECT_LE(covered.farthest_m, bounds.max.z() + shift.z() + slack_m) << test.name;
  }
}

TEST(DegeneratePictures, OnePixelShowsTheNearestFace) {
  const TriangleMesh box = BoxShape({0.1, 0.1, 0.1});
  const Covered covered = Draw(box, Translation({0, 0, 0.55}), kOnePixel);
  EXPECT_EQ(covered.pixels, 1);
  EXPECT_NEAR(covered.nearest_m, 0.5f, 1e-6f);
  EXPECT_EQ(Draw(box, Translation({1, 0, 0.55}), kOnePixel).pixels, 0);
  EXPECT_EQ(Draw({}, Translation({0, 0, 0.55}), kOnePixel).pixels, 0);
}

}  // namespace
}  // namespace pickbed::tests
