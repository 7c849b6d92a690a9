#include "scenes/camera/depth_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

namespace pickbed::tests {
namespace {

using scenes::CameraIntrinsics;
using scenes::Image;
using ::testing::ElementsAre;
using ::testing::Pair;

TEST(ForEachDepthPoint, VisitsReadingsRowByRow) {
  const CameraIntrinsics camera(4, 3, 2, 2, 1, 1);
  Image<float> depth_m(4, 3);
  depth_m(3, 0) = 0.5f;
  depth_m(1, 1) = 2;
  depth_m(2, 1) = std::numeric_limits<float>::infinity();
  depth_m(0, 2) = -1;
  std::vector<std::pair<int, int>> pixels;
  std::vector<Eigen::Vector3d> points_C;
  const auto note = [&](int u, int v, const Eigen::Vector3d& p_C) {
    pixels.emplace_back(u, v);
    points_C.push_back(p_C);
  };
  ForEachDepthPoint(camera, depth_m, note);
  EXPECT_THAT(pixels, ElementsAre(Pair(3, 0), Pair(1, 1)));
  EXPECT_TRUE(points_C.at(0).isApprox(Eigen::Vector3d(0.5, -0.25, 0.5)));
  EXPECT_TRUE(points_C.at(1).isApprox(Eigen::Vector3d(0, 0, 2)));
}

TEST(ForEachDepthPoint, StrideBeginsWithFirst) {
  const CameraIntrinsics camera(5, 4, 2, 2, 1, 1);
  std::vector<std::pair<int, int>> pixels;
  ForEachDepthPoint(
      camera, Image<float>(5, 4, 1.0f),
      [&](int u, int v, const Eigen::Vector3d&) { pixels.emplace_back(u, v); }, 3, 1);
  EXPECT_THAT(pixels, ElementsAre(Pair(1, 1), Pair(4, 1)));
}

}  // namespace
}  // namespace pickbed::tests
