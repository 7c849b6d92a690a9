#include "eval/bop/scores.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "eval/bop/vsd.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

TEST(BopMatching, HigherScoreChoosesFirstAndTakesTheNearest) {
  // Estimate 1 chooses first and takes the nearer of the two instances below 1.0. Estimate 0
  // prefers the same instance and gets the other one. Estimate 2 gets none.
  const ErrorTable table{1, {0.5, 0.9, 0.1}, {1, 1}, {{0.2, 0.4}, {0.1, 0.3}, {0.0, 0.0}}};
  EXPECT_EQ(MatchGreedily(table, {true, true}, 1.0), (std::vector<int>{1, 0, -1}));
  // An error equal to the threshold does not match.
  EXPECT_EQ(MatchGreedily(table, {true, true}, 0.1), (std::vector<int>{-1, -1, 0}));
  EXPECT_EQ(MatchGreedily(table, {false, true}, 1.0), (std::vector<int>{-1, 1, -1}));
}

TEST(BopLocalisation, BestEstimatesAreComparedWithMostVisibleInstances) {
  // Two of three instances are required: visible at 90 % and 60 %. The two best estimates match the
  // hidden instance 1 and instance 0. The third one, which matches instance 2, is not used.
  const ErrorTable table{1, {0.9, 0.8, 0.7}, {0.9, 0.2, 0.6}, {{1, 0, 1}, {0, 1, 1}, {1, 1, 0}}};
  const Recall two = RecallOf(table, 2, 0.5);
  EXPECT_EQ(two.found, 1);
  EXPECT_EQ(two.wanted, 2);
  const Recall all = RecallOf(table, 3, 0.5);
  EXPECT_EQ(all.found, 3);
  EXPECT_EQ(all.wanted, 3);
}

TEST(BopDetection, AveragePrecisionEqualsHandComputedValues) {
  // Right, wrong and right for two instances: precision 1 up to recall 0.5 (51 levels), then 2/3
  // (50 levels).
  EXPECT_NEAR(AveragePrecision({{0.9, true}, {0.8, false}, {0.7, true}}, 2),
              (51 + 50 * 2.0 / 3) / 101, 1e-12);
  // One of four is found: recall 0.25, 26 levels. The order of the input does not matter.
  EXPECT_NEAR(AveragePrecision({{0.1, false}, {0.9, true}}, 4), 26.0 / 101, 1e-12);
  // Seven of ten: the level 0.7 is not reached, because 70 * 0.01 > 7.0 / 10 in floating point.
  EXPECT_NEAR(AveragePrecision(std::vector<Detection>(7, {0.9, true}), 10), 70.0 / 101, 1e-12);
  EXPECT_EQ(AveragePrecision({}, 3), 0);
  EXPECT_EQ(AveragePrecision({{0.5, true}}, 1), 1);
}

TEST(BopDetection, BarelyVisibleInstancesAreIgnored) {
  // The best estimate matches an instance visible at 5 %. It is ignored, so the other one has
  // precision 1.
  const ErrorTable table{7, {0.9, 0.8}, {0.05, 0.5}, {{0, 1}, {1, 0}}};
  EXPECT_EQ(AveragePrecisions({table}, 0.5).at(7), 1);
  // At 10 % it counts, and missing it halves the possible recall.
  const ErrorTable counted{7, {0.8}, {0.1, 0.5}, {{1, 0}}};
  EXPECT_NEAR(AveragePrecisions({counted}, 0.5).at(7), 51.0 / 101, 1e-12);
  // An object that is only barely visible has no precision. Estimates in images without the object
  // are wrong.
  EXPECT_FALSE(AveragePrecisions({{7, {0.9}, {0.05}, {{0}}}}, 0.5).contains(7));
  const ErrorTable elsewhere{7, {0.95}, {}, {{}}};
  EXPECT_NEAR(AveragePrecisions({counted, elsewhere}, 0.5).at(7), 51 * 0.5 / 101, 1e-12);
}

// Silhouette of one pixel row that begins at column x.
DistanceCrop Row(int x, const std::vector<float>& distances_m) {
  DistanceCrop silhouette{x, 0, Image<float>(static_cast<int>(distances_m.size()), 1)};
  silhouette.distances_m.pixels() = distances_m;
  return silhouette;
}

TEST(BopVsd, EqualsHandComputedValues) {
  constexpr std::array<double, 2> kTaus{0.05, 0.5};
  const Image<float> nothing(6, 1);  // no readings, so all is visible
  const DistanceCrop truth = Row(0, {1, 1, 1, 1});
  EXPECT_EQ(Vsd(truth, truth, nothing, 0.1, kTaus), (std::vector<double>{0, 0}));
  // Columns 0 and 4 are in only one silhouette. One of the three common columns is off by 0.3
  // diameters.
  const std::vector<double> shifted =
      Vsd(Row(1, {InstanceId{1}, ObjectId{1}, 1.03f, 1}), truth, nothing, 0.1, kTaus);
  EXPECT_NEAR(shifted[0], 3.0 / 5, 1e-12);
  EXPECT_NEAR(shifted[1], 2.0 / 5, 1e-12);
  // No common pixels, and two empty silhouettes.
  EXPECT_EQ(Vsd(Row(5, {1}), truth, nothing, 0.1, kTaus), (std::vector<double>{1, 1}));
  EXPECT_EQ(Vsd(Row(0, {}), Row(0, {}), nothing, 0.1, kTaus), (std::vector<double>{1, 1}));
}

TEST(BopVsd, HiddenPixelsDoNotCount) {
  constexpr std::array<double, 1> kTau{0.05};
  Image<float> measured_m(4, 1, 1.0f);
  measured_m(0, 0) = 0.9f;  // something occludes column 0
  const DistanceCrop truth = Row(0, {1, 1});
  // Wrong only at column 0, where both are hidden.
  EXPECT_EQ(Vsd(Row(0, {1.05f, 1}), truth, measured_m, 0.1, kTau), std::vector<double>{0});
  // 16 mm behind the measured surface is hidden, 14 mm is not. Here the ground truth is visible, so
  // the estimate counts as visible too, at a wrong distance.
  EXPECT_EQ(Vsd(Row(1, {1.016f}), Row(1, {1}), measured_m, 0.1, kTau), std::vector<double>{1});
  // Only the estimate covers column 2, behind the measured surface: hidden, no error.
  EXPECT_EQ(Vsd(Row(1, {1, 1.016f}), Row(1, {1}), measured_m, 0.1, kTau), std::vector<double>{0});
  EXPECT_EQ(Vsd(Row(1, {1, 1.014f}), Row(1, {1}), measured_m, 0.1, kTau), std::vector<double>{0.5});
}

TEST(BopVsd, DistancesAreFromTheCameraCenter) {
  const CameraIntrinsics camera{3, 1, 1, 1, 1, 0};
  Image<float> depth_m(3, 1);
  depth_m(0, 0) = 1;
  depth_m(1, 0) = 2;
  const Image<float> distances_m = DistancesOf(depth_m, camera);
  EXPECT_FLOAT_EQ(distances_m(0, 0), std::sqrt(2.0f));
  EXPECT_FLOAT_EQ(distances_m(1, 0), 2);
  EXPECT_EQ(distances_m(2, 0), 0);
  const DistanceCrop silhouette = DistanceCropOf(depth_m, camera);
  EXPECT_EQ(silhouette.x, 0);
  EXPECT_EQ(silhouette.distances_m.width(), 2);
  EXPECT_FLOAT_EQ(silhouette.distances_m(0, 0), std::sqrt(2.0f));
}

}  // namespace
}  // namespace pickbed::tests
