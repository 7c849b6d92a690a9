#include "sim/physics/physics_world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "scenes/base/random.h"
#include "scenes/objects/contact.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

void StepFor(PhysicsWorld& world, double duration_s) {
  const int steps = static_cast<int>(std::lround(duration_s / world.step_s()));
  for (int i = 0; i < steps; ++i) world.Step();
}

void AddTable(PhysicsWorld& world, double friction = 0.5) {
  world.AddStaticBox(Translation({0, 0, -0.05}), {1, 1, 0.05}, friction);
}

Vector3d CenterOfMass(const PhysicsWorld& world, int body, const ObjectModel& model) {
  return world.X_WO(body) * model.mass.com_O;
}

Eigen::Matrix3d InertiaInWorld(const PhysicsWorld& world, int body, const ObjectModel& model) {
  const Eigen::Matrix3d R_WO = world.X_WO(body).linear();
  return R_WO * model.mass.inertia_com_O * R_WO.transpose();
}

double Energy(const PhysicsWorld& world, int body, const ObjectModel& model) {
  const Twist V = world.V_WO(body);
  return model.mass.mass_kg * (kGravity_mps2 * CenterOfMass(world, body, model).z() +
                               0.5 * V.linear_W.squaredNorm()) +
         0.5 * V.angular_W.dot(InertiaInWorld(world, body, model) * V.angular_W);
}

TEST(PhysicsWorld, PosesAreReturnedAsGiven) {
  Rng rng(5);
  PhysicsWorld world;
  const auto bracket = BracketObject();
  for (int i = 0; i < 10; ++i) {
    const Pose X_WO =
        MakePose(rng.Rotation().toRotationMatrix(), {rng.Normal(), rng.Normal(), rng.Normal()});
    const int body = world.AddInstance(*bracket, X_WO);
    EXPECT_EQ(body, i);
    EXPECT_TRUE(world.X_WO(body).isApprox(X_WO, 1e-12));
  }
}

TEST(PhysicsWorld, FreeFallMatchesTheFormula) {
  PhysicsWorld world;
  const auto bracket = BracketObject();
  world.AddInstance(*bracket, Translation({0, 0, 1}));
  const double start_m = CenterOfMass(world, 0, *bracket).z();
  StepFor(world, 0.5);
  const double t = world.time_s();
  EXPECT_NEAR(t, 0.5, 1e-12);
  // The integrator is first order; its error is g * t * step / 2.
  EXPECT_NEAR(start_m - CenterOfMass(world, 0, *bracket).z(),
              0.5 * kGravity_mps2 * t * (t + world.step_s()), 1e-9);
  EXPECT_NEAR(world.V_WO(0).linear_W.z(), -kGravity_mps2 * t, 1e-9);
}

TEST(PhysicsWorld, CenterOfMassOfATumblingBodyMovesStraight) {
  PhysicsOptions options;
  options.gravity_W.setZero();
  PhysicsWorld world(options);
  const auto bracket = BracketObject();
  world.AddInstance(*bracket, Pose::Identity(), BodyMode::kDynamic, {{0.3, -0.1, 0.2}, {3, 7, -5}});
  const Vector3d start = CenterOfMass(world, 0, *bracket);
  StepFor(world, 1);
  const Vector3d moved = CenterOfMass(world, 0, *bracket) - start;
  EXPECT_LT((moved - Vector3d(0.3, -0.1, 0.2)).norm(), 1e-9);
}

// This needs the whole inertia tensor: an L has large products of inertia about the axes of O.
TEST(PhysicsWorld, TumblingConservesAngularMomentum) {
  PhysicsOptions options;
  options.gravity_W.setZero();
  options.rate_hz = 2000;
  PhysicsWorld world(options);
  const auto bracket = BracketObject();
  world.AddInstance(*bracket, Pose::Identity(), BodyMode::kDynamic, {Vector3d::Zero(), {3, 7, -5}});
  const auto momentum = [&] {
    return Vector3d(InertiaInWorld(world, 0, *bracket) * world.V_WO(0).angular_W);
  };
  const Vector3d before = momentum();
  StepFor(world, 0.5);
  EXPECT_LT((momentum() - before).norm(), 0.02 * before.norm());
}

// Returns the largest rise of energy above its previous minimum, as a fraction of the energy before
// the fall.
double LargestEnergyRise(int seed, double rate_hz) {
  Rng rng(seed);
  PhysicsOptions options;
  options.rate_hz = rate_hz;
  PhysicsWorld world(options);
  AddTable(world);
  const ObjectSet objects = MixedObjects();
  const ObjectModel& model = *objects[seed % objects.size()];
  world.AddInstance(model, MakePose(rng.Rotation().toRotationMatrix(), {0, 0, 0.15}));
  const double start_j = Energy(world, 0, model);
  double min_j = start_j, rise_j = 0;
  while (world.time_s() < 2) {
    world.Step();
    const double now_j = Energy(world, 0, model);
    min_j = std::min(min_j, now_j);
    rise_j = std::max(rise_j, now_j - min_j);
  }
  EXPECT_LT(min_j, 0.6 * start_j);  // it fell
  return rise_j / start_j;
}

// An impact within one step leaves an overlap of up to speed * step. The correction of the overlap
// lifts the body. So energy rises slightly at 240 Hz, and not at a fine step.
TEST(PhysicsWorld, DroppedBodyGainsNoEnergy) {
  for (int seed = 0; seed < 8; ++seed) {
    EXPECT_LT(LargestEnergyRise(seed, 240), 0.06) << "seed " << seed;
    EXPECT_LT(LargestEnergyRise(seed, 1920), 0.01) << "seed " << seed;
  }
}

// Returns how far a block has slid after 1 s on a table under gravity tilted by `slope_rad`, in
// metres.
double SlideOnSlope_m(double slope_rad, double object_friction, double table_friction) {
  PhysicsOptions options;
  options.gravity_W = kGravity_mps2 * Vector3d(std::sin(slope_rad), 0, -std::cos(slope_rad));
  PhysicsWorld world(options);
  AddTable(world, table_friction);
  const auto block = BoxObject({0.06, 0.06, 0.02}, 0.2, object_friction);
  world.AddInstance(*block, Translation({0, 0, 0.0105}));
  world.ForbidSleep();
  StepFor(world, 1);
  return world.X_WO(0).translation().x();
}

TEST(PhysicsWorld, BlockSlidesAboveTheAngleOfFriction) {
  constexpr double kDegree = std::numbers::pi / 180;
  for (const auto& [body, table] : {std::pair{0.5, 1.0}, {0.8, 0.5}, {0.6, 0.6}}) {
    const double angle_rad = std::atan(PairFriction(body, table));
    EXPECT_LT(SlideOnSlope_m(angle_rad - kDegree, body, table), 0.001) << body << " " << table;
    EXPECT_GT(SlideOnSlope_m(angle_rad + kDegree, body, table), 0.01) << body << " " << table;
  }
}

TEST(PhysicsWorld, RestingGapIsTheHullMargin) {
  for (const double size_m : {0.06, 0.01}) {
    PhysicsWorld world;
    AddTable(world);
    const auto cube = BoxObject(Vector3d::Constant(size_m), 0.05);
    world.AddInstance(*cube, Translation({0, 0, size_m}));
    StepFor(world, 2);
    const double gap_m = world.X_WO(0).translation().z() - 0.5 * size_m;
    const double margin_m = 0.0005 * std::min(1.0, cube->diameter_m / 0.04);
    EXPECT_NEAR(gap_m, margin_m, 5e-5);
    EXPECT_TRUE(world.AllAsleep());
  }
}

TEST(PhysicsWorld, FastPlateDoesNotPassThroughAThinFloor) {
  PhysicsWorld world;
  Bin bin;
  bin.wall_m = 0.001;
  world.AddBin(bin);
  const auto plate = BoxObject({0.05, 0.05, 0.002}, 0.02);
  world.AddInstance(*plate, Translation({0, 0, 0.1}), BodyMode::kDynamic,
                    {{0, 0, -8}, Vector3d::Zero()});
  StepFor(world, 1);
  EXPECT_GT(world.X_WO(0).translation().z(), 0);
}

TEST(PhysicsWorld, StaticBodiesStayAndCarry) {
  PhysicsWorld world;
  const auto cube = BoxObject(Vector3d::Constant(0.05), 0.1);
  world.AddInstance(*cube, Pose::Identity(), BodyMode::kStatic);
  world.AddInstance(*cube, Translation({0, 0, 0.06}));
  StepFor(world, 1);
  EXPECT_EQ(world.X_WO(0).translation().norm(), 0);
  EXPECT_NEAR(world.X_WO(1).translation().z(), 0.051, 2e-4);
}

TEST(PhysicsWorld, SleepingBodiesWakeWhenHit) {
  PhysicsWorld world;
  AddTable(world);
  const auto cube = BoxObject(Vector3d::Constant(0.05), 0.1);
  world.AddInstance(*cube, Translation({0, 0, 0.0255}), BodyMode::kAsleep);
  StepFor(world, 0.2);
  EXPECT_TRUE(world.AllAsleep());
  world.AddInstance(*cube, Translation({-0.1, 0, 0.026}), BodyMode::kDynamic,
                    {{1.5, 0, 0}, Vector3d::Zero()});
  StepFor(world, 0.3);
  EXPECT_GT(world.X_WO(0).translation().x(), 0.005);
}

TEST(PhysicsWorld, SleepingBodiesFallWhenTheirSupportIsRemoved) {
  PhysicsWorld world;
  AddTable(world);
  const auto cube = BoxObject(Vector3d::Constant(0.05), 0.1);
  world.AddInstance(*cube, Translation({0, 0, 0.0255}));
  world.AddInstance(*cube, Translation({0, 0, 0.0765}));
  StepFor(world, 2);
  ASSERT_TRUE(world.AllAsleep());
  world.RemoveInstance(0);
  StepFor(world, 1);
  EXPECT_NEAR(world.X_WO(1).translation().z(), 0.0255, 2e-4);
}

PhysicsOptions ReusingContacts() {
  PhysicsOptions options;
  options.contact_reuse_m = 0.0001;
  return options;
}

TEST(PhysicsWorld, ReusedContactsCarryAndRelease) {
  PhysicsWorld world(ReusingContacts());
  AddTable(world);
  const auto cube = BoxObject(Vector3d::Constant(0.05), 0.1);
  world.AddInstance(*cube, Translation({0, 0, 0.03}));
  world.AddInstance(*cube, Translation({0, 0, 0.09}));
  world.ForbidSleep();
  StepFor(world, 2);
  EXPECT_NEAR(world.X_WO(0).translation().z(), 0.0255, 2e-4);
  EXPECT_NEAR(world.X_WO(1).translation().z(), 0.0765, 4e-4);
  world.RemoveInstance(0);
  StepFor(world, 1);
  EXPECT_NEAR(world.X_WO(1).translation().z(), 0.0255, 2e-4);
}

// A slowly moving body still collides with its neighbor.
TEST(PhysicsWorld, ReusedContactsFindASlowNeighbor) {
  PhysicsOptions options = ReusingContacts();
  options.gravity_W.setZero();
  PhysicsWorld world(options);
  const auto cube = BoxObject(Vector3d::Constant(0.05), 0.1);
  world.AddInstance(*cube, Pose::Identity());
  world.AddInstance(*cube, Translation({0.056, 0, 0}), BodyMode::kDynamic,
                    {{-0.01, 0, 0}, Vector3d::Zero()});
  world.ForbidSleep();
  StepFor(world, 2);
  EXPECT_LT(world.X_WO(0).translation().x(), -0.001);
  EXPECT_GT((world.X_WO(1).translation() - world.X_WO(0).translation()).norm(), 0.05);
}

TEST(PhysicsWorld, ForgetContactsWakesAllWithoutMotion) {
  PhysicsWorld world(ReusingContacts());
  AddTable(world);
  const auto cube = BoxObject(Vector3d::Constant(0.05), 0.1);
  world.AddInstance(*cube, Translation({0, 0, 0.0255}));
  world.AddInstance(*cube, Translation({0, 0, 0.0765}));
  StepFor(world, 2);
  ASSERT_TRUE(world.AllAsleep());
  world.ForgetContacts();
  EXPECT_FALSE(world.AllAsleep());
  StepFor(world, 1);
  EXPECT_NEAR(world.X_WO(1).translation().z(), 0.0765, 4e-4);
}

TEST(PhysicsWorld, BodyOnTheFunnelFallsWhenTheFunnelIsRemoved) {
  PhysicsWorld world;
  Bin bin;
  world.AddBin(bin);
  world.AddFunnel(bin, 0.1);
  const double top_m = bin.inner_size_m.z() + 0.1;
  const auto cube = BoxObject(Vector3d::Constant(0.03), 0.1);
  world.AddInstance(*cube, Translation({0.22, 0, top_m + 0.016}));
  StepFor(world, 2);
  ASSERT_TRUE(world.AllAsleep());
  EXPECT_GT(world.X_WO(0).translation().z(), top_m);
  world.RemoveFunnel();
  StepFor(world, 0.5);
  EXPECT_LT(world.X_WO(0).translation().z(), top_m - 0.05);
}

TEST(PhysicsWorld, ForbidSleepKeepsBodiesAwake) {
  PhysicsWorld world;
  AddTable(world);
  world.AddInstance(*BoxObject(Vector3d::Constant(0.05), 0.1), Translation({0, 0, 0.0255}));
  world.ForbidSleep();
  StepFor(world, 3);
  EXPECT_FALSE(world.AllAsleep());
}

TEST(PhysicsWorld, DetectsImplausibleSpeed) {
  PhysicsWorld world;
  const auto cube = BoxObject(Vector3d::Constant(0.05), 0.1);
  world.AddInstance(*cube, Pose::Identity(), BodyMode::kDynamic, {{49, 0, 0}, Vector3d::Zero()});
  EXPECT_FALSE(world.BlewUp());
  world.AddInstance(*cube, Translation({1, 0, 0}), BodyMode::kDynamic,
                    {{51, 0, 0}, Vector3d::Zero()});
  EXPECT_TRUE(world.BlewUp());
}

TEST(PhysicsWorld, ObjectWithoutPiecesIsALogicError) {
  PhysicsWorld world;
  ObjectModel bare = *BracketObject();
  bare.convex_pieces_O.clear();
  EXPECT_THROW(world.AddInstance(bare, Pose::Identity()), std::logic_error);
}

// Poses and velocities of a heap that is still in motion.
struct Snapshot {
  std::vector<Pose> X_WO;
  std::vector<Twist> V_WO;
};

Snapshot Take(const PhysicsWorld& world) {
  Snapshot snapshot;
  for (int i = 0; i < world.instance_count(); ++i) {
    snapshot.X_WO.push_back(world.X_WO(i));
    snapshot.V_WO.push_back(world.V_WO(i));
  }
  return snapshot;
}

std::unique_ptr<PhysicsWorld> Build(const Snapshot& snapshot, const ObjectSet& objects) {
  auto world = std::make_unique<PhysicsWorld>();
  world->AddBin(Bin{});
  for (size_t i = 0; i < snapshot.X_WO.size(); ++i) {
    world->AddInstance(*objects[i % objects.size()], snapshot.X_WO[i], BodyMode::kDynamic,
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

TEST(PhysicsWorldDeterminism, RebuiltWorldRepeatsExactly) {
  const ObjectSet objects = MixedObjects();
  const auto first = Build(Heap(), objects);
  StepFor(*first, 0.5);
  const Snapshot midway = Take(*first);
  std::vector<Snapshot> ends;
  for (int i = 0; i < 2; ++i) {
    const auto rebuilt = Build(midway, objects);
    StepFor(*rebuilt, 0.5);
    ends.push_back(Take(*rebuilt));
  }
  EXPECT_TRUE(SameBits(ends[0], ends[1]));
  EXPECT_FALSE(SameBits(ends[0], midway));
}

TEST(PhysicsWorldDeterminism, WorldsAreIndependent) {
  const ObjectSet objects = MixedObjects();
  const auto single = Build(Heap(), objects);
  StepFor(*single, 1);
  const Snapshot expected = Take(*single);

  PhysicsOptions other_options;
  other_options.rate_hz = 120;
  other_options.sleep_after_s = 0.1;
  PhysicsWorld other(other_options);
  other.AddBin(Bin{});
  const auto world = Build(Heap(), objects);
  for (int i = 0; i < 240; ++i) {
    if (i % 30 == 0) other.AddInstance(*objects[1], Translation({0, 0, 0.2 + 0.001 * i}));
    other.Step();
    world->Step();
  }
  EXPECT_TRUE(SameBits(Take(*world), expected));
}

}  // namespace
}  // namespace pickbed::tests
