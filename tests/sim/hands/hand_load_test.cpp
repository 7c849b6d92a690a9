// Compares the measured load of a hand with the weight that hangs in it.

#include <gtest/gtest.h>

#include "sim/hands/jaw_hand.h"
#include "sim/physics/physics_world.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kMass_kg = 0.2;

Pose HandBeside(double y_m, double z_m) {
  return MakePose(Vector3d(1, -1, -1).asDiagonal(), {0, y_m, z_m});
}

// A 5 cm box on a table, gripped `off_center_m` beside its center and lifted by 10 cm.
struct LiftedBox {
  std::shared_ptr<const ObjectModel> box = BoxObject({0.05, 0.05, 0.05}, kMass_kg, 0.6);
  PhysicsWorld world;
  Hand* hand = nullptr;

  explicit LiftedBox(double off_center_m) {
    world.AddStaticBox(Translation({0, 0, -0.05}), {0.5, 0.5, 0.05}, 0.5);
    world.AddInstance(*box, Translation({0, 0, 0.0255}));
    hand = &AddJawHand(world, HandSpec{}, HandBeside(off_center_m, 0.02));
    hand->Close();
    for (int i = 0; i < 720; ++i) {
      const double lift_m = 0.1 * std::clamp((i - 140) / 240.0, 0.0, 1.0);
      hand->MoveTo(HandBeside(off_center_m, 0.02 + lift_m));
      world.Step();
    }
  }
};

TEST(HandLoad, ForceIsTheWeightOfTheHeldBox) {
  const LiftedBox held(0);
  const HandLoad load = held.hand->Load();
  const double weight_n = kMass_kg * kGravity_mps2;
  // z of G points down.
  EXPECT_NEAR(load.force_n.z(), weight_n, 0.01 * weight_n);
  EXPECT_LT(load.force_n.head<2>().norm(), 0.01 * weight_n);
  EXPECT_EQ(load.stiff_n, 0);  // the palm does not touch the box
}

TEST(HandLoad, TorqueIsWeightTimesLeverArm) {
  const double off_center_m = 0.01;
  const LiftedBox held(off_center_m);
  const HandLoad load = held.hand->Load();
  const Vector3d com_G = held.hand->X_WG().inverse() * held.world.X_WO(0).translation();
  const Vector3d expected = com_G.cross(Vector3d(0, 0, kMass_kg * kGravity_mps2));
  ASSERT_GT(expected.norm(), 0.015);  // 1 cm times 2 N
  EXPECT_LT((load.torque_nm - expected).norm(), 0.03 * expected.norm());
}

TEST(HandLoad, ContactWithAWallIsNoLoad) {
  PhysicsWorld world;
  world.AddStaticBox(Translation({0.05, 0, 0.3}), {0.01, 0.2, 0.2}, 0.5);
  Hand& hand = AddJawHand(world, HandSpec{}, HandBeside(0, 0.3));
  for (int i = 0; i < 240; ++i) {
    hand.HoldOpening(0.08);  // free fingers would reach x = 0.05; the wall starts at 0.04
    hand.MoveTo(HandBeside(0, 0.3));
    world.Step();
  }
  EXPECT_EQ(hand.Load().force_n.norm(), 0);
}

// A box of 5 cm is under the finger at x = 30 to 40 mm, and the hand is driven down onto it by 5
// mm.
class Overload : public testing::TestWithParam<double> {
 protected:
  // Values of the last step.
  struct Pushed {
    double yielded_m;
    double force_n;
  };
  static Pushed PushOn(bool is_static, double rate_hz) {
    const auto box = BoxObject({0.05, 0.05, 0.05}, kMass_kg, 0.6);
    PhysicsOptions options;
    options.rate_hz = rate_hz;
    PhysicsWorld world(options);
    if (is_static) world.AddStaticBox(Translation({0, 0, -0.05}), {0.5, 0.5, 0.05}, 0.5);
    world.AddInstance(*box, Translation({0.035, 0, 0.0255}));
    HandSpec spec;
    spec.stroke_m = 0.06;
    Hand& hand = AddJawHand(world, spec, HandBeside(0, 0.056));
    const int steps = static_cast<int>(0.1 * rate_hz);
    for (int i = 1; i <= steps; ++i) {
      hand.MoveTo(HandBeside(0, 0.056 - 0.01 * i / steps));
      world.Step();
    }
    return {hand.yielded_m(), -hand.Load().force_n.z()};
  }
};

// For any step rate: the finger yields by the distance that the floor blocks, at the configured
// force.
TEST_P(Overload, FingerYieldsAtItsForceByTheBlockedDistance) {
  const Pushed pushed = PushOn(true, GetParam());
  EXPECT_NEAR(pushed.yielded_m, 0.005, 3e-4);
  EXPECT_NEAR(pushed.force_n, HandSpec{}.yield_n, 1);
}

// The box falls freely and is pushed at 0.1 m/s.
TEST_P(Overload, FreeBoxDoesNotPushAFingerBack) {
  EXPECT_LT(PushOn(false, GetParam()).yielded_m, 2e-4);
}
INSTANTIATE_TEST_SUITE_P(Rates, Overload, testing::Values(240, 960));

}  // namespace
}  // namespace pickbed::tests
