#include "eval/export/pick_animation.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "grasp/grippers/table.h"
#include "tests/eval/cube_scenario.h"

namespace pickbed::tests {
namespace {

// A cube that does not move, and a hand above it.
PickMotion StillMotion(int frames) {
  PickMotion motion;
  motion.scene.objects = {{InstanceId{0}, ObjectId{0}, Translation({0, 0, 0.015})}};
  motion.frame_s = 0.1;
  motion.table_W = AxisAlignedBox{{0.5, 0, 0.1}, {0.1, 0.1, 0.1}};
  for (int i = 0; i < frames; ++i) {
    motion.frames.push_back({{motion.scene.objects[0].X_WO}, Translation({0, 0, 0.3}), 0.05});
  }
  return motion;
}

// Delays of the pictures of a GIF, in hundredths of a second.
std::vector<int> DelaysOf(const std::string& gif) {
  const std::string mark = {'\x21', '\xf9', '\x04'};
  std::vector<int> delays;
  for (size_t at = gif.find(mark); at != std::string::npos; at = gif.find(mark, at + 1)) {
    delays.push_back(static_cast<unsigned char>(gif[at + 4]) +
                     256 * static_cast<unsigned char>(gif[at + 5]));
  }
  return delays;
}

TEST(PickMovie, SpeedDoesNotDependOnTheNumberOfPictures) {
  const auto gripper = LoadGripper("jaw_8cm");
  const ObjectSet objects = EasyCube();
  const auto delays = [&](int every, double speed) {
    const MovieOptions options{.width_px = 48, .height_px = 36, .every = every, .speed = speed};
    return DelaysOf(PickMovie(objects, Bin(), *gripper, options).Gif(StillMotion(4)));
  };
  ASSERT_EQ(delays(2, 1).size(), 2u);
  EXPECT_EQ(delays(2, 1)[0], 20) << "two frames of 0.1 s";
  EXPECT_EQ(delays(1, 1)[0], 10);
  EXPECT_EQ(delays(2, 2)[0], 10);
}

TEST(PickMovie, OptionsOutOfRangeAreRefused) {
  const auto gripper = LoadGripper("jaw_8cm");
  const ObjectSet objects = EasyCube();
  EXPECT_THROW(PickMovie(objects, Bin(), *gripper, {.every = 0}), std::logic_error);
  EXPECT_THROW(PickMovie(objects, Bin(), *gripper, {.speed = 0}), std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
