#include "scenes/camera/footprint.h"

#include <gtest/gtest.h>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

const CameraIntrinsics kCamera{200, 100, 400, 400, 99.5, 49.5};
const Bounds kBox{{-0.1, -0.05, -0.02}, {0.1, 0.05, 0.02}};

TEST(Footprint, BoxInFrontOfTheCameraMatchesProjection) {
  const Footprint f = FootprintOf(kBox, Translation({0, 0, 1}), kCamera);
  EXPECT_TRUE(f.in_front);
  EXPECT_NEAR(f.near_m, 0.98, 1e-12);
  EXPECT_NEAR(f.far_m, 1.02, 1e-12);
  EXPECT_NEAR(f.max_px.x(), 99.5 + 400 * 0.1 / 0.98, 1e-9);
  EXPECT_NEAR(f.min_px.y(), 49.5 - 400 * 0.05 / 0.98, 1e-9);
  EXPECT_TRUE(f.IsInside(kCamera));
}

TEST(Footprint, HandlesBoxesAcrossTheBorderOutsideAndBehind) {
  const Footprint across = FootprintOf(kBox, Translation({0.2, 0, 1}), kCamera);
  EXPECT_TRUE(across.Overlaps(kCamera));
  EXPECT_FALSE(across.IsInside(kCamera));
  EXPECT_FALSE(FootprintOf(kBox, Translation({0.5, 0, 1}), kCamera).Overlaps(kCamera));
  EXPECT_FALSE(FootprintOf(kBox, Translation({0, 0, -1}), kCamera).Overlaps(kCamera));
  const Footprint through = FootprintOf(kBox, Translation({0, 0, 0.01}), kCamera);
  EXPECT_FALSE(through.in_front);
  EXPECT_TRUE(through.Overlaps(kCamera));
}

}  // namespace
}  // namespace pickbed::tests
