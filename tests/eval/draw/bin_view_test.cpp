#include "eval/draw/bin_view.h"

#include <gtest/gtest.h>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

Camera CameraAbove() {
  return {CameraIntrinsics{}, LookAt({0, -0.12, 0.85}, {0, 0, 0.03}, Eigen::Vector3d::UnitY())};
}

std::vector<Eigen::Vector3d> RimCorners(const Bin& bin) {
  std::vector<Eigen::Vector3d> corners;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      corners.emplace_back(x * (0.5 * bin.inner_size_m.x() + bin.wall_m),
                           y * (0.5 * bin.inner_size_m.y() + bin.wall_m), bin.inner_size_m.z());
    }
  }
  return corners;
}

TEST(BinRegion, ContainsTheRimAndLittleElse) {
  const Camera camera = CameraAbove();
  const Bin bin;
  const ImageBox region = BinRegion(camera, bin);
  for (const Eigen::Vector3d& corner_W : RimCorners(bin)) {
    const Eigen::Vector2d p = Project(camera.intrinsics, camera.X_CW() * corner_W);
    EXPECT_GT(p.x(), region.x + 5);
    EXPECT_LT(p.x(), region.x + region.width - 6);
    EXPECT_GT(p.y(), region.y + 5);
    EXPECT_LT(p.y(), region.y + region.height - 6);
  }
  EXPECT_LT(region.width, 500);
  EXPECT_LT(region.height, 400);
}

TEST(BinRegion, StaysInTheImage) {
  const Camera near{CameraIntrinsics{},
                    LookAt({0, -0.05, 0.4}, {0, 0, 0}, Eigen::Vector3d::UnitY())};
  const ImageBox region = BinRegion(near, Bin());
  EXPECT_GE(region.x, 0);
  EXPECT_GE(region.y, 0);
  EXPECT_LE(region.x + region.width, 640);
  EXPECT_LE(region.y + region.height, 480);
}

TEST(BinRegion, IsTheWholeImageIfTheBinIsNotInView) {
  const Camera away{CameraIntrinsics{}, LookAt({0, 0, 1}, {0, 0, 2}, Eigen::Vector3d::UnitY())};
  const ImageBox region = BinRegion(away, Bin());
  EXPECT_EQ(region.width, 640);
  EXPECT_EQ(region.height, 480);
}

// Pixel (u, v) of the image covers the pixels around 2 (u - x) + 0.5 of a window in twice its size.
TEST(WindowOf, ShowsTheRegionInItsSize) {
  const Camera camera = CameraAbove();
  const ImageBox region{100, 50, 300, 200};
  const Camera window = WindowOf(camera, region, 600);
  EXPECT_EQ(window.intrinsics.width(), 600);
  EXPECT_EQ(window.intrinsics.height(), 400);
  const Eigen::Vector3d p_C = camera.X_CW() * Eigen::Vector3d(0.05, 0.02, 0.04);
  const Eigen::Vector2d p = Project(camera.intrinsics, p_C);
  const Eigen::Vector2d expected = 2 * (p - Eigen::Vector2d(100, 50)) + Eigen::Vector2d(0.5, 0.5);
  EXPECT_LT((Project(window.intrinsics, p_C) - expected).norm(), 1e-9);
}

TEST(Cropped, HasThePixelsOfTheRegion) {
  Image<uint16_t> image(5, 4);
  image(3, 2) = 7;
  const Image<uint16_t> cropped = Cropped(image, {2, 1, 3, 2});
  EXPECT_EQ(cropped.width(), 3);
  EXPECT_EQ(cropped.height(), 2);
  EXPECT_EQ(cropped(1, 1), 7);
}

}  // namespace
}  // namespace pickbed::tests
