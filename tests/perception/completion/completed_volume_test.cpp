#include "perception/completion/completed_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "scenes/base/random.h"

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

// IoU of the cells above a level with a truth that is drawn cell by cell.
double DrawnIou(const CompletedVolume& volume, double level) {
  Rng rng(7);
  double both = 0, either = 0;
  for (const float p : volume.occupancy) {
    const bool inside = rng.Uniform()<p, full = p> level;
    both += inside && full;
    either += inside || full;
  }
  return both / either;
}

CompletedVolume VolumeOf(int size, double exponent) {
  CompletedVolume volume;
  volume.size = size;
  volume.cell_m = 0.01f;
  Rng rng(3);
  for (int i = 0; i < size * size * size; ++i) {
    volume.occupancy.push_back(static_cast<float>(std::pow(rng.Uniform(), exponent)));
  }
  return volume;
}

// No other level reaches a higher IoU with truths that the probabilities describe.
TEST(LevelForIou, NoOtherLevelReachesMore) {
  for (const double exponent : {0.2, 1.0, 5.0}) {
    const CompletedVolume volume = VolumeOf(40, exponent);
    const double best = DrawnIou(volume, LevelForIou(volume));
    for (double level = 0.05; level < 1; level += 0.05) {
      EXPECT_LE(DrawnIou(volume, level), best + 0.004) << exponent << " " << level;
    }
  }
}

TEST(LevelForIou, IsLowForADoubtfulShapeAndSeparatesACertainOne) {
  CompletedVolume doubtful = VolumeOf(40, 5.0);
  for (float& p : doubtful.occupancy) p *= 0.45f;
  EXPECT_LT(LevelForIou(doubtful), 0.25f);
  EXPECT_EQ(DrawnIou(doubtful, 0.5), 0);
  EXPECT_GT(DrawnIou(doubtful, LevelForIou(doubtful)), 0.1);
  CompletedVolume certain = VolumeOf(20, 1.0);
  for (float& p : certain.occupancy) p = p > 0.7f ? 1 : 0;
  EXPECT_EQ(DrawnIou(certain, LevelForIou(certain)), 1);
  EXPECT_EQ(LevelForIou(CompletedVolume()), 0.5f);
}

}  // namespace
}  // namespace pickbed::perception
