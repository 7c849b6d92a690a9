#include "perception/candidates/search_pixels.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/analytic_clouds.h"

namespace pickbed::tests {
namespace {

constexpr double kDiameter_m = 0.1;

// A wall across the view that is 1 m away, and a plate of 8 x 8 cm 5 cm before it.
OrganizedCloud WallAndPlate() {
  return AnalyticCloud([](const Eigen::Vector3d& ray) {
    constexpr double kPlate_m = 0.95, kHalf_m = 0.04;
    const bool is_plate = (kPlate_m * ray.head<2>()).cwiseAbs().maxCoeff() < kHalf_m;
    return SurfacePoint{is_plate ? kPlate_m : 1.0, -Eigen::Vector3d::UnitZ()};
  });
}

bool IsPlate(const OrganizedCloud& cloud, int pixel) { return cloud.points_C[pixel].z() < 0.97f; }

TEST(SearchPixels, LargeSurfaceIsSearchedSparsely) {
  const OrganizedCloud cloud = WallAndPlate();
  const std::vector<int> searched = SearchPixels(cloud, kDiameter_m);
  const auto is_plate = [&](int pixel) { return IsPlate(cloud, pixel); };
  const auto plate = std::ranges::count_if(cloud.foreground_pixels, is_plate);
  ASSERT_GT(plate, 100);
  EXPECT_EQ(std::ranges::count_if(searched, is_plate), plate) << "all of the plate";
  const double wall = static_cast<double>(cloud.foreground_pixels.size()) - plate;
  EXPECT_NEAR(static_cast<double>(searched.size()) - plate, wall / kLargeSurfaceStride, 1);
  EXPECT_TRUE(std::ranges::is_sorted(searched));
}

TEST(SearchPixels, SurfacesUpToTheSizeOfTheObjectsAreSearched) {
  const OrganizedCloud cloud = WallAndPlate();
  EXPECT_EQ(SearchPixels(cloud, 5), cloud.foreground_pixels);
}

// The extent of the plate depends on the diameter of the objects, and not on its size in the image.
TEST(SearchPixels, PlateIsLargeForSmallObjects) {
  const OrganizedCloud cloud = WallAndPlate();
  const size_t all = cloud.foreground_pixels.size();
  EXPECT_NEAR(static_cast<double>(SearchPixels(cloud, 0.05).size()),
              static_cast<double>(all) / kLargeSurfaceStride, 2);
}

TEST(SearchPixels, GivenBackgroundLeavesNoWalls) {
  OrganizedCloud cloud = WallAndPlate();
  cloud.background = BackgroundKind::kKnown;
  EXPECT_EQ(SearchPixels(cloud, kDiameter_m), cloud.foreground_pixels);
}

}  // namespace
}  // namespace pickbed::tests
