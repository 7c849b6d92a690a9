#include "sim/physics/contact_islands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "sim/hands/jaw_hand.h"
#include "sim/physics/physics_world.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

// A closed jaw beside a sleeping row of cubes that touch each other. The hand is turned by 45
// degrees, so that the box of a finger overlaps the box of the first cube before it touches it.
struct SleepingRow {
  static constexpr int kCubes = 4;
  std::shared_ptr<const ObjectModel> cube = BoxObject({0.04, 0.04, 0.04}, 0.1, 0.2);
  PhysicsWorld world;
  Hand* hand = nullptr;

  explicit SleepingRow(bool wake_by_contact)
      : world(PhysicsOptions{.wake_by_contact = wake_by_contact}) {
    world.AddStaticBox(Translation({0, 0, -0.05}), {1, 1, 0.05}, 0.2);
    for (int i = 0; i < kCubes; ++i) {
      world.AddInstance(*cube, Translation({0.0411 * i, 0, 0.0206}), BodyMode::kAsleep);
    }
    hand = &AddJawHand(world, HandSpec{}, HandAt(-0.075));
    hand->HoldOpening(0);
  }

  // A hand above the table that points down, beside the row.
  static Pose HandAt(double x_m) {
    const Eigen::AngleAxisd turn(0.25 * std::numbers::pi, Eigen::Vector3d::UnitZ());
    const Eigen::Matrix3d down = Eigen::Vector3d(1, -1, -1).asDiagonal();
    return MakePose(turn * down, {x_m, 0, 0.01});
  }

  int Awake() const {
    int awake = 0;
    for (int i = 0; i < kCubes; ++i) awake += world.body(i).body->isActive();
    return awake;
  }

  // Moves the hand along x at 0.1 m/s.
  void MoveHandTo(double from_x_m, double to_x_m) {
    const double start_s = world.time_s();
    for (double x_m = from_x_m; x_m < to_x_m;) {
      x_m = std::min(to_x_m, from_x_m + 0.1 * (world.time_s() + world.step_s() - start_s));
      hand->MoveTo(HandAt(x_m));
      world.Step();
    }
  }
};

TEST(WakeByContact, HandWakesNothingBeforeItTouches) {
  SleepingRow row(true);
  row.MoveHandTo(-0.075, -0.055);
  EXPECT_EQ(row.Awake(), 0);
  EXPECT_TRUE(row.world.InstancesTouchingHand().empty());
  SleepingRow by_boxes(false);
  by_boxes.MoveHandTo(-0.075, -0.055);
  EXPECT_EQ(by_boxes.Awake(), SleepingRow::kCubes);  // Bullet's rule: the boxes overlap
}

TEST(WakeByContact, TouchedInstanceWakesAllThatItMayMove) {
  SleepingRow row(true);
  row.MoveHandTo(-0.075, -0.02);
  EXPECT_EQ(row.Awake(), SleepingRow::kCubes);
  for (int i = 0; i < SleepingRow::kCubes; ++i) {
    EXPECT_GT(row.world.X_WO(i).translation().x(), 0.0411 * i + 0.001) << i;
  }
}

// A fast body takes the support of a sleeping one away, which must fall.
TEST(WakeByContact, InstanceFallsWhenItsSupportIsHitAway) {
  const auto cube = BoxObject({0.04, 0.04, 0.04}, 0.1, 0.1);
  PhysicsWorld world(PhysicsOptions{.wake_by_contact = true});
  world.AddStaticBox(Translation({0, 0, -0.05}), {1, 1, 0.05}, 0.1);
  world.AddInstance(*cube, Translation({0, 0, 0.0205}), BodyMode::kAsleep);
  const int upper = world.AddInstance(*cube, Translation({0.015, 0, 0.0615}), BodyMode::kAsleep);
  world.AddInstance(*cube, Translation({-0.08, 0, 0.0205}), BodyMode::kDynamic,
                    {{4.0, 0, 0}, Eigen::Vector3d::Zero()});
  while (world.time_s() < 0.6) world.Step();
  EXPECT_LT(world.X_WO(upper).translation().z(), 0.045);
}

}  // namespace
}  // namespace pickbed::tests
