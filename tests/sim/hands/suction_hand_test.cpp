#include "sim/hands/suction_hand.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/hands/suction_seal.h"
#include "sim/physics/physics_world.h"
#include "tests/sim/hand_paths.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

constexpr double kTop_m = 0.05;

// A box of 8 x 8 x 5 cm on a table, and a cup above it, `offset_m` beside its center along x.
struct CupOnBox {
  std::shared_ptr<const ObjectModel> box;
  PhysicsWorld world;
  Hand* hand = nullptr;
  double offset_m = 0;
  double hand_z_m = kTop_m + 0.03;

  CupOnBox(const CupSpec& spec, double mass_kg, double aside_m = 0)
      : box(BoxObject({0.08, 0.08, kTop_m}, mass_kg, 0.6)), offset_m(aside_m) {
    world.AddStaticBox(Translation({0, 0, -0.05}), {0.5, 0.5, 0.05}, 0.5);
    world.AddInstance(*box, Translation({0, 0, 0.5 * kTop_m + 0.0005}));
    hand = &AddSuctionHand(world, spec, HandPose());
  }
  Pose HandPose() const { return HandOver({offset_m, 0, hand_z_m}); }
  double box_z_m() const { return world.X_WO(0).translation().z() - 0.5 * kTop_m; }

  void MoveTo(double z_m, double duration_s) {
    hand_z_m = z_m;
    MoveAlongMinimumJerk(world, *hand, HandPose(), duration_s);
  }
  void RunFor(double duration_s) { Stay(world, *hand, HandPose(), duration_s); }
  // Lowers the cup to the compression and switches the vacuum on.
  void Attach(double compression_m) {
    MoveTo(kTop_m - compression_m, 0.3);
    hand->Close();
    RunFor(0.1);
  }
};

TEST(Cup, SealedCupHoldsAndLiftsWithoutSag) {
  CupOnBox cup(CupSpec{}, 0.2);
  cup.Attach(0.003);
  ASSERT_TRUE(cup.hand->Holds());
  EXPECT_NEAR(cup.hand->opening_m(), CupSpec{}.bellows_travel_m - 0.003, 6e-4);
  const double before_m = cup.box_z_m();
  cup.MoveTo(kTop_m + 0.1, 0.8);
  cup.RunFor(1.0);
  EXPECT_TRUE(cup.hand->Holds());
  EXPECT_EQ(cup.world.InstancesTouchingHand(), std::vector<int>{0});
  EXPECT_NEAR(cup.box_z_m() - before_m, 0.103, 1e-4);
}

TEST(Cup, HoldsOnlyWhileTheVacuumIsOn) {
  CupOnBox cup(CupSpec{}, 0.2);
  cup.MoveTo(kTop_m - 0.003, 0.3);
  EXPECT_FALSE(cup.hand->Holds());
  cup.hand->Close();
  cup.RunFor(0.1);
  cup.MoveTo(kTop_m + 0.1, 0.8);
  ASSERT_GT(cup.box_z_m(), 0.09);
  cup.hand->HoldOpening(0);
  cup.RunFor(0.5);
  EXPECT_FALSE(cup.hand->Holds());
  EXPECT_LT(cup.box_z_m(), 0.01);
}

TEST(Cup, DoesNotSealAboveTheSurfaceOrAcrossAnEdge) {
  CupOnBox high(CupSpec{}, 0.2);
  high.Attach(-0.003);
  EXPECT_FALSE(high.hand->Holds());
  CupOnBox beside(CupSpec{}, 0.2, 0.03);  // the lip extends 5 mm beyond the edge
  beside.Attach(0.003);
  EXPECT_FALSE(beside.hand->Holds());
}

// Without vacuum the bellows presses like a spring.
TEST(Cup, UnsealedBellowsPressesLikeASpring) {
  CupSpec spec;
  CupOnBox cup(spec, 0.2);
  cup.MoveTo(kTop_m + 0.0005 - 0.004, 0.3);
  cup.RunFor(0.3);
  EXPECT_NEAR(cup.hand->ContactForces_n()[0], spec.bellows_npm * 0.004, 0.1);
  EXPECT_EQ(cup.hand->ContactForces_n()[1], 0);
  EXPECT_EQ(cup.world.InstancesTouchingHand(), std::vector<int>{0});
}

TEST(Cup, StemStopsOnTheBox) {
  CupSpec spec;
  CupOnBox cup(spec, 0.2);
  cup.MoveTo(kTop_m - spec.bellows_travel_m - 0.0005, 0.3);
  EXPECT_GT(cup.hand->ContactForces_n()[1], 5);
}

// Pull: compares vacuum_n with m (g + a), with the acceleration held for 0.4 s.
class CupPull : public ::testing::TestWithParam<double> {};

TEST_P(CupPull, BreaksAtTheVacuumForce) {
  const double ratio = GetParam();
  constexpr double kMass_kg = 1.0, kLift_mps2 = 1.0;
  CupSpec spec;
  spec.moment_limit_nm = 10;
  spec.vacuum_n = ratio * kMass_kg * (kGravity_mps2 + kLift_mps2);
  CupOnBox cup(spec, kMass_kg);
  cup.Attach(0.003);
  AccelerateFor(cup.world, *cup.hand, {0, 0, kLift_mps2}, 0.4);
  EXPECT_EQ(cup.hand->Holds(), ratio > 1);
  EXPECT_EQ(cup.box_z_m() > 0.05, ratio > 1);
}
INSTANTIATE_TEST_SUITE_P(Ratios, CupPull, ::testing::Values(0.7, 0.94, 1.06, 1.5));

// Moment: a weight beside the cup gives m g d. The lift is slow, because the lift-off of a box that
// still touches the table with its far edge shakes it.
class CupMoment : public ::testing::TestWithParam<double> {};

TEST_P(CupMoment, BreaksAtTheMomentLimit) {
  const double ratio = GetParam();
  constexpr double kMass_kg = 0.8, kAside_m = 0.02;
  CupSpec spec;
  spec.vacuum_n = 1000;
  spec.moment_limit_nm = ratio * kMass_kg * kGravity_mps2 * kAside_m;
  CupOnBox cup(spec, kMass_kg, kAside_m);
  cup.Attach(0.003);
  cup.MoveTo(kTop_m + 0.05, 3.0);
  cup.RunFor(0.5);
  EXPECT_EQ(cup.hand->Holds(), ratio > 1) << "box at " << cup.box_z_m();
}
INSTANTIATE_TEST_SUITE_P(Ratios, CupMoment, ::testing::Values(0.7, 0.94, 1.06, 1.5));

// Pull and moment add up: a load of half of each limit reaches the limit.
TEST(Cup, PullAndMomentLoadsAddUp) {
  constexpr double kMass_kg = 0.8, kAside_m = 0.012, kWeight_n = kMass_kg * kGravity_mps2;
  for (const double share : {0.9, 1.1}) {
    CupSpec spec;
    spec.vacuum_n = 2 * share * kWeight_n;
    spec.moment_limit_nm = 2 * share * kWeight_n * kAside_m;
    CupOnBox cup(spec, kMass_kg, kAside_m);
    cup.Attach(0.003);
    cup.MoveTo(kTop_m + 0.05, 3.0);
    cup.RunFor(0.5);
    EXPECT_EQ(cup.hand->Holds(), share > 1) << share;
  }
}

// Sideways: the remaining force, vacuum_n minus m g, holds by friction against m a.
TEST(Cup, SlipsSidewaysBeyondFriction) {
  constexpr double kMass_kg = 0.5, kSide_mps2 = 4;
  for (const double share : {0.94, 1.06}) {
    CupSpec spec;
    spec.moment_limit_nm = 100;
    const double grip_n = share * kMass_kg * kSide_mps2 / (0.6 * spec.friction);
    spec.vacuum_n = grip_n + kMass_kg * kGravity_mps2;
    CupOnBox cup(spec, kMass_kg);
    cup.Attach(0.003);
    cup.MoveTo(kTop_m + 0.05, 1.0);
    ASSERT_TRUE(cup.hand->Holds());
    cup.RunFor(0.2);
    AccelerateFor(cup.world, *cup.hand, {kSide_mps2, 0, 0}, 0.4);
    EXPECT_EQ(cup.hand->Holds(), share > 1) << share;
  }
}

TEST(Cup, LostBoxIsHeldAgainOnlyAfterVacuumOff) {
  CupSpec spec;
  spec.vacuum_n = 15;
  CupOnBox cup(spec, 1.0);
  cup.Attach(0.003);
  cup.MoveTo(kTop_m + 0.05, 0.15);  // up to 13 m/s^2
  EXPECT_FALSE(cup.hand->Holds());
  cup.MoveTo(kTop_m - 0.003, 0.5);
  cup.RunFor(0.1);
  EXPECT_FALSE(cup.hand->Holds());
  cup.hand->HoldOpening(0);
  cup.hand->Close();
  cup.RunFor(0.1);
  EXPECT_TRUE(cup.hand->Holds());
}

TEST(Cup, RemovedBoxIsReleased) {
  CupOnBox cup(CupSpec{}, 0.2);
  cup.Attach(0.003);
  ASSERT_TRUE(cup.hand->Holds());
  cup.world.RemoveInstance(0);
  cup.RunFor(0.1);
  EXPECT_FALSE(cup.hand->Holds());
  EXPECT_TRUE(cup.world.InstancesTouchingHand().empty());
}

TEST(Cup, RepeatsExactly) {
  const auto height = [] {
    CupOnBox cup(CupSpec{}, 0.7, 0.01);
    cup.Attach(0.002);
    cup.MoveTo(kTop_m + 0.1, 0.4);
    return cup.world.X_WO(0).matrix().eval();
  };
  EXPECT_EQ(height(), height());
}

}  // namespace
}  // namespace pickbed::tests
