#include "sim/hands/jaw_hand.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/physics/physics_world.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

// Returns the pose of a hand that points straight down, with its finger tips at height z.
Pose HandAbove(double z_m) {
  return MakePose(Eigen::Vector3d(1, -1, -1).asDiagonal(), {0, 0, z_m});
}

// A world with a box of 5 cm and 0.2 kg on a table, between the open fingers of a hand.
struct HeldBox {
  static constexpr double kMass_kg = 0.2;
  static constexpr double kFriction = 0.6;
  std::shared_ptr<const ObjectModel> box;
  PhysicsWorld world;
  Hand* hand = nullptr;
  double hand_z_m = 0.02;

  explicit HeldBox(double force_n, double mass_kg = kMass_kg)
      : box(BoxObject({0.05, 0.05, 0.05}, mass_kg, kFriction)) {
    world.AddStaticBox(Translation({0, 0, -0.05}), {0.5, 0.5, 0.05}, 0.5);
    world.AddInstance(*box, Translation({0, 0, 0.0255}));
    HandSpec spec;
    spec.force_n = force_n;
    hand = &AddJawHand(world, spec, HandAbove(hand_z_m));
  }

  void RunFor(double duration_s) {
    const double end_s = world.time_s() + duration_s - 0.5 * world.step_s();
    while (world.time_s() < end_s) {
      hand->MoveTo(HandAbove(hand_z_m));
      world.Step();
    }
  }

  // Peak acceleration of a minimum-jerk lift (Flash and Hogan 1985): 10 / sqrt(3) * height / T^2.
  static double PeakAcceleration(double height_m, double duration_s) {
    return 10 / std::sqrt(3.0) * height_m / (duration_s * duration_s);
  }
  void Lift(double height_m, double duration_s) {
    const double start_s = world.time_s(), from_z_m = hand_z_m;
    while (world.time_s() < start_s + duration_s - 0.5 * world.step_s()) {
      const double t = std::min(1.0, (world.time_s() + world.step_s() - start_s) / duration_s);
      hand_z_m = from_z_m + height_m * t * t * t * (10 - 15 * t + 6 * t * t);
      hand->MoveTo(HandAbove(hand_z_m));
      world.Step();
    }
  }
  double box_z_m() const { return world.X_WO(0).translation().z(); }
};

TEST(HandBoxes, PadDistanceIsTheOpeningAndTipsAreAtTheOrigin) {
  const HandSpec spec;
  const std::vector<AxisAlignedBox> boxes = HandBoxes(spec, 0.03);
  ASSERT_EQ(boxes.size(), 3u);
  EXPECT_NEAR(boxes[0].center.x() + boxes[0].half_size.x(), -0.015, 1e-12);
  EXPECT_NEAR(boxes[1].center.x() - boxes[1].half_size.x(), 0.015, 1e-12);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(boxes[i].center.z() + boxes[i].half_size.z(), 0, 1e-12);
  EXPECT_NEAR(boxes[2].center.z() + boxes[2].half_size.z(), -spec.finger_size_m.z(), 1e-12);
}

TEST(Hand, ClosesWithoutObjectUntilTheFingersMeet) {
  PhysicsWorld world;
  const HandSpec spec;
  Hand& hand = AddJawHand(world, spec, HandAbove(0.3));
  EXPECT_NEAR(hand.opening_m(), spec.stroke_m, 1e-9);
  hand.Close();
  for (int i = 0; i < 240; ++i) {
    hand.MoveTo(HandAbove(0.3));
    world.Step();
  }
  EXPECT_NEAR(hand.opening_m(), 0, 5e-5);
}

TEST(Hand, ClosesAtTheConfiguredSpeed) {
  PhysicsWorld world;
  HandSpec spec;
  Hand& hand = AddJawHand(world, spec, HandAbove(0.3));
  hand.Close();
  for (int i = 0; i < 48; ++i) {  // 0.2 s
    hand.MoveTo(HandAbove(0.3));
    world.Step();
  }
  EXPECT_NEAR(hand.opening_m(), spec.stroke_m - 2 * spec.close_speed_mps * 0.2, 1e-3);
}

TEST(Hand, HoldsAnOpening) {
  PhysicsWorld world;
  Hand& hand = AddJawHand(world, HandSpec{}, HandAbove(0.3));
  for (const double opening_m : {0.05, 0.02, 0.07}) {
    hand.HoldOpening(opening_m);
    for (int i = 0; i < 240; ++i) {
      hand.MoveTo(HandAbove(0.3));
      world.Step();
    }
    EXPECT_NEAR(hand.opening_m(), opening_m, 1e-4);
  }
}

TEST(Hand, FingersFollowThePalmWithoutLag) {
  PhysicsWorld world;
  Hand& hand = AddJawHand(world, HandSpec{}, HandAbove(0.3));
  hand.HoldOpening(0.04);
  double worst_m = 0;
  for (int i = 1; i <= 240; ++i) {
    const double t = i * world.step_s();
    const Pose X_WG = MakePose(
        (HandAbove(0).linear() * Eigen::AngleAxisd(0.8 * t, Eigen::Vector3d::UnitZ())).eval(),
        {0.1 * t, 0.05 * t * t, 0.3 + 0.1 * t});
    hand.MoveTo(X_WG);
    world.Step();
    EXPECT_TRUE(hand.X_WG().isApprox(X_WG, 1e-12));
    if (t > 0.5) worst_m = std::max(worst_m, std::abs(hand.opening_m() - 0.04));
  }
  EXPECT_LT(worst_m, 1e-4);
}

TEST(Hand, PressesWithTheConfiguredForceOnBothSides) {
  for (const double force_n : {5.0, 20.0, 40.0}) {
    HeldBox held(force_n);
    held.hand->Close();
    held.RunFor(0.6);
    held.Lift(0.10, 1.0);
    held.RunFor(0.5);
    for (const double contact_n : held.hand->ContactForces_n()) {
      EXPECT_NEAR(contact_n, force_n, 0.1);
    }
    EXPECT_EQ(held.world.InstancesTouchingHand(), std::vector<int>{0});
    EXPECT_NEAR(held.hand->opening_m(), 0.05, 0.0015);
  }
}

// The force must not swing from step to step, whether the object is lighter or heavier than a
// finger.
TEST(Hand, ForceOnAHeldBoxIsSteady) {
  for (const double mass_kg : {0.02, 0.2, 1.0}) {
    HeldBox held(40, mass_kg);
    held.hand->Close();
    held.RunFor(0.6);
    held.Lift(0.10, 1.0);
    held.RunFor(0.5);
    double low_n = 1e9, high_n = 0;
    for (int i = 0; i < 120; ++i) {
      held.RunFor(held.world.step_s());
      const double contact_n = held.hand->ContactForces_n()[0];
      low_n = std::min(low_n, contact_n);
      high_n = std::max(high_n, contact_n);
    }
    EXPECT_NEAR(low_n, 40, 0.2) << mass_kg;
    EXPECT_NEAR(high_n, 40, 0.2) << mass_kg;
  }
}

TEST(Hand, HasNoContactBeforeItCloses) {
  HeldBox held(20);
  held.RunFor(0.2);
  EXPECT_TRUE(held.world.InstancesTouchingHand().empty());
  EXPECT_EQ(held.hand->ContactForces_n()[0], 0);
}

TEST(Hand, HeldBoxDoesNotCreep) {
  HeldBox held(20);
  held.hand->Close();
  held.RunFor(0.6);
  held.Lift(0.10, 1.0);
  held.RunFor(0.5);
  const double before_m = held.box_z_m();
  held.RunFor(2.0);
  EXPECT_NEAR(held.box_z_m(), before_m, 1e-5);
}

// The box is held if 2 * mu * F > m * (g + a).
class HoldLimit : public ::testing::TestWithParam<double> {};

TEST_P(HoldLimit, MatchesTheFrictionFormula) {
  const double ratio = GetParam();
  constexpr double kLift_m = 0.10, kLift_s = 1.5;
  const double weight_n =
      HeldBox::kMass_kg * (kGravity_mps2 + HeldBox::PeakAcceleration(kLift_m, kLift_s));
  HeldBox held(ratio * weight_n / (2 * HeldBox::kFriction));
  held.hand->Close();
  held.RunFor(0.6);
  const double from_m = held.box_z_m();
  held.Lift(kLift_m, kLift_s);
  held.RunFor(1.0);
  if (ratio > 1) {
    EXPECT_NEAR(held.box_z_m(), from_m + kLift_m, 0.001);
  } else {
    EXPECT_LT(held.box_z_m(), from_m + 0.5 * kLift_m);
  }
}
INSTANTIATE_TEST_SUITE_P(Ratios, HoldLimit, ::testing::Values(0.7, 0.94, 1.06, 1.5));

TEST(Hand, FingersStopAtWalls) {
  PhysicsWorld world;
  world.AddStaticBox(Translation({0.05, 0, 0.3}), {0.01, 0.2, 0.2}, 0.5);
  Hand& hand = AddJawHand(world, HandSpec{}, HandAbove(0.3));
  hand.HoldOpening(0.02);
  for (int i = 0; i < 240; ++i) {
    hand.MoveTo(HandAbove(0.3));
    world.Step();
  }
  hand.HoldOpening(0.08);  // free fingers would reach x = 0.05; the wall starts at 0.04
  for (int i = 0; i < 240; ++i) {
    hand.MoveTo(HandAbove(0.3));
    world.Step();
  }
  EXPECT_NEAR(hand.opening_m(), 0.06, 5e-4);
  EXPECT_TRUE(world.InstancesTouchingHand().empty());
}

// A column of rigid cubes does not get shorter under a finger that is ten times as heavy. The
// finger yields by the rest of its path, for any step length. Bodies may overlap by at most 0.5 mm.
TEST(Hand, ColumnOfLightCubesStopsAFinger) {
  constexpr int kCubes = 4;
  constexpr double kCube_m = 0.02, kBeyond_m = 0.004;
  const auto cube = BoxObject(Eigen::Vector3d::Constant(kCube_m), 0.02, 0.5);
  for (const double rate_hz : {240.0, 960.0}) {
    PhysicsOptions options;
    options.recover_share *= options.rate_hz / rate_hz;
    options.rate_hz = rate_hz;
    PhysicsWorld world(options);
    world.AddStaticBox(Translation({0, 0, -0.05}), {0.2, 0.2, 0.05}, 0.5);
    const double finger_x_m = 0.5 * (HandSpec{}.stroke_m + HandSpec{}.finger_size_m.x());
    for (int i = 0; i < kCubes; ++i) {
      world.AddInstance(*cube, Translation({-finger_x_m, 0, (i + 0.5) * 1.02 * kCube_m}));
    }
    Hand& hand = AddJawHand(world, HandSpec{}, HandAbove(0.12));
    const auto move = [&](double from_m, double to_m, double duration_s) {
      const long steps = std::lround(duration_s * rate_hz);
      for (long i = 1; i <= steps; ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(steps);
        hand.MoveTo(HandAbove(from_m + share * (to_m - from_m)));
        world.Step();
      }
    };
    move(0.12, 0.12, 0.5);
    const double top_m = world.X_WO(kCubes - 1).translation().z();
    const double surface_m = top_m + 0.5 * kCube_m;
    move(0.12, surface_m - kBeyond_m, 0.2);
    EXPECT_NEAR(world.X_WO(kCubes - 1).translation().z(), top_m, 5e-4) << rate_hz;
    EXPECT_NEAR(hand.yielded_m(), kBeyond_m, 6e-4) << rate_hz;
  }
}

}  // namespace
}  // namespace pickbed::tests
