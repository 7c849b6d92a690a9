#include "scenes/image/srgb.h"

#include <gtest/gtest.h>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// Half of the light has 188 of 255 in an sRGB image, and the two functions undo each other.
TEST(Srgb, MiddleGreyAndRoundTrip) {
  EXPECT_NEAR(255 * SrgbOfLinear(0.5f), 187.5, 0.1);
  for (int value = 0; value <= 255; ++value) {
    EXPECT_NEAR(255 * SrgbOfLinear(LinearOfSrgb(value / 255.0f)), value, 0.01);
  }
  EXPECT_EQ(SrgbOfLinear(-0.1f), 0);
  EXPECT_NEAR(SrgbOfLinear(7), 1, 1e-6);
}

}  // namespace
}  // namespace pickbed::tests
