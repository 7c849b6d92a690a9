#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "eval/bop/scores.h"
#include "eval/bop/vsd.h"

namespace pickbed::bop {
namespace {

TEST(BopMatching, TheHigherScoreChoosesFirstAndTakesTheNearest) {
  // Estimate 1 comes first: of the two instances below 1.0 it takes the nearer. Estimate 0 would
  // have liked the same one and gets the other; estimate 2 is left without.
  const ErrorTable table{1, {0.5, 0.9, 0.1}, {1, 1}, {{0.2, 0.4}, {0.1, 0.3}, {0.0, 0.0}}};
  EXPECT_EQ(MatchGreedily(table, {true, true}, 1.0), (std::vector<int>{1, 0, -1}));
  // The threshold itself is out.
  EXPECT_EQ(MatchGreedily(table, {true, true}, 0.1), (std::vector<int>{-1, -1, 0}));
  EXPECT_EQ(MatchGreedily(table, {false, true}, 1.0), (std::vector<int>{-1, 1, -1}));
}

TEST(BopLocalisation, CountsTheBestEstimatesAgainstTheMostVisible) {
  // Two of three instances are asked for: those of 90 % and 60 %. The two best estimates stand on
  // the hidden instance 1 and on instance 0; the third, which is on instance 2, comes too late.
  const ErrorTable table{1, {0.9, 0.8, 0.7}, {0.9, 0.2, 0.6}, {{1, 0, 1}, {0, 1, 1}, {1, 1, 0}}};
  const Recall two = RecallOf(table, 2, 0.5);
  EXPECT_EQ(two.found, 1);
  EXPECT_EQ(two.wanted, 2);
  const Recall all = RecallOf(table, 3, 0.5);
  EXPECT_EQ(all.found, 3);
  EXPECT_EQ(all.wanted, 3);
}

TEST(BopDetection, AveragePrecisionByHand) {
  // Right, wrong, right, of two: precision 1 up to recall 0.5 (51 levels), then 2/3 (50 levels).
  EXPECT_NEAR(AveragePrecision({{0.9, true}, {0.8, false}, {0.7, true}}, 2),
              (51 + 50 * 2.0 / 3) / 101, 1e-12);
  // One of four found: recall 0.25, 26 levels. Order of the input does not matter.
  EXPECT_NEAR(AveragePrecision({{0.1, false}, {0.9, true}}, 4), 26.0 / 101, 1e-12);
  EXPECT_EQ(AveragePrecision({}, 3), 0);
  EXPECT_EQ(AveragePrecision({{0.5, true}}, 1), 1);
}

TEST(BopDetection, BarelyVisibleInstancesNeitherHelpNorHurt) {
  // The best estimate stands on an instance of 5 %: it is left out, so the other has precision 1.
  const ErrorTable table{7, {0.9, 0.8}, {0.05, 0.5}, {{0, 1}, {1, 0}}};
  EXPECT_EQ(AveragePrecisions({table}, 0.5).at(7), 1);
  // At 10 % it counts, and missing it halves what can be recalled.
  const ErrorTable counted{7, {0.8}, {0.1, 0.5}, {{1, 0}}};
  EXPECT_NEAR(AveragePrecisions({counted}, 0.5).at(7), 51.0 / 101, 1e-12);
  // An object that is only barely visible has no precision; estimates in images without it are
  // wrong ones.
  EXPECT_FALSE(AveragePrecisions({{7, {0.9}, {0.05}, {{0}}}}, 0.5).contains(7));
  const ErrorTable elsewhere{7, {0.95}, {}, {{}}};
  EXPECT_NEAR(AveragePrecisions({counted, elsewhere}, 0.5).at(7), 51 * 0.5 / 101, 1e-12);
}

// A row of pixels from column x on.
Silhouette Row(int x, const std::vector<float>& distances_m) {
  Silhouette silhouette{x, 0, Image<float>(static_cast<int>(distances_m.size()), 1)};
  silhouette.distances_m.pixels() = distances_m;
  return silhouette;
}

TEST(BopVsd, ByHand) {
  constexpr std::array<double, 2> kTaus{0.05, 0.5};
  const Image<float> nothing(6, 1);  // no reading: all is visible
  const Silhouette truth = Row(0, {1, 1, 1, 1});
  EXPECT_EQ(Vsd(truth, truth, nothing, 0.1, kTaus), (std::vector<double>{0, 0}));
  // Columns 0 and 4 are in one of the two; of the three in both, one is 0.3 diameters off.
  const std::vector<double> shifted = Vsd(Row(1, {1, 1, 1.03f, 1}), truth, nothing, 0.1, kTaus);
  EXPECT_NEAR(shifted[0], 3.0 / 5, 1e-12);
  EXPECT_NEAR(shifted[1], 2.0 / 5, 1e-12);
  // Nothing in common, and nothing to see at all.
  EXPECT_EQ(Vsd(Row(5, {1}), truth, nothing, 0.1, kTaus), (std::vector<double>{1, 1}));
  EXPECT_EQ(Vsd(Row(0, {}), Row(0, {}), nothing, 0.1, kTaus), (std::vector<double>{1, 1}));
}

TEST(BopVsd, WhatIsHiddenDoesNotCount) {
  constexpr std::array<double, 1> kTau{0.05};
  Image<float> measured_m(4, 1, 1.0f);
  measured_m(0, 0) = 0.9f;  // something stands before column 0
  const Silhouette truth = Row(0, {1, 1});
  // Wrong at column 0 alone, where neither is seen.
  EXPECT_EQ(Vsd(Row(0, {1.05f, 1}), truth, measured_m, 0.1, kTau), std::vector<double>{0});
  // 16 mm behind what is measured is hidden, 14 mm is not; here the truth is visible, so the
  // estimate counts as seen too and is apart, not missing.
  EXPECT_EQ(Vsd(Row(1, {1.016f}), Row(1, {1}), measured_m, 0.1, kTau), std::vector<double>{1});
  // Only the estimate at column 2, behind the measured surface: hidden, no error.
  EXPECT_EQ(Vsd(Row(1, {1, 1.016f}), Row(1, {1}), measured_m, 0.1, kTau), std::vector<double>{0});
  EXPECT_EQ(Vsd(Row(1, {1, 1.014f}), Row(1, {1}), measured_m, 0.1, kTau), std::vector<double>{0.5});
}

TEST(BopVsd, DistancesAreFromTheCentre) {
  const CameraIntrinsics camera{3, 1, 1, 1, 1, 0};
  Image<float> depth_m(3, 1);
  depth_m(0, 0) = 1;
  depth_m(1, 0) = 2;
  const Image<float> distances_m = DistancesOf(depth_m, camera);
  EXPECT_FLOAT_EQ(distances_m(0, 0), std::sqrt(2.0f));
  EXPECT_FLOAT_EQ(distances_m(1, 0), 2);
  EXPECT_EQ(distances_m(2, 0), 0);
  const Silhouette silhouette = SilhouetteOf(depth_m, camera);
  EXPECT_EQ(silhouette.x, 0);
  EXPECT_EQ(silhouette.distances_m.width(), 2);
  EXPECT_FLOAT_EQ(silhouette.distances_m(0, 0), std::sqrt(2.0f));
}

}  // namespace
}  // namespace pickbed::bop
