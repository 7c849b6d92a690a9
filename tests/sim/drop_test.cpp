#include "sim/drop.h"

#include <gmock/gmock.h>

#include "scenes/check.h"
#include "sim/scene_certificate.h"
#include "tests/sim/physics_parts.h"

namespace pickbed {
namespace {

using ::testing::HasSubstr;

DropResult DropMixed(uint64_t seed, int each) {
  Rng rng(seed);
  return DropParts(Bin{}, MixedParts(), {each, each, each, each}, rng);
}

bool SameBits(const Scene& a, const Scene& b) {
  if (a.objects.size() != b.objects.size()) return false;
  for (size_t i = 0; i < a.objects.size(); ++i) {
    if (a.objects[i].object != b.objects[i].object) return false;
    if (a.objects[i].X_WO.matrix() != b.objects[i].X_WO.matrix()) return false;
  }
  return true;
}

TEST(DropParts, TwentyMixedPartsComeToRestInsideWithoutOverlap) {
  for (const uint64_t seed : {0, 1, 2}) {
    const DropResult drop = DropMixed(seed, 5);
    EXPECT_TRUE(drop.report.at_rest) << "seed " << seed;
    EXPECT_FALSE(drop.report.blew_up) << "seed " << seed;
    EXPECT_EQ(drop.report.left_bin, 0) << "seed " << seed;
    EXPECT_EQ(drop.scene.objects.size(), 20u) << "seed " << seed;
    EXPECT_LT(drop.report.deepest_penetration_m, 0.0005) << "seed " << seed;
    EXPECT_LT(drop.report.max_speed_mps, 0.01) << "seed " << seed;
  }
}

}  // namespace
}  // namespace pickbed
