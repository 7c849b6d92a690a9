#include "eval/statistics.h"

#include <gtest/gtest.h>

namespace pickbed {
namespace {

// Values from the closed form with z = 1.959964 (Newcombe 1998, table I, method 3).
TEST(WilsonInterval, EqualsPublishedCases) {
  const Interval a = WilsonInterval(81, 263);
  EXPECT_NEAR(a.low, 0.2553, 5e-5);
  EXPECT_NEAR(a.high, 0.3662, 5e-5);
  const Interval b = WilsonInterval(15, 148);
  EXPECT_NEAR(b.low, 0.0624, 5e-5);
  EXPECT_NEAR(b.high, 0.1605, 5e-5);
  const Interval c = WilsonInterval(0, 20);
  EXPECT_NEAR(c.low, 0, 1e-12);
  EXPECT_NEAR(c.high, 0.1611, 5e-5);
  const Interval d = WilsonInterval(1, 29);
  EXPECT_NEAR(d.low, 0.0061, 5e-5);
  EXPECT_NEAR(d.high, 0.1718, 5e-5);
}

TEST(WilsonInterval, KnowsNothingWithoutAttempts) {
  const Interval none = WilsonInterval(0, 0);
  EXPECT_EQ(none.low, 0);
  EXPECT_EQ(none.high, 1);
}

TEST(WilsonInterval, MirrorsWhenSuccessAndFailureSwap) {
  for (int k = 0; k <= 12; ++k) {
    const Interval a = WilsonInterval(k, 12), b = WilsonInterval(12 - k, 12);
    EXPECT_NEAR(a.low, 1 - b.high, 1e-12);
    EXPECT_LE(a.low, k / 12.0 + 1e-12);
    EXPECT_GE(a.high, k / 12.0 - 1e-12);
  }
}

}  // namespace
}  // namespace pickbed
