// Poses in damaged frames. damaged_frames runs many of them by hand.

#include "tests/fuzz/damaged_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace pickbed::tests {
namespace {

TEST(DamagedFrames, SameSeedGivesSameFrameAndAllDamagesAreDrawn) {
  const NamedFrame given = FramesToDamage("/nowhere", 1).front();
  EXPECT_EQ(given.name, "drawn");
  std::set<std::string> names;
  bool has_nan = false;
  for (uint64_t i = 0; i < 200; ++i) {
    Rng a = Rng::Derive(5, i, "x"), b = Rng::Derive(5, i, "x");
    const NamedFrame frame = DamagedFrame(given, a), same = DamagedFrame(given, b);
    EXPECT_EQ(frame.name, same.name);
    ASSERT_EQ(frame.frame.depth_m.size(), same.frame.depth_m.size());
    for (size_t p = 0; p < frame.frame.depth_m.size(); ++p) {
      has_nan |= std::isnan(frame.frame.depth_m.data()[p]);
    }
    names.insert(frame.name);
  }
  EXPECT_TRUE(has_nan);
  EXPECT_GT(names.size(), 100u);
}

// Real frames if there are some.
TEST(DamagedFrames, AreRefusedOrGivePosesAndNothingElse) {
  constexpr uint64_t kImages = 30;
  DamagedFrameRun run(FramesToDamage(PICKBED_TEST_DATA, 2));
  int with_poses = 0, refused = 0;
  for (uint64_t number = 0; number < kImages; ++number) {
    const DamagedFrameRun::Outcome outcome = run.RunImage(1, number);
    with_poses += outcome.poses > 0;
    refused += !outcome.refusal.empty();
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, static_cast<int>(kImages));
  EXPECT_GT(with_poses, 0);
}

}  // namespace
}  // namespace pickbed::tests
