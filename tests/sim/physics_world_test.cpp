#include "sim/physics_world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "scenes/friction.h"
#include "scenes/random.h"
#include "tests/sim/physics_parts.h"

namespace pickbed {
namespace {

using Eigen::Vector3d;

void StepFor(PhysicsWorld& world, double duration_s) {
  const int steps = static_cast<int>(std::lround(duration_s / world.step_s()));
  for (int i = 0; i < steps; ++i) world.Step();
}

void AddTable(PhysicsWorld& world, double friction = 0.5) {
  world.AddStaticBox(Translation({0, 0, -0.05}), {1, 1, 0.05}, friction);
}

Vector3d CenterOfMass(const PhysicsWorld& world, int part, const ObjectModel& model) {
  return world.X_WO(part) * model.mass.com_O;
}

Eigen::Matrix3d InertiaInWorld(const PhysicsWorld& world, int part, const ObjectModel& model) {
  const Eigen::Matrix3d R_WO = world.X_WO(part).linear();
  return R_WO * model.mass.inertia_com_O * R_WO.transpose();
}

double Energy(const PhysicsWorld& world, int part, const ObjectModel& model) {
  const Twist V = world.V_WO(part);
  return model.mass.mass_kg * (kGravity_mps2 * CenterOfMass(world, part, model).z() +
                               0.5 * V.linear_W.squaredNorm()) +
         0.5 * V.angular_W.dot(InertiaInWorld(world, part, model) * V.angular_W);
}

TEST(PhysicsWorld, PosesComeBackAsGiven) {
  Rng rng(5);
  PhysicsWorld world;
  const auto bracket = BracketPart();
  for (int i = 0; i < 10; ++i) {
    const Pose X_WO =
        MakePose(rng.Rotation().toRotationMatrix(), {rng.Normal(), rng.Normal(), rng.Normal()});
    const int part = world.AddPart(*bracket, X_WO);
    EXPECT_EQ(part, i);
    EXPECT_TRUE(world.X_WO(part).isApprox(X_WO, 1e-12));
  }
}

TEST(PhysicsWorld, FreeFallIsHalfGTimeSquared) {
  PhysicsWorld world;
  const auto bracket = BracketPart();
  world.AddPart(*bracket, Translation({0, 0, 1}));
  const double start_m = CenterOfMass(world, 0, *bracket).z();
  StepFor(world, 0.5);
  const double t = world.time_s();
  EXPECT_NEAR(t, 0.5, 1e-12);
  // The integrator is first order: off by g * t * step / 2.
  EXPECT_NEAR(start_m - CenterOfMass(world, 0, *bracket).z(),
              0.5 * kGravity_mps2 * t * (t + world.step_s()), 1e-9);
  EXPECT_NEAR(world.V_WO(0).linear_W.z(), -kGravity_mps2 * t, 1e-9);
}

TEST(PhysicsWorld, CenterOfMassOfATumblingPartFliesStraight) {
  PhysicsOptions options;
  options.gravity_W.setZero();
  PhysicsWorld world(options);
  const auto bracket = BracketPart();
  world.AddPart(*bracket, Pose::Identity(), BodyMode::kDynamic, {{0.3, -0.1, 0.2}, {3, 7, -5}});
  const Vector3d start = CenterOfMass(world, 0, *bracket);
  StepFor(world, 1);
  const Vector3d moved = CenterOfMass(world, 0, *bracket) - start;
  EXPECT_LT((moved - Vector3d(0.3, -0.1, 0.2)).norm(), 1e-9);
}

// Needs the whole inertia tensor, products included: an L has large ones about O's axes.
TEST(PhysicsWorld, TumblingKeepsItsAngularMomentum) {
  PhysicsOptions options;
  options.gravity_W.setZero();
  options.rate_hz = 2000;
  PhysicsWorld world(options);
  const auto bracket = BracketPart();
  world.AddPart(*bracket, Pose::Identity(), BodyMode::kDynamic, {Vector3d::Zero(), {3, 7, -5}});
  const auto momentum = [&] {
    return Vector3d(InertiaInWorld(world, 0, *bracket) * world.V_WO(0).angular_W);
  };
  const Vector3d before = momentum();
  StepFor(world, 0.5);
  EXPECT_LT((momentum() - before).norm(), 0.02 * before.norm());
}

// Largest rise of energy above its least value so far, as a share of the energy before the fall.
double WorstRiseOfEnergy(int seed, double rate_hz) {
  Rng rng(seed);
  PhysicsOptions options;
  options.rate_hz = rate_hz;
  PhysicsWorld world(options);
  AddTable(world);
  const ObjectSet parts = MixedParts();
  const ObjectModel& model = *parts[seed % parts.size()];
  world.AddPart(model, MakePose(rng.Rotation().toRotationMatrix(), {0, 0, 0.15}));
  const double start_j = Energy(world, 0, model);
  double least_j = start_j, rise_j = 0;
  while (world.time_s() < 2) {
    world.Step();
    const double now_j = Energy(world, 0, model);
    least_j = std::min(least_j, now_j);
    rise_j = std::max(rise_j, now_j - least_j);
  }
  EXPECT_LT(least_j, 0.6 * start_j);  // it did come to rest lower down
  return rise_j / start_j;
}

// An impact within one step leaves an overlap of up to speed * step, and pushing that out lends the
// part some height. So energy rises by little at 240 Hz, and not at all at a fine step.
TEST(PhysicsWorld, DroppedPartGainsNoEnergy) {
  for (int seed = 0; seed < 8; ++seed) {
    EXPECT_LT(WorstRiseOfEnergy(seed, 240), 0.06) << "seed " << seed;
    EXPECT_LT(WorstRiseOfEnergy(seed, 1920), 0.01) << "seed " << seed;
  }
}

// A block on a table under gravity tilted by `slope_rad`: how far it has slid after 1 s.
double SlideOnSlope_m(double slope_rad, double part_friction, double table_friction) {
  PhysicsOptions options;
  options.gravity_W = kGravity_mps2 * Vector3d(std::sin(slope_rad), 0, -std::cos(slope_rad));
  PhysicsWorld world(options);
  AddTable(world, table_friction);
  const auto block = BoxPart({0.06, 0.06, 0.02}, 0.2, part_friction);
  world.AddPart(*block, Translation({0, 0, 0.0105}));
  world.ForbidSleep();
  StepFor(world, 1);
  return world.X_WO(0).translation().x();
}

TEST(PhysicsWorld, BlockSlidesFromTheAngleOfFriction) {
  constexpr double kDegree = std::numbers::pi / 180;
  for (const auto& [part, table] : {std::pair{0.5, 1.0}, {0.8, 0.5}, {0.6, 0.6}}) {
    const double angle_rad = std::atan(PairFriction(part, table));
    EXPECT_LT(SlideOnSlope_m(angle_rad - kDegree, part, table), 0.001) << part << " " << table;
    EXPECT_GT(SlideOnSlope_m(angle_rad + kDegree, part, table), 0.01) << part << " " << table;
  }
}

TEST(PhysicsWorld, RestingPartsKeepNoMoreThanTheHullMargin) {
  for (const double size_m : {0.06, 0.01}) {
    PhysicsWorld world;
    AddTable(world);
    const auto cube = BoxPart(Vector3d::Constant(size_m), 0.05);
    world.AddPart(*cube, Translation({0, 0, size_m}));
    StepFor(world, 2);
    const double gap_m = world.X_WO(0).translation().z() - 0.5 * size_m;
    const double margin_m = 0.0005 * std::min(1.0, cube->diameter_m / 0.04);
    EXPECT_NEAR(gap_m, margin_m, 5e-5);
    EXPECT_TRUE(world.AllAsleep());
  }
}

TEST(PhysicsWorld, NothingFallsThroughAThinFloor) {
  PhysicsWorld world;
  Bin bin;
  bin.wall_m = 0.001;
  world.AddBin(bin);
  const auto plate = BoxPart({0.05, 0.05, 0.002}, 0.02);
  world.AddPart(*plate, Translation({0, 0, 0.1}), BodyMode::kDynamic,
                {{0, 0, -8}, Vector3d::Zero()});
  StepFor(world, 1);
  EXPECT_GT(world.X_WO(0).translation().z(), 0);
}

TEST(PhysicsWorld, StaticPartsStayAndCarry) {
  PhysicsWorld world;
  const auto cube = BoxPart(Vector3d::Constant(0.05), 0.1);
  world.AddPart(*cube, Pose::Identity(), BodyMode::kStatic);
  world.AddPart(*cube, Translation({0, 0, 0.06}));
  StepFor(world, 1);
  EXPECT_EQ(world.X_WO(0).translation().norm(), 0);
  EXPECT_NEAR(world.X_WO(1).translation().z(), 0.051, 2e-4);
}

TEST(PhysicsWorld, SleepersWakeWhenHit) {
  PhysicsWorld world;
  AddTable(world);
  const auto cube = BoxPart(Vector3d::Constant(0.05), 0.1);
  world.AddPart(*cube, Translation({0, 0, 0.0255}), BodyMode::kAsleep);
  StepFor(world, 0.2);
  EXPECT_TRUE(world.AllAsleep());
  world.AddPart(*cube, Translation({-0.1, 0, 0.026}), BodyMode::kDynamic,
                {{1.5, 0, 0}, Vector3d::Zero()});
  StepFor(world, 0.3);
  EXPECT_GT(world.X_WO(0).translation().x(), 0.005);
}

TEST(PhysicsWorld, SleepersFallWhenTheirSupportGoes) {
  PhysicsWorld world;
  AddTable(world);
  const auto cube = BoxPart(Vector3d::Constant(0.05), 0.1);
  world.AddPart(*cube, Translation({0, 0, 0.0255}));
  world.AddPart(*cube, Translation({0, 0, 0.0765}));
  StepFor(world, 2);
  ASSERT_TRUE(world.AllAsleep());
  world.RemovePart(0);
  StepFor(world, 1);
  EXPECT_NEAR(world.X_WO(1).translation().z(), 0.0255, 2e-4);
}

PhysicsOptions ReusingContacts() {
  PhysicsOptions options;
  options.contact_reuse_m = 0.0001;
  return options;
}

TEST(PhysicsWorld, ReusedContactsCarryAndLetGo) {
  PhysicsWorld world(ReusingContacts());
  AddTable(world);
  const auto cube = BoxPart(Vector3d::Constant(0.05), 0.1);
  world.AddPart(*cube, Translation({0, 0, 0.03}));
  world.AddPart(*cube, Translation({0, 0, 0.09}));
  world.ForbidSleep();
  StepFor(world, 2);
  EXPECT_NEAR(world.X_WO(0).translation().z(), 0.0255, 2e-4);
  EXPECT_NEAR(world.X_WO(1).translation().z(), 0.0765, 4e-4);
  world.RemovePart(0);
  StepFor(world, 1);
  EXPECT_NEAR(world.X_WO(1).translation().z(), 0.0255, 2e-4);
}

// A part that is pushed along reaches the next one, however slowly it goes.
TEST(PhysicsWorld, ReusedContactsDoNotMissASlowNeighbour) {
  PhysicsOptions options = ReusingContacts();
  options.gravity_W.setZero();
  PhysicsWorld world(options);
  const auto cube = BoxPart(Vector3d::Constant(0.05), 0.1);
  world.AddPart(*cube, Pose::Identity());
  world.AddPart(*cube, Translation({0.056, 0, 0}), BodyMode::kDynamic,
                {{-0.01, 0, 0}, Vector3d::Zero()});
  world.ForbidSleep();
  StepFor(world, 2);
  EXPECT_LT(world.X_WO(0).translation().x(), -0.001);
  EXPECT_GT((world.X_WO(1).translation() - world.X_WO(0).translation()).norm(), 0.05);
}

TEST(PhysicsWorld, ForgettingContactsWakesAllAndLeavesThemStanding) {
  PhysicsWorld world(ReusingContacts());
  AddTable(world);
  const auto cube = BoxPart(Vector3d::Constant(0.05), 0.1);
  world.AddPart(*cube, Translation({0, 0, 0.0255}));
  world.AddPart(*cube, Translation({0, 0, 0.0765}));
  StepFor(world, 2);
  ASSERT_TRUE(world.AllAsleep());
  world.ForgetContacts();
  EXPECT_FALSE(world.AllAsleep());
  StepFor(world, 1);
  EXPECT_NEAR(world.X_WO(1).translation().z(), 0.0765, 4e-4);
}

TEST(PhysicsWorld, PartOnTheFunnelsWallFallsWhenItGoes) {
  PhysicsWorld world;
  Bin bin;
  world.AddBin(bin);
  world.AddFunnel(bin, 0.1);
  const double top_m = bin.inner_size_m.z() + 0.1;
  const auto cube = BoxPart(Vector3d::Constant(0.03), 0.1);
  world.AddPart(*cube, Translation({0.22, 0, top_m + 0.016}));
  StepFor(world, 2);
  ASSERT_TRUE(world.AllAsleep());
  EXPECT_GT(world.X_WO(0).translation().z(), top_m);
  world.RemoveFunnel();
  StepFor(world, 0.5);
  EXPECT_LT(world.X_WO(0).translation().z(), top_m - 0.05);
}

TEST(PhysicsWorld, AwakeWhenSleepIsForbidden) {
  PhysicsWorld world;
  AddTable(world);
  world.AddPart(*BoxPart(Vector3d::Constant(0.05), 0.1), Translation({0, 0, 0.0255}));
  world.ForbidSleep();
  StepFor(world, 3);
  EXPECT_FALSE(world.AllAsleep());
}

TEST(PhysicsWorld, TellsWhenItBlewUp) {
  PhysicsWorld world;
  const auto cube = BoxPart(Vector3d::Constant(0.05), 0.1);
  world.AddPart(*cube, Pose::Identity(), BodyMode::kDynamic, {{49, 0, 0}, Vector3d::Zero()});
  EXPECT_FALSE(world.BlewUp());
  world.AddPart(*cube, Translation({1, 0, 0}), BodyMode::kDynamic, {{51, 0, 0}, Vector3d::Zero()});
  EXPECT_TRUE(world.BlewUp());
}

TEST(PhysicsWorld, PartWithoutPiecesIsOurMistake) {
  PhysicsWorld world;
  ObjectModel bare = *BracketPart();
  bare.convex_parts_O.clear();
  EXPECT_THROW(world.AddPart(bare, Pose::Identity()), std::logic_error);
}

// A heap that is still in motion, as poses and velocities.
struct Snapshot {
  std::vector<Pose> X_WO;
  std::vector<Twist> V_WO;
};

Snapshot Take(const PhysicsWorld& world) {
  Snapshot snapshot;
  for (int i = 0; i < world.part_count(); ++i) {
    snapshot.X_WO.push_back(world.X_WO(i));
    snapshot.V_WO.push_back(world.V_WO(i));
  }
  return snapshot;
}

std::unique_ptr<PhysicsWorld> Build(const Snapshot& snapshot, const ObjectSet& parts) {
  auto world = std::make_unique<PhysicsWorld>();
  world->AddBin(Bin{});
  for (size_t i = 0; i < snapshot.X_WO.size(); ++i) {
    world->AddPart(*parts[i % parts.size()], snapshot.X_WO[i], BodyMode::kDynamic,
                   snapshot.V_WO[i]);
  }
  return world;
}

Snapshot Heap() {
  Rng rng(9);
  Snapshot heap;
  for (int i = 0; i < 12; ++i) {
    heap.X_WO.push_back(
        MakePose(rng.Rotation().toRotationMatrix(),
                 {rng.Uniform(-0.05, 0.05), rng.Uniform(-0.05, 0.05), 0.1 + 0.12 * i}));
    heap.V_WO.push_back({});
  }
  return heap;
}

bool SameBits(const Snapshot& a, const Snapshot& b) {
  for (size_t i = 0; i < a.X_WO.size(); ++i) {
    if (a.X_WO[i].matrix() != b.X_WO[i].matrix()) return false;
    if (a.V_WO[i].linear_W != b.V_WO[i].linear_W) return false;
    if (a.V_WO[i].angular_W != b.V_WO[i].angular_W) return false;
  }
  return true;
}

TEST(PhysicsWorldDeterminism, RebuiltWorldRepeatsBitByBit) {
  const ObjectSet parts = MixedParts();
  const auto first = Build(Heap(), parts);
  StepFor(*first, 0.5);
  const Snapshot midway = Take(*first);
  std::vector<Snapshot> ends;
  for (int i = 0; i < 2; ++i) {
    const auto rebuilt = Build(midway, parts);
    StepFor(*rebuilt, 0.5);
    ends.push_back(Take(*rebuilt));
  }
  EXPECT_TRUE(SameBits(ends[0], ends[1]));
  EXPECT_FALSE(SameBits(ends[0], midway));
}

TEST(PhysicsWorldDeterminism, WorldsDoNotDisturbEachOther) {
  const ObjectSet parts = MixedParts();
  const auto alone = Build(Heap(), parts);
  StepFor(*alone, 1);
  const Snapshot expected = Take(*alone);

  PhysicsOptions other_options;
  other_options.rate_hz = 120;
  other_options.sleep_after_s = 0.1;
  PhysicsWorld other(other_options);
  other.AddBin(Bin{});
  const auto world = Build(Heap(), parts);
  for (int i = 0; i < 240; ++i) {
    if (i % 30 == 0) other.AddPart(*parts[1], Translation({0, 0, 0.2 + 0.001 * i}));
    other.Step();
    world->Step();
  }
  EXPECT_TRUE(SameBits(Take(*world), expected));
}

}  // namespace
}  // namespace pickbed
