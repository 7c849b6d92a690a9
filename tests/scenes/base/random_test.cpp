#include "scenes/base/random.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// Expected values come from another implementation of the two published algorithms.
TEST(Rng, GivesThePublishedSequence) {
  Rng zero(0);
  for (const uint64_t expected : {11091344671253066420ull, 13793997310169335082ull,
                                  1900383378846508768ull, 7684712102626143532ull})
    EXPECT_EQ(zero.Next(), expected);
  Rng other(12345);
  for (const uint64_t expected : {13720838825685603483ull, 2398916695208396998ull})
    EXPECT_EQ(other.Next(), expected);
}

TEST(Rng, DerivedStreamsRepeatAndDiffer) {
  EXPECT_EQ(Rng::Derive(7, 3, "drop").Next(), Rng::Derive(7, 3, "drop").Next());
  std::set<uint64_t> firsts;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    for (uint64_t trial = 0; trial < 20; ++trial) {
      for (const char* stage : {"drop", "noise", "plan", ""}) {
        firsts.insert(Rng::Derive(seed, trial, stage).Next());
      }
    }
  }
  EXPECT_EQ(firsts.size(), 20u * 20 * 4);
}

TEST(Rng, NeighboringSeedsAndTrialsAreUncorrelated) {
  // Two independent 64-bit words differ in 32 bits on average, with a standard deviation of 4.
  double by_seed = 0, by_trial = 0;
  constexpr int kPairs = 2000;
  for (uint64_t i = 0; i < kPairs; ++i) {
    const uint64_t word = Rng::Derive(i, 5, "drop").Next();
    by_seed += std::popcount(word ^ Rng::Derive(i + 1, 5, "drop").Next());
    by_trial +=
        std::popcount(Rng::Derive(5, i, "drop").Next() ^ Rng::Derive(5, i + 1, "drop").Next());
  }
  const double five_sigma = 5 * 4 / std::sqrt(kPairs);
  EXPECT_NEAR(by_seed / kPairs, 32, five_sigma);
  EXPECT_NEAR(by_trial / kPairs, 32, five_sigma);
}

TEST(Rng, UniformCoversItsInterval) {
  Rng rng(1);
  double sum = 0, low = 1, high = 0;
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = rng.Uniform();
    sum += x;
    low = std::min(low, x);
    high = std::max(high, x);
  }
  EXPECT_NEAR(sum / kDraws, 0.5, 5 * std::sqrt(1.0 / 12 / kDraws));
  EXPECT_GE(low, 0);
  EXPECT_LT(low, 1e-3);
  EXPECT_LT(high, 1);
  EXPECT_GT(high, 1 - 1e-3);
}

TEST(Rng, UniformExcludesTheUpperLimit) {
  Rng rng(2);
  const double high = std::nextafter(1.0, 2.0);  // only 1 is in [1, high)
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(rng.Uniform(1.0, high), 1.0);
  EXPECT_EQ(rng.Uniform(3, 3), 3);
}

TEST(Rng, IndexIsUnbiased) {
  Rng rng(3);
  for (const int count : {1, 2, 3, 7, 10}) {
    std::vector<int> seen(count);
    constexpr int kDraws = 100000;
    for (int i = 0; i < kDraws; ++i) ++seen.at(rng.Index(count));
    double chi_squared = 0;
    const double expected = static_cast<double>(kDraws) / count;
    for (const int n : seen) chi_squared += (n - expected) * (n - expected) / expected;
    EXPECT_LT(chi_squared, count - 1 + 5 * std::sqrt(2.0 * count) + 10) << count;
  }
  // 2^32 words map to 3 * 2^29 numbers, which get 2, 3 and 3 words. Without rejection every third
  // number would be drawn too rarely.
  int thirds[3] = {};
  constexpr int kDraws = 30000;
  for (int i = 0; i < kDraws; ++i) ++thirds[rng.Index(3 << 29) % 3];
  for (const int n : thirds) EXPECT_NEAR(n, kDraws / 3, 5 * std::sqrt(kDraws * 2.0 / 9));
  EXPECT_THROW(rng.Index(0), std::invalid_argument);
}

TEST(Rng, NormalHasGaussianMoments) {
  Rng rng(4);
  double moments[5] = {};
  constexpr int kDraws = 200000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = rng.Normal();
    for (int k = 1; k <= 4; ++k) moments[k] += std::pow(x, k) / kDraws;
  }
  const double n = kDraws;
  EXPECT_NEAR(moments[1], 0, 5 / std::sqrt(n));
  EXPECT_NEAR(moments[2], 1, 5 * std::sqrt(2 / n));
  EXPECT_NEAR(moments[3], 0, 5 * std::sqrt(15 / n));
  EXPECT_NEAR(moments[4], 3, 5 * std::sqrt(96 / n));
}

TEST(Rng, UnitVectorsAreUniformOnTheSphere) {
  Rng rng(5);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 50000;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d v = rng.UnitVector();
    ASSERT_NEAR(v.norm(), 1, 1e-12);
    mean += v / kDraws;
    second += v * v.transpose() / kDraws;
  }
  EXPECT_LT(mean.norm(), 5 / std::sqrt(kDraws));
  EXPECT_LT((second - Eigen::Matrix3d::Identity() / 3).norm(), 5 / std::sqrt(kDraws));
}

TEST(Rng, RotationsAreUniformOnSO3) {
  Rng rng(6);
  constexpr int kDraws = 50000;
  int below_90_deg = 0;
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    ASSERT_NEAR(q.norm(), 1, 1e-12);
    mean += q.toRotationMatrix() / kDraws;
    below_90_deg += Eigen::AngleAxisd(q).angle() < std::numbers::pi / 2;
  }
  EXPECT_LT(mean.norm(), 6 / std::sqrt(kDraws));
  // Haar measure: P(angle < t) = (t - sin t) / pi.
  const double p = (std::numbers::pi / 2 - 1) / std::numbers::pi;
  EXPECT_NEAR(below_90_deg / double{kDraws}, p, 5 * std::sqrt(p * (1 - p) / kDraws));
}

TEST(HashBytes, EqualsFnv1a) {
  EXPECT_EQ(HashBytes("", 0), 0xcbf29ce484222325ull);
  EXPECT_EQ(HashBytes("a", 1), 0xaf63dc4c8601ec8cull);
  EXPECT_EQ(HashBytes("foobar", 6), 0x85944171f73967e8ull);
  EXPECT_EQ(HashBytes("bar", 3, HashBytes("foo", 3)), HashBytes("foobar", 6));
}

}  // namespace
}  // namespace pickbed::tests
