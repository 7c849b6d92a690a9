#include "scenes/camera/filled_depth.h"

#include <gtest/gtest.h>

#include <limits>

namespace pickbed::tests {
namespace {

TEST(FilledDepth, GapsTakeTheNearestEndInRowAndColumn) {
  Image<float> depth_m(4, 3, 1.0f);
  depth_m(1, 1) = 0;
  depth_m(2, 1) = std::numeric_limits<float>::quiet_NaN();
  depth_m(3, 1) = 0.8f;  // ends the gap in its row
  depth_m(1, 2) = 0.5f;  // ends the gap in the column of the first pixel
  const Image<float> filled = FilledDepth(depth_m);
  EXPECT_EQ(filled(1, 1), 0.5f);
  EXPECT_EQ(filled(2, 1), 0.8f);
  EXPECT_EQ(filled(0, 1), 1.0f) << "readings stay";
  EXPECT_EQ(filled(3, 1), 0.8f);
}

TEST(FilledDepth, AnImageWithoutReadingsIsInfinite) {
  EXPECT_EQ(FilledDepth(Image<float>(2, 2, 0.0f))(1, 1), std::numeric_limits<float>::infinity());
}

}  // namespace
}  // namespace pickbed::tests
