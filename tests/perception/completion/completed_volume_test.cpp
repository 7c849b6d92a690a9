#include "perception/completion/completed_volume.h"

#include <gtest/gtest.h>

#include <numeric>

namespace pickbed::perception {
namespace {

CompletedVolume Ramp() {
  CompletedVolume volume;
  volume.origin_C = {0.1f, 0.2f, 0.5f};
  volume.cell_m = 0.01f;
  volume.size = 8;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) volume.occupancy.push_back(0.1f * x + 0.01f * y + 0.001f * z);
    }
  }
  return volume;
}

TEST(CompletedVolume, InterpolatesALinearFieldExactly) {
  const CompletedVolume volume = Ramp();
  EXPECT_NEAR(volume.At(volume.Center_C(3, 4, 5)), 0.345, 1e-5);
  const Eigen::Vector3f between = 0.5f * (volume.Center_C(3, 4, 5) + volume.Center_C(4, 5, 6));
  EXPECT_NEAR(volume.At(between), 0.4005, 1e-5);
  EXPECT_TRUE(volume.Gradient(between).isApprox(Eigen::Vector3f(10, 1, 0.1f), 1e-3f));
}

TEST(CompletedVolume, IsZeroOutsideTheCubeAndForNotANumber) {
  const CompletedVolume volume = Ramp();
  EXPECT_EQ(volume.At(volume.Center_C(8, 4, 4)), 0);
  EXPECT_EQ(volume.At(volume.Center_C(4, -1, 4)), 0);
  EXPECT_EQ(volume.At(Eigen::Vector3f::Constant(NAN)), 0);
  EXPECT_EQ(CompletedVolume().At(Eigen::Vector3f::Zero()), 0);
}

TEST(CompletedVolume, SmoothingKeepsTheSumOfAnInnerCellAndSpreadsItEvenly) {
  CompletedVolume volume = Ramp();
  std::fill(volume.occupancy.begin(), volume.occupancy.end(), 0.0f);
  volume.size = 8;
  volume.occupancy[volume.Index(4, 4, 4)] = 1;
  const CompletedVolume smooth = Smoothed(volume, 1);
  EXPECT_NEAR(std::accumulate(smooth.occupancy.begin(), smooth.occupancy.end(), 0.0), 1, 0.01);
  EXPECT_FLOAT_EQ(smooth.occupancy[smooth.Index(3, 4, 4)], smooth.occupancy[smooth.Index(4, 4, 5)]);
  EXPECT_LT(smooth.occupancy[smooth.Index(4, 4, 4)], 0.1f);
}

}  // namespace
}  // namespace pickbed::perception
