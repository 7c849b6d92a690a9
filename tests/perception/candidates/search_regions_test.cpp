#include "perception/candidates/search_regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace pickbed::tests {
namespace {

// A surface of 200 x 150 pixels with 3 mm a pixel, seen straight down from 1 m, and a block on it.
class Regions : public testing::Test {
 protected:
  static constexpr int kWidth = 200, kHeight = 150;
  static constexpr double kFocal_px = 333;

  Regions() {
    cloud_.intrinsics = {kWidth, kHeight, kFocal_px, kFocal_px, 99.5, 74.5};
    cloud_.points_C.resize(kWidth * kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) SetDepth(x, y, 1.0f);
    }
    for (int i = 0; i < kWidth * kHeight; ++i) cloud_.foreground_pixels.push_back(i);
  }

  void SetDepth(int x, int y, float z_m) {
    const float scale = z_m / static_cast<float>(kFocal_px);
    cloud_.points_C[y * kWidth + x] =
        Eigen::Vector3f((x - 99.5f) * scale, (y - 74.5f) * scale, z_m);
  }

  void AddBlock(int left, int top, int side, float z_m) {
    for (int y = top; y < top + side; ++y) {
      for (int x = left; x < left + side; ++x) SetDepth(x, y, z_m);
    }
  }

  double AreaOf(const std::vector<int>& pixels) const {
    double sum_m2 = 0;
    for (const int pixel : pixels) {
      const double z_m = cloud_.points_C[pixel].z();
      sum_m2 += z_m * z_m / (kFocal_px * kFocal_px);
    }
    return sum_m2;
  }

  OrganizedCloud cloud_;
  const Eigen::Vector3d up_C_{0, 0, -1};
};

TEST_F(Regions, TheFirstRegionHoldsTheHighestBlock) {
  AddBlock(150, 100, 24, 0.9f);
  AddBlock(20, 20, 24, 0.95f);
  SearchRegions regions(cloud_, up_C_, 0.03);
  const std::vector<int> first = regions.Next();
  const std::set<int> held(first.begin(), first.end());
  EXPECT_TRUE(held.contains(112 * kWidth + 162));
  EXPECT_FALSE(held.contains(32 * kWidth + 32));
}

TEST_F(Regions, UpDecidesWhatIsHigh) {
  AddBlock(150, 100, 24, 0.9f);
  // Seen from below, the block is the lowest place.
  SearchRegions regions(cloud_, -up_C_, 0.03);
  const std::vector<int> first = regions.Next();
  EXPECT_EQ(std::ranges::count(first, 112 * kWidth + 162), 0);
}

TEST_F(Regions, FewFlyingPixelsAreNotTheTop) {
  AddBlock(150, 100, 24, 0.9f);
  SetDepth(20, 20, 0.5f);
  SetDepth(21, 20, 0.5f);
  SearchRegions regions(cloud_, up_C_, 0.03);
  const std::vector<int> first = regions.Next();
  EXPECT_EQ(std::ranges::count(first, 112 * kWidth + 162), 1);
}

TEST_F(Regions, TogetherTheyCoverTheForegroundAndEachHasTheGivenArea) {
  AddBlock(60, 60, 40, 0.9f);
  const double area_m2 = 0.02;
  SearchRegions regions(cloud_, up_C_, area_m2);
  std::set<int> covered;
  int count = 0;
  for (std::vector<int> region = regions.Next(); !region.empty(); region = regions.Next()) {
    // One ring of pixels more at most. At a corner the region is a quarter of a disc.
    EXPECT_GE(AreaOf(region), area_m2);
    EXPECT_LT(AreaOf(region), 1.15 * area_m2);
    EXPECT_TRUE(std::is_sorted(region.begin(), region.end()));
    covered.insert(region.begin(), region.end());
    ++count;
  }
  EXPECT_GT(covered.size(), 0.99 * kWidth * kHeight);
  const double all_m2 = AreaOf(cloud_.foreground_pixels);
  EXPECT_GT(count, all_m2 / area_m2);      // they overlap,
  EXPECT_LT(count, 4 * all_m2 / area_m2);  // but not much
}

TEST_F(Regions, ASmallForegroundIsOneRegion) {
  SearchRegions regions(cloud_, up_C_, 10);
  EXPECT_EQ(regions.Next(), cloud_.foreground_pixels);
  EXPECT_TRUE(regions.Next().empty());
  cloud_.foreground_pixels.clear();
  EXPECT_TRUE(SearchRegions(cloud_, up_C_, 10).Next().empty());
}

}  // namespace
}  // namespace pickbed::tests
